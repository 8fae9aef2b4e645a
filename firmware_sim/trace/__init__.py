"""Every packet, written down for people to read."""
