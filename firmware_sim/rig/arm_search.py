"""Where the description of an arm is found by its name."""

from __future__ import annotations

import os
from pathlib import Path

from firmware_sim.errors import RigError


def find_arm(name: str, calibration: Path | None) -> Path:
    """Return the description of an arm.

    Parameters
    ----------
    name : str
        The file's name without ``.toml``.
    calibration : Path or None
        The only folder to look in, if given; else ``$ARMSYN_CALIBRATION``, ``./calibration``,
        ``armsyn/calibration`` in ``$XDG_CONFIG_HOME`` or ``~/.config``, and the folders beside this
        package where a checkout and a wheel keep them: the order in which armsyn looks for it.

    Returns
    -------
    Path
        The first such file that exists.

    Raises
    ------
    RigError
        If there is none, or the name is a path.
    """
    if not name or Path(name).name != name or name.startswith("."):
        raise RigError(f"--arm {name!r} is a path, not a name: use --rig for a file")
    folders = [calibration] if calibration is not None else _calibration_folders()
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    searched = ", ".join(str(folder) for folder in folders)
    raise RigError(f"no arm {name!r}: {name}.toml is in none of {searched}")


def _calibration_folders() -> list[Path]:
    packages = Path(__file__).resolve().parents[2]
    named = os.environ.get("ARMSYN_CALIBRATION")
    return [
        *([Path(named)] if named else []),
        Path("calibration"),
        *_user_folders(),
        packages / "armsyn" / "calibration",
        packages / "calibration",
    ]


def _user_folders() -> list[Path]:
    """The user's own folder, if there is one: a relative ``$XDG_CONFIG_HOME`` is ignored."""
    configured = Path(os.environ.get("XDG_CONFIG_HOME") or "")
    try:
        root = configured if configured.is_absolute() else Path.home() / ".config"
    except RuntimeError:  # the user has no home
        return []
    return [root / "armsyn" / "calibration"]
