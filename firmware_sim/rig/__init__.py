"""Which servos to simulate, and what feeds and holds them."""
