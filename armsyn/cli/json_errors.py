"""Errors as JSON documents, for programs that call commands with ``--json``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from armsyn.errors import ArmsynError


class DocumentedError(Exception):
    """What failed after a command had something to tell: both go into one document.

    Parameters
    ----------
    error : ArmsynError
        What failed.
    document : dict
        What the command has to tell.
    """

    def __init__(self, error: ArmsynError, document: dict[str, Any]) -> None:
        super().__init__(str(error))
        self.error = error
        self.document = document


def document_of(error: BaseException, line: str, status: int, told: dict[str, Any]) -> str:
    """Return an error as a JSON document.

    Parameters
    ----------
    error : Exception
    line : str
        Its one line.
    status : int
        Exit status.
    told : dict
        What stands in the document beside it.

    Returns
    -------
    str
        ``{"error": {"type", "message", "exit_status", ...}}``, then the fields that carry an
        `ArmsynError`'s evidence, in their SI units; None for what is not finite.
    """
    import json

    evidence = vars(error) if isinstance(error, ArmsynError) else {}
    found = {
        "type": type(error).__name__,
        "message": line,
        "exit_status": status,
        **{key: _plain(value) for key, value in evidence.items() if not key.startswith("_")},
    }
    return json.dumps({**told, "error": found}, indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if hasattr(value, "tolist"):  # of numpy, which is not imported for this
        value = value.tolist()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    return str(value)
