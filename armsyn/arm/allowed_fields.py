"""Which fields a description allows where an unknown one stands."""

from __future__ import annotations

import re
from typing import Any, get_args

import msgspec

from armsyn.errors import meant

_UNKNOWN = re.compile(r"unknown field `([^`]*)`(?: - at `\$\.?([^`]*)`)?")


def allowed_instead(message: str, whole: type[msgspec.Struct]) -> str:
    """Return what is allowed instead of an unknown field, for the end of a message.

    Parameters
    ----------
    message : str
        Of ``msgspec.ValidationError``, with the field and its path.
    whole : type of msgspec.Struct
        What was converted to.

    Returns
    -------
    str
        "; allowed are ..." with the nearest name, "" where the message is of something else.
    """
    found = _UNKNOWN.search(message)
    if found is None:
        return ""
    table: type[msgspec.Struct] | None = whole
    for name in re.findall(r"[A-Za-z_]\w*", found[2] or ""):
        table = None if table is None else _table(_types(table).get(name))
    if table is None:
        return ""
    names = list(_types(table))
    return f"; allowed are {', '.join(names)}{meant(found[1], names)}"


def _types(table: type[msgspec.Struct]) -> dict[str, Any]:
    return {field.encode_name: field.type for field in msgspec.structs.fields(table)}


def _table(kind: Any) -> type[msgspec.Struct] | None:
    """The table that a field's type holds, within tuples, unions and annotations."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return kind
    inner = (_table(part) for part in get_args(kind))
    return next((table for table in inner if table is not None), None)
