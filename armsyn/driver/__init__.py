"""Talking to an arm: bus, checks before torque, streaming, recording."""
