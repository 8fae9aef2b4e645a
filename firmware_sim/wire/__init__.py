"""Bytes and what they mean: packets of both protocols, and the wire they share."""
