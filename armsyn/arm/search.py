"""Where an arm's files are looked for."""

from __future__ import annotations

import os
import re
from pathlib import Path

from armsyn.errors import DescriptionError, meant

ENVIRONMENT_VARIABLE = "ARMSYN_CALIBRATION"
ATLAS = ".atlas.json"
SYNERGIES = ".synergies.json"
HERE = Path("calibration")
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


def user_folder() -> Path | None:
    """The user's own folder for arms' files, the same from wherever a command runs.

    Returns
    -------
    Path or None
        ``armsyn/calibration`` in ``$XDG_CONFIG_HOME``, or in ``~/.config``; None where the user
        has no home.
    """
    configured = Path(os.environ.get("XDG_CONFIG_HOME") or "")
    try:
        root = configured if configured.is_absolute() else Path.home() / ".config"
    except RuntimeError:
        return None
    return root / "armsyn" / "calibration"


def search_path(directory: Path | None = None) -> tuple[Path, ...]:
    """Directories that may hold an arm's files, the first to be searched first.

    Parameters
    ----------
    directory : Path, optional
        The only one to search, when given (``--calibration DIR``).

    Returns
    -------
    tuple of Path
        `directory`; else ``$ARMSYN_CALIBRATION``, ``./calibration``, `user_folder`, the copies
        packaged with the wheel, and the project's own ``calibration`` folder beside the package.
    """
    if directory is not None:
        return (directory,)
    package = Path(__file__).resolve().parents[1]
    packaged = [package / "calibration", package.parent / "calibration"]
    places = [HERE, *([own] if (own := user_folder()) else []), *packaged]
    from_environment = os.environ.get(ENVIRONMENT_VARIABLE)
    if from_environment:
        places.insert(0, Path(from_environment))
    return tuple(places)


def check_name(name: str) -> None:
    """Refuse what is no arm's name: letters, digits, ``-`` and ``_``, at most 64.

    Raises
    ------
    DescriptionError
    """
    if not _NAME.fullmatch(name):
        raise DescriptionError(f"{name!r} is not the name of an arm: letters, digits, - and _ only")


def find_file(name: str, suffix: str, directory: Path | None = None) -> Path:
    """Find ``<name><suffix>`` on the search path.

    Parameters
    ----------
    name : str
        An arm's name: letters, digits, ``-`` and ``_``.
    suffix : str
        Such as ``.toml`` or ``.synergies.json``.
    directory : Path, optional
        Search only here.

    Returns
    -------
    Path

    Raises
    ------
    DescriptionError
        No such file, or a name that is no name (a path, say).
    """
    check_name(name)
    places = search_path(directory)
    for place in places:
        if (place / f"{name}{suffix}").is_file():
            return place / f"{name}{suffix}"
    names = arm_names(directory)
    cure = f"arms found: {', '.join(names) or 'none'}"
    if name not in names:
        cure += meant(name, names)
    other = _elsewhere(name, suffix) if directory is not None and name not in names else None
    if other is not None:
        cure = f"only the folder that is named is searched: copy {other} there"
    elif suffix == SYNERGIES and name in names:
        cure = f"run armsyn learn --arm {name} --captures garza:all, see README.md"
    elif suffix == ATLAS and name in names:
        cure = f"run armsyn learn --arm {name} --atlas, see README.md"
    searched = ", ".join(str(place) for place in dict.fromkeys(places))
    raise DescriptionError(f"no {name}{suffix} in {searched} ({cure})")


def _elsewhere(name: str, suffix: str) -> Path | None:
    """Where a file would be found if no folder were named."""
    files = (place / f"{name}{suffix}" for place in search_path())
    return next((file for file in files if file.is_file()), None)


def arm_names(directory: Path | None = None) -> list[str]:
    """Names of all arms described on the search path, sorted."""
    return sorted({file.stem for place in search_path(directory) for file in place.glob("*.toml")})
