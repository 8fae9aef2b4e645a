"""The models that can be simulated, one file each.

A file exposes ``MODELS``, the layouts of its control table, newest firmware first. It is read when
its model is first asked for, so that a start costs only what it needs. MX servos have two files:
their firmwares for protocol 1.0 and 2.0 have different tables and model numbers.

Not here: XW540-H260, whose motor figures are in no page that could be read.
"""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from importlib import import_module

from firmware_sim.errors import RigError
from firmware_sim.firmware.model import ServoModel

MODEL_NAMES = (
    "xl330-m077",
    "xl330-m288",
    "xc330-m181",
    "xc330-m288",
    "xc330-t181",
    "xc330-t288",
    "xl430-w250",
    "2xl430-w250",
    "xc430-w150",
    "xc430-w240",
    "2xc430-w250",
    "xm430-w210",
    "xm430-w350",
    "xm540-w150",
    "xm540-w270",
    "xh430-w210",
    "xh430-w350",
    "xh430-v210",
    "xh430-v350",
    "xh540-w150",
    "xh540-w270",
    "xh540-v150",
    "xh540-v270",
    "xd430-t210",
    "xd430-t350",
    "xd540-t150",
    "xd540-t270",
    "xw430-t200",
    "xw430-t333",
    "xw540-t140",
    "xw540-t260",
    "mx-28",
    "mx-64",
    "mx-106",
    "ax-12a",
    "ax-18a",
    "xl-320",
)
"""The maker's names in lower case."""

_FILES = {
    "2xl430-w250": ("two_xl430_w250",),
    "2xc430-w250": ("two_xc430_w250",),
    "mx-28": ("mx_28", "mx_28_2"),
    "mx-64": ("mx_64", "mx_64_2"),
    "mx-106": ("mx_106", "mx_106_2"),
}
"""Where a model is whose file has not its name; the first is what the maker sells."""

_LAST_FIRMWARE = 255
"""Firmware Version is one byte."""


def find_model(name: str, firmware: int | None = None, protocol: int | None = None) -> ServoModel:
    """Return a model by its maker's name.

    Parameters
    ----------
    name : str
        For instance ``"xm430-w350"``; upper case is taken too.
    firmware : int, optional
        Version whose table is wanted and that is reported; by default the newest.
    protocol : int, optional
        1 or 2, which the servo must be able to speak: decides which firmware an MX has. By default
        what the maker sells. An X-series servo is the same with both, it has a Protocol Type(13).

    Returns
    -------
    ServoModel
        The model with its control table.

    Raises
    ------
    RigError
        If there is no such model, or none with this firmware or protocol; its field says which.
    """
    lower = name.lower()
    if lower not in MODEL_NAMES:
        raise RigError(_unknown(name), field="model")
    layouts = _speaking(lower, protocol)
    if firmware is None:
        return layouts[0]
    for model in layouts:
        last = _LAST_FIRMWARE if model.last_firmware is None else model.last_firmware
        if model.first_firmware <= firmware <= last:
            return replace(model, firmware=firmware)
    first = min(model.first_firmware for model in layouts)
    raise RigError(
        f"firmware = {firmware} of {lower} is not a known one: use {first} to {_LAST_FIRMWARE}",
        field="firmware",
    )


def _unknown(name: str) -> str:
    close = get_close_matches(name.lower(), MODEL_NAMES)
    known = (
        f"did you mean {' or '.join(close)}?" if close else f"use one of {', '.join(MODEL_NAMES)}"
    )
    return f"unknown servo model {name!r}: {known}"


def _speaking(name: str, protocol: int | None) -> tuple[ServoModel, ...]:
    """Return a model's layouts of the first file whose firmware speaks a protocol."""
    found = [_layouts(file) for file in _FILES.get(name, (name.replace("-", "_"),))]
    if protocol is None:
        return found[0]
    native = [layouts for layouts in found if layouts[0].protocol == protocol]
    able = [layouts for layouts in found if protocol in layouts[0].protocols]
    if not able:
        raise RigError(f"{name} does not speak protocol {protocol}.0", field="protocol")
    return (native or able)[0]


def _layouts(file: str) -> tuple[ServoModel, ...]:
    layouts: tuple[ServoModel, ...] = import_module(f"firmware_sim.tables.{file}").MODELS
    return layouts
