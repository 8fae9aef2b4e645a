"""What goes on in a servo: registers, rules, modes, errors, and the world it stands in."""
