"""What commands that work for minutes share: bars of progress, and a record of the run."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any


class StageBars(AbstractContextManager["StageBars"]):
    """A bar for each stage of the work, on standard error."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        self._bars = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed}/{task.total}"),
            TextColumn("{task.fields[said]}"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
        )
        self._tasks: dict[str, Any] = {}

    def __enter__(self) -> StageBars:
        return self

    def __exit__(self, *_: object) -> None:
        if self._tasks:
            self._bars.stop()

    def update(self, name: str, done: int, total: int, said: str) -> None:
        """Show how far a stage is; a stage of another name ends the earlier ones.

        Parameters
        ----------
        name : str
            Of the stage.
        done, total : int
            How far, of how much.
        said : str
            A remark beside the bar.
        """
        if not self._tasks:  # nothing is shown where input is refused
            self._bars.start()
        if name not in self._tasks:
            for earlier in self._tasks.values():
                self._bars.update(earlier, total=self._bars.tasks[earlier].completed)
                self._bars.stop_task(earlier)
            self._tasks[name] = self._bars.add_task(name, total=total, said="")
        self._bars.update(self._tasks[name], completed=done, said=said)


def write_run(out: Path) -> None:
    """Write command line, host and time beside a result, which so is the same bytes anywhere.

    Parameters
    ----------
    out : Path
        The result, such as ``NAME.json``; this goes to ``NAME.run.json``.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    import datetime
    import json
    import platform
    import sys

    import armsyn
    from armsyn.motion.formats.files import replacing

    run = {
        "schema": "armsyn-run-1",
        "command": ["armsyn", *sys.argv[1:]],
        "version": armsyn.__version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "time": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }
    path = out.with_name(f"{out.name.removesuffix('.json')}.run.json")
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(run, indent=1) + "\n", encoding="utf-8")
