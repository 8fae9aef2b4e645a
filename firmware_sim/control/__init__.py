"""Faults and questions at run time, over a loopback socket."""
