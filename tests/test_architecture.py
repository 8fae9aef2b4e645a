"""The rooms and who may import whom (the tower in CONTRIBUTING.md), read from the imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
TOWER = [  # lowest first; a room may import rooms at or below its own step
    {"errors"},
    {"kernels"},
    {"kinematics"},
    {"arm"},
    {"safety"},
    {"ik"},
    {"motion"},
    {"scoring"},
    {"synergy"},
    {"editing"},
    {"planning"},
    {"view", "experiments"},
    {"cli"},
]
SIMULATOR_TOWER = [  # the same of firmware_sim; top-level modules are named as themselves
    {"errors", "clock", "files"},
    {"physics"},
    {"firmware"},
    {"tables", "classic"},
    {"wire"},
    {"rig"},
    {"faults"},
    {"simulation"},
    {"trace", "control"},
    {"assembly"},
    {"stepped"},
    {"stepped_serial"},
    {"command", "testing"},
    {"__main__", "pytest_plugin"},
]
DRIVER_MAY_IMPORT = {"driver", "motion", "safety", "arm", "kinematics", "errors"}
FILES = sorted([*(ROOT / "armsyn").rglob("*.py"), *(ROOT / "firmware_sim").rglob("*.py")])


def imported_modules(path: Path) -> Iterator[str]:
    package = path.relative_to(ROOT).with_suffix("").parts
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parent = ".".join(package[: -node.level]) if node.level else ""
            module = ".".join(filter(None, [parent, node.module or ""]))
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)


def room_of(module: str) -> str | None:
    parts = module.split(".")
    return parts[1] if parts[0] == "armsyn" and len(parts) > 1 else None


def step_of(room: str) -> int:
    return next(step for step, rooms in enumerate(TOWER) if room in rooms)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_go_down_the_tower(path: Path) -> None:
    parts = path.relative_to(ROOT).with_suffix("").parts
    modules = set(imported_modules(path))
    known = {room for rooms in TOWER for room in rooms} | {"driver"}
    if parts[0] == "firmware_sim":
        assert not [m for m in modules if m.split(".")[0] in {"armsyn", "dynamixel_sdk"}]
        return
    room = parts[1]
    rooms = {r for m in modules if (r := room_of(m)) in known}
    if room == "__init__":
        assert not rooms
    elif room == "driver":
        assert rooms <= DRIVER_MAY_IMPORT
    elif room in ("cli", "__main__"):
        assert rooms <= known
    else:
        assert "driver" not in rooms
        assert all(step_of(r) <= step_of(room) for r in rooms), rooms
    if room not in ("cli", "__main__"):
        assert not [m for m in modules if m.split(".")[0] == "firmware_sim"]
    if parts[1:] != ("driver", "bus"):
        assert not [m for m in modules if m.split(".")[0] == "dynamixel_sdk"]


def test_every_room_is_in_the_tower() -> None:
    known = {room for rooms in TOWER for room in rooms} | {"driver"}
    rooms = {p.name for p in (ROOT / "armsyn").iterdir() if (p / "__init__.py").is_file()}
    assert rooms <= known


SIMULATOR_FILES = [path for path in FILES if path.relative_to(ROOT).parts[0] == "firmware_sim"]


@pytest.mark.parametrize("path", SIMULATOR_FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_simulators_imports_go_down_its_tower(path: Path) -> None:
    step = {room: number for number, rooms in enumerate(SIMULATOR_TOWER) for room in rooms}
    own = path.relative_to(ROOT).with_suffix("").parts[1]
    for module in imported_modules(path):
        parts = module.split(".")
        if parts[0] == "firmware_sim" and len(parts) > 1 and own != "__init__":
            assert step[parts[1]] <= step[own], module
