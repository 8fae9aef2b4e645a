"""Servos older than the X series: AX and MX with protocol 1.0, and XL-320."""
