"""The command ``firmware-sim``: arguments, port, loop, table, state."""
