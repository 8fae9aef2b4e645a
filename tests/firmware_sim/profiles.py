"""Where a profile is at a time, worked out from its pieces apart from the physics."""

from firmware_sim.physics.profile import Profile


def at(profile: Profile, elapsed: float) -> tuple[float, float]:
    """Return position (rad) and velocity (rad/s) at a time since the profile's start (s)."""
    if elapsed >= profile.duration:
        return profile.goal, 0.0
    for begin, position, velocity, acceleration in reversed(profile.pieces):
        if elapsed >= begin:
            since = elapsed - begin
            return (
                position + (velocity + 0.5 * acceleration * since) * since,
                velocity + acceleration * since,
            )
    return profile.pieces[0][1], profile.pieces[0][2]
