"""Motors, gears, heat and control loops of all servos, advanced together by compiled code."""
