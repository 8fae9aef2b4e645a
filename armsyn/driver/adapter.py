"""The latency timer of a USB serial adapter, as Linux shows it.

An FTDI adapter keeps what it has received until a USB packet is full or this timer runs out: 16 ms
as it comes, 1 ms in low-latency mode, which the port asks for when it is opened. Source: FTDI,
AN232B-04, "Data Throughput, Latency and Handshaking", section 3; Linux, ``ftdi_sio``.
"""

from __future__ import annotations

from pathlib import Path

SYSFS = Path("/sys")

_TIMERS = (
    "class/tty/{name}/device/latency_timer",
    "bus/usb-serial/devices/{name}/latency_timer",
)


def adapter_latency(port: str, sysfs: Path = SYSFS) -> float:
    """How long the adapter behind a port may keep bytes to itself.

    Parameters
    ----------
    port : str
        Path of the port; links are followed.
    sysfs : Path
        Where the system shows its devices.

    Returns
    -------
    float
        s; 0 where the adapter has no such timer.
    """
    name = Path(port).resolve().name
    for timer in _TIMERS:
        try:
            text = (sysfs / timer.format(name=name)).read_text(encoding="ascii").strip()
        except OSError:  # most ports have none
            continue
        if text.isdecimal():
            return int(text) * 1e-3
    return 0.0
