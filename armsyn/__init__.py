"""Human-like reaching for Dynamixel arms.

A target in space becomes a human-like reach (synergy inverse kinematics, learned from
captured people), which is checked, streamed to the arm, recorded, and scored against
human movement.
"""

__version__ = "0.1.0"
