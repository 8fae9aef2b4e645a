"""Control loops, motors and heat of all axes, compiled: one call for all axes and many steps.

Everything compiled stands in this one file, so that numba's cache on disk, which compares the file
only, is never stale. An axis is one row of `state`, whose columns are named below; a supply is one
row of `supplies`. All is in SI units at the horn, counter-clockwise positive.

The winding has no inductance: current is what the voltage and the back-EMF leave over,

    i = (u V - ke w) / R,    J dw/dt = kt i - b w - T - Tf sign(w)

with duty u, voltage at the terminals V, speed w, load T, drag b and Coulomb friction Tf. Within a
step of 1 ms u, V and T are constant, so w is an exponential, and a step is exact; where w passes
through zero the step is cut there, and the gears stick unless the torque beats static friction.

Loops: e-Manual, "Position PID Gain(80, 82, 84)", "Velocity PI Gain(76, 78)" and "Goal Current"
for their block diagrams; the gains contain the control period, as the manual says of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., Any])

STEP = 1.0e-3
"""Length of one step of physics and of the control loops, s."""

AMBIENT_TEMPERATURE = 25.0
"""Of the air, degrees Celsius."""

STATIC_FRICTION = 1.2
"""Static over Coulomb friction of the gears; chosen."""

FULL_EFFORT = 0.9
"""Duty from which a horn that does not give way is overloaded; chosen. A lower cap of duty or
current, as grippers have, never overloads ("Shutdown(63)": a load beyond the maximum output)."""

HAND_LAG = 0.1
"""Time in which a hand makes up for what its joint is off, s; chosen."""

HAND_ACCELERATION = 10.0
"""With which a hand begins to move, and at most ends, rad/s^2; chosen."""

HAND_SLIP = 0.02
"""By how much a joint must be slower than the hand for its full torque, rad/s; chosen."""

# Modes of control.
OFF, DUTY, CURRENT, VELOCITY, POSITION, COMPLIANCE = range(6)

# How an axis is linked: it turns by itself; it is the base of all on its joint, or something from
# outside holds it; its shaft turns with that of its base.
FREE, LEADS, FOLLOWS = range(3)

# Columns of `state`: what is sensed, ...
(
    ANGLE,  # of the horn, rad
    SPEED,  # of the horn, rad/s
    AMPERES,  # through the winding, mean of the last step, A
    EFFORT,  # duty of the PWM, -1 to 1
    TEMPERATURE,  # of the winding, degrees Celsius
    VOLTAGE,  # at the terminals, V
    TICKS,  # of the encoder, over all turns
    REFERENCE,  # trajectory: rad, rad/s, rad/s^2
    REFERENCE_SPEED,
    REFERENCE_ACCELERATION,
    GOAL,  # where the trajectory ends, rad
    UNDER_WAY,  # 1 while a profile is in progress
    KIND,  # its shape, a ProfileType
    SATURATED_FOR,  # s of full effort while nearly standing or pushed back
    SETTLED,  # 1 when nothing will move until the next command
    MODE,
    # ... what is commanded, ...
    TARGET,  # duty, A or rad/s, by the mode
    RAMP,  # acceleration of the velocity trajectory, rad/s^2; 0 for none
    DUTY_CAP,
    CURRENT_CAP,
    SENSES_INPUT,  # 1 when currents are those taken from the supply, not the winding's
    SLOPE,  # by how much the voltage may change in a step, V
    POSITION_P,  # duty per rad
    POSITION_I,  # duty per rad and step
    POSITION_D,  # duty per rad of change within a step
    FEEDFORWARD_1,  # duty per rad/s
    FEEDFORWARD_2,  # duty per rad/s^2
    VELOCITY_P,  # duty per rad/s
    VELOCITY_I,  # duty per rad/s and step
    MARGIN_UP,  # compliance where it pushes counter-clockwise, rad, duty per rad
    SLOPE_UP,
    MARGIN_DOWN,  # and clockwise
    SLOPE_DOWN,
    PUNCH,  # duty at the edge of the margin
    LOAD,  # external torque against the positive direction, N m
    SOURCE,  # voltage of the supply without current, V
    JAMMED,  # 1 when the horn cannot move
    ENCODER_STUCK,  # 1 when the encoder counts no more
    FRICTION_FACTOR,
    # ... the profile: how long it runs, and its pieces, ...
    ELAPSED,
    DURATION,
    PIECES,  # how many
    PIECE_1,  # begin, position, velocity, acceleration
    _PIECE_1B,
    _PIECE_1C,
    _PIECE_1D,
    PIECE_2,
    _PIECE_2B,
    _PIECE_2C,
    _PIECE_2D,
    PIECE_3,
    _PIECE_3B,
    _PIECE_3C,
    _PIECE_3D,
    # ... what the loops remember, ...
    INTEGRAL,  # duty
    LAST_REFERENCE,
    LAST_SPEED,
    DEMAND,  # duty that the loop asked for, before its caps
    LAST_DEMAND,
    # ... the motor, ...
    MOTOR_ANGLE,  # before the backlash, rad
    MOTOR_SPEED,
    RESISTANCE,  # of the winding, ohm
    THERMAL_RESISTANCE,  # winding to air, K/W
    THERMAL_TIME,  # time constant of warming, s
    WARMING,  # which share of the way to its last temperature it goes in a step
    TORQUE_CONSTANT,  # N m/A
    BACK_EMF,  # V per rad/s
    INERTIA,  # kg m^2
    DRAG,  # N m per rad/s
    FRICTION,  # N m
    BACKLASH,  # rad
    ENCODER_STEP,  # rad
    DRIVEN_LAG,  # time constant of the speed, s, and what a step leaves of a deviation
    DRIVEN_KEPT,
    FREE_LAG,
    FREE_KEPT,
    NEARLY_STANDING,  # rad/s
    SUPPLY,  # which row of `supplies`
    # ... and what its firmware looks into as soon as it is passed.
    HOTTEST,  # degrees Celsius
    LOWEST_VOLTAGE,  # V
    HIGHEST_VOLTAGE,
    ENCODER_SLACK,  # rad
    # What else there is to its joint: other shafts, ...
    LINK,
    BASE,  # which axis its shaft turns with
    GEAR,  # -1 where it turns the opposite way, else 1
    STOP_LOW,  # ... what stops the horn, rad, ...
    STOP_HIGH,
    HAND_GOAL,  # ... and a person's hand: where it turns the horn, rad, ...
    HAND_SPEED,  # how fast at most, rad/s,
    HAND_TORQUE,  # with how much at most, N m; 0 for no hand,
    HAND_RATE,  # how fast at present, rad/s,
    HAND_GRIP,  # and how firmly, N m per rad/s of slip
    COLUMNS,
) = range(93)

# Columns of `supplies`: resistance of the source, sums over its axes, sag.
SOURCE_RESISTANCE, _PULL, _CONDUCTANCE, SAG, SUPPLY_COLUMNS = range(5)

_NO_VOLTAGE = 1.0e-3
"""What loops divide by at least, V."""

SAME_DUTY = 1.0e-12
"""Change of a loop's output from step to step that counts as none."""

_SAME_RATE = 1.0e-12
"""Change of a hand's speed from step to step that counts as none, rad/s."""

_HARDLY_MOVING = 1.0e-5
"""Speed at which a joint in a hand stands, rad/s."""

_SAME_VOLTAGE = 1.0e-9
"""Change of the supply that wakes no loop, V."""


def compiled(function: Function) -> Function:
    """Return a function as numba compiles it, kept on disk where that is possible."""
    try:
        quick = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:
        # No directory for the cache can be written (an installation without a home): numba
        # refuses to decorate at all then. Compiling anew at each start is slower, not wrong.
        quick = numba.njit(cache=False, error_model="numpy")(function)
    return cast(Function, quick)


@compiled
def _follow_profile(x: FloatArray) -> None:
    """Bring the trajectory of position on by one step."""
    elapsed = x[ELAPSED] + STEP
    x[ELAPSED] = elapsed
    if elapsed >= x[DURATION]:
        x[UNDER_WAY] = 0.0
        x[REFERENCE] = x[GOAL]
        x[REFERENCE_SPEED] = 0.0
        x[REFERENCE_ACCELERATION] = 0.0
        return
    piece = PIECE_1
    for k in range(1, int(x[PIECES])):
        if elapsed >= x[PIECE_1 + 4 * k]:
            piece = PIECE_1 + 4 * k
    since = elapsed - x[piece]
    speed = x[piece + 2]
    acceleration = x[piece + 3]
    x[REFERENCE] = x[piece + 1] + (speed + 0.5 * acceleration * since) * since
    x[REFERENCE_SPEED] = speed + acceleration * since
    x[REFERENCE_ACCELERATION] = acceleration


@compiled
def _measured_angle(x: FloatArray) -> float:
    return float(x[TICKS] * x[ENCODER_STEP])


@compiled
def _measured_speed(x: FloatArray) -> float:
    return 0.0 if x[ENCODER_STUCK] else float(x[SPEED])


@compiled
def _integrated(x: FloatArray, increment: float, rest: float, low: float, high: float) -> float:
    """Return the integral after a sum of the error, unless that pushes a full output further."""
    total = x[INTEGRAL] + increment
    output = rest + total
    if low < output < high or (output >= high) != (increment > 0.0):
        x[INTEGRAL] = total
    return float(x[INTEGRAL])


@compiled
def _position_loop(x: FloatArray, low: float, high: float) -> float:
    """Return the duty of PID controller and feed-forward."""
    if x[UNDER_WAY]:
        _follow_profile(x)
    reference = x[REFERENCE]
    error = reference - _measured_angle(x)
    change = reference - x[LAST_REFERENCE] - _measured_speed(x) * STEP
    x[LAST_REFERENCE] = reference
    duty = (
        x[POSITION_P] * error
        + x[POSITION_D] * change
        + x[FEEDFORWARD_1] * x[REFERENCE_SPEED]
        + x[FEEDFORWARD_2] * x[REFERENCE_ACCELERATION]
    )
    if x[POSITION_I]:
        duty += _integrated(x, x[POSITION_I] * error, duty, low, high)
    return float(duty)


@compiled
def _velocity_loop(x: FloatArray, low: float, high: float) -> float:
    """Return the duty of the PI controller along a ramp to the goal."""
    way = x[TARGET] - x[REFERENCE_SPEED]
    ramp = x[RAMP] * STEP
    if ramp > 0.0 and abs(way) > ramp:
        x[REFERENCE_ACCELERATION] = math.copysign(x[RAMP], way)
        x[REFERENCE_SPEED] += math.copysign(ramp, way)
        x[UNDER_WAY] = 1.0
    else:
        x[REFERENCE_ACCELERATION] = 0.0
        x[REFERENCE_SPEED] = x[TARGET]
        x[UNDER_WAY] = 0.0
    error = x[REFERENCE_SPEED] - _measured_speed(x)
    duty = x[VELOCITY_P] * error
    if x[VELOCITY_I]:
        duty += _integrated(x, x[VELOCITY_I] * error, duty, low, high)
    return float(duty)


@compiled
def _compliance(x: FloatArray) -> float:
    """Return the duty that margin, punch and slope make of the error on its side."""
    if x[UNDER_WAY]:
        _follow_profile(x)
    error = x[REFERENCE] - _measured_angle(x)
    if error > x[MARGIN_UP]:
        return float(x[PUNCH] + (error - x[MARGIN_UP]) * x[SLOPE_UP])
    if error < -x[MARGIN_DOWN]:
        return float((error + x[MARGIN_DOWN]) * x[SLOPE_DOWN] - x[PUNCH])
    return 0.0


@compiled
def _duty_for(x: FloatArray, amperes: float, back_emf: float, voltage: float) -> float:
    """Return the duty that makes a current: of the winding, or of the supply where that is sensed.

    A supply gives |u| i with i = (u V - e) / R: of the two duties that make it so, the one that
    drives the way of the current.
    """
    drop = x[RESISTANCE] * amperes
    if not x[SENSES_INPUT] or amperes == 0.0:
        return float((back_emf + drop) / voltage)
    root = math.sqrt(back_emf * back_emf + 4.0 * voltage * abs(drop))
    return float((back_emf + math.copysign(root, amperes)) / (2.0 * voltage))


@compiled
def _sloped(x: FloatArray, duty: float, voltage: float) -> float:
    """Return the duty as near to what is wanted as the slope of the PWM allows in this step."""
    most = x[SLOPE] / voltage
    change = duty - x[EFFORT]
    if abs(change) <= most:
        return duty
    x[LAST_DEMAND] = math.inf  # not steady, however still it asks for the same
    return float(x[EFFORT] + math.copysign(most, change))


@compiled
def _controls_current(x: FloatArray) -> bool:
    return bool(x[MODE] == CURRENT or (x[MODE] != OFF and x[CURRENT_CAP] < math.inf))


@compiled
def _control(x: FloatArray) -> None:
    """Run an axis' control loop for one step: leaves a duty in EFFORT."""
    mode = x[MODE]
    x[LAST_DEMAND] = x[DEMAND]
    if mode == OFF:
        x[EFFORT] = x[DEMAND] = 0.0
        x[SATURATED_FOR] = 0.0
        return
    cap = x[DUTY_CAP]
    low, high = -cap, cap
    speed = x[MOTOR_SPEED]
    # The back-EMF half a step ahead, so that the mean current of a step is what is asked for.
    back_emf = x[BACK_EMF] * (speed + 0.5 * (speed - x[LAST_SPEED]))
    x[LAST_SPEED] = speed
    voltage = max(x[VOLTAGE], _NO_VOLTAGE)
    if x[CURRENT_CAP] < math.inf:
        low = max(low, min(cap, _duty_for(x, -x[CURRENT_CAP], back_emf, voltage)))
        high = min(high, max(-cap, _duty_for(x, x[CURRENT_CAP], back_emf, voltage)))
    if mode == POSITION:
        duty = _position_loop(x, low, high)
    elif mode == VELOCITY:
        duty = _velocity_loop(x, low, high)
    elif mode == CURRENT:
        duty = _duty_for(x, x[TARGET], back_emf, voltage)
    elif mode == COMPLIANCE:
        duty = _compliance(x)
    else:
        duty = x[TARGET]
    x[DEMAND] = duty
    effort = _sloped(x, max(low, min(high, duty)), voltage)
    x[EFFORT] = effort
    # Pushed back at full effort is overloaded as well as standing.
    along = math.copysign(speed, speed * effort)
    if abs(effort) >= FULL_EFFORT and along < x[NEARLY_STANDING]:
        x[SATURATED_FOR] += STEP
    else:
        x[SATURATED_FOR] = 0.0


@compiled
def _add_draw(x: FloatArray, supplies: FloatArray) -> None:
    """Add what an axis draws from its supply to the sums that the sag follows from."""
    duty = x[EFFORT]
    supply = int(x[SUPPLY])
    share = duty / x[RESISTANCE]
    supplies[supply, _PULL] += share * (duty * x[SOURCE] - x[BACK_EMF] * x[MOTOR_SPEED])
    supplies[supply, _CONDUCTANCE] += share * duty


@compiled
def _sag(supplies: FloatArray) -> None:
    """Solve for the voltage lost in each source: sag = Rs sum of u i, i = (u (E - sag) - ke w)/R.

    A PWM stage passes power on, so that its supply gives the duty times the winding's current.
    """
    for k in range(len(supplies)):
        resistance = supplies[k, SOURCE_RESISTANCE]
        supplies[k, SAG] = (
            resistance * supplies[k, _PULL] / (1.0 + resistance * supplies[k, _CONDUCTANCE])
        )
        supplies[k, _PULL] = 0.0
        supplies[k, _CONDUCTANCE] = 0.0


@compiled
def _turn(
    x: FloatArray, torque: float, friction: float, inertia: float, lag: float, kept: float
) -> None:
    """Move a motor for one step under a torque, with the speed-dependent part in `lag`."""
    per_torque = lag / inertia
    speed = x[MOTOR_SPEED]
    time = STEP
    way = 0.0
    if speed != 0.0:
        final = (torque - math.copysign(friction, speed)) * per_torque
        surplus = speed - final
        ahead = final + surplus * kept
        if ahead * speed > 0.0:
            x[MOTOR_SPEED] = ahead
            x[MOTOR_ANGLE] += final * STEP + surplus * lag * (1.0 - kept)
            return
        left = -final / surplus  # of the surplus when it stands
        until = -lag * math.log(left) if left > 0.0 else STEP
        until = min(until, STEP)
        way = final * until + surplus * lag * (1.0 - math.exp(-until / lag))
        time -= until
    if abs(torque) <= STATIC_FRICTION * friction:
        x[MOTOR_SPEED] = 0.0
    else:
        final = (torque - math.copysign(friction, torque)) * per_torque
        gone = 1.0 - math.exp(-time / lag)
        x[MOTOR_SPEED] = final * gone
        way += final * time - final * lag * gone
    x[MOTOR_ANGLE] += way


@compiled
def _standing_torque(x: FloatArray) -> float:
    """Return the motor's torque if it stood: the back-EMF takes its part as damping."""
    return float(x[TORQUE_CONSTANT] * x[EFFORT] * x[VOLTAGE] / x[RESISTANCE])


@compiled
def _carry_horn(x: FloatArray) -> None:
    """Let the horn follow its motor through the play of the gears, and the encoder the horn."""
    before = x[ANGLE]
    half = 0.5 * x[BACKLASH]
    angle = max(x[MOTOR_ANGLE] - half, min(x[MOTOR_ANGLE] + half, before))
    x[ANGLE] = angle
    x[SPEED] = x[MOTOR_SPEED] if angle != before or not half else 0.0
    if not x[ENCODER_STUCK]:
        x[TICKS] = math.floor(angle / x[ENCODER_STEP] + 0.5)


@compiled
def _warm(x: FloatArray, share: float) -> None:
    """Bring the winding by a share of the way to the temperature that its losses lead to."""
    losses = x[RESISTANCE] * x[AMPERES] * x[AMPERES]
    target = AMBIENT_TEMPERATURE + x[THERMAL_RESISTANCE] * losses
    x[TEMPERATURE] += (target - x[TEMPERATURE]) * share


@compiled
def _settle_accounts(x: FloatArray, mean_speed: float) -> None:
    """Note the mean current of a step, warm the winding by it, and let idle trajectories follow."""
    current = 0.0
    mode = x[MODE]
    if mode != OFF:
        current = (x[EFFORT] * x[VOLTAGE] - x[BACK_EMF] * mean_speed) / x[RESISTANCE]
    if mode != POSITION and mode != COMPLIANCE:  # noqa: PLR1714 - compiled
        x[REFERENCE] = x[GOAL] = x[LAST_REFERENCE] = _measured_angle(x)
        if mode != VELOCITY:
            x[REFERENCE_SPEED] = x[SPEED]
    x[AMPERES] = current
    _warm(x, x[WARMING])


@compiled
def _is_steady(x: FloatArray) -> bool:
    """Whether the control loop will put out the same again, as long as nothing moves."""
    return not x[UNDER_WAY] and abs(x[DEMAND] - x[LAST_DEMAND]) < SAME_DUTY


@compiled
def _move(x: FloatArray) -> None:
    """Advance motor, horn and heat by one step of the joint alone."""
    before = x[MOTOR_ANGLE]
    stood = x[MOTOR_SPEED] == 0.0
    if x[JAMMED]:
        x[MOTOR_SPEED] = 0.0
    elif x[MODE] == OFF:
        friction = x[FRICTION] * x[FRICTION_FACTOR]
        _turn(x, -x[LOAD], friction, x[INERTIA], x[FREE_LAG], x[FREE_KEPT])
    else:
        friction = x[FRICTION] * x[FRICTION_FACTOR]
        torque = _standing_torque(x) - x[LOAD]
        _turn(x, torque, friction, x[INERTIA], x[DRIVEN_LAG], x[DRIVEN_KEPT])
    _carry_horn(x)
    _settle_accounts(x, (x[MOTOR_ANGLE] - before) / STEP)
    x[SETTLED] = stood and x[MOTOR_SPEED] == 0.0 and _is_steady(x)


@compiled
def _reach_out(x: FloatArray) -> bool:
    """Leave in HAND_RATE and HAND_GRIP how a hand pulls; return whether that stays the same.

    It pulls with grip times (rate - speed), which counts as damping, so that no step overshoots;
    the grip is such that this is not above its torque.
    """
    way = x[HAND_GOAL] - x[ANGLE]
    fastest = min(x[HAND_SPEED], abs(way) / HAND_LAG, math.sqrt(HAND_ACCELERATION * abs(way)))
    wanted = math.copysign(fastest, way)
    most = HAND_ACCELERATION * STEP
    change = max(-most, min(most, wanted - x[HAND_RATE]))
    x[HAND_RATE] += change
    slip = abs(x[HAND_RATE] - x[MOTOR_SPEED])
    x[HAND_GRIP] = x[HAND_TORQUE] / max(slip, HAND_SLIP)
    return bool(abs(change) < _SAME_RATE)


@compiled
def _damping(x: FloatArray) -> float:
    """Return what takes from a motor's torque with its speed, N m per rad/s."""
    damping = x[DRAG]
    if x[MODE] != OFF:
        damping += x[TORQUE_CONSTANT] * x[BACK_EMF] / x[RESISTANCE]
    return float(damping)


@compiled
def _on_joint(state: FloatArray, i: int, base: int) -> bool:
    return i == base or (state[i, LINK] == FOLLOWS and state[i, BASE] == base)


@compiled
def _way_left(x: FloatArray) -> tuple[float, float]:
    """Return how far a motor can turn before its horn is stopped: down, and up, rad."""
    half = 0.5 * x[BACKLASH]
    low = x[STOP_LOW] - half - x[MOTOR_ANGLE]
    high = x[STOP_HIGH] + half - x[MOTOR_ANGLE]
    return (low, high) if x[GEAR] > 0.0 else (-high, -low)


@compiled
def _move_joint(state: FloatArray, base: int) -> None:
    """Advance all motors on one joint by one step, with what holds and stops them."""
    torque = friction = inertia = damping = 0.0
    low, high = -math.inf, math.inf
    jammed, held, steady = False, False, True
    for i in range(len(state)):
        if not _on_joint(state, i, base):
            continue
        x = state[i]
        own = -x[LOAD]
        own_damping = _damping(x)
        if x[MODE] != OFF:
            own += _standing_torque(x)
        if x[HAND_TORQUE] > 0.0:
            held = True
            steady &= _reach_out(x)
            own += x[HAND_GRIP] * x[HAND_RATE]
            own_damping += x[HAND_GRIP]
        torque += x[GEAR] * own
        damping += own_damping
        friction += x[FRICTION] * x[FRICTION_FACTOR]
        inertia += x[INERTIA]
        jammed |= x[JAMMED] != 0.0
        steady &= _is_steady(x)
        down, up = _way_left(x)
        low, high = max(low, down), min(high, up)
    leader = state[base]
    before = leader[MOTOR_ANGLE]
    stood = leader[MOTOR_SPEED] == 0.0
    if jammed:
        leader[MOTOR_SPEED] = 0.0
    else:
        lag = inertia / damping
        _turn(leader, torque, friction, inertia, lag, math.exp(-STEP / lag))
    if held and abs(leader[MOTOR_SPEED]) < _HARDLY_MOVING:
        leader[MOTOR_SPEED] = 0.0  # a hand would slow down for ever
    way = leader[MOTOR_ANGLE] - before
    if not low <= way <= high:
        way = max(low, min(high, way))
        leader[MOTOR_SPEED] = 0.0
    settled = stood and leader[MOTOR_SPEED] == 0.0 and steady
    _carry_joint(state, base, before, way, settled)


@compiled
def _carry_joint(state: FloatArray, base: int, before: float, way: float, settled: bool) -> None:
    """Let horns and heat of all motors on one joint follow its base, which was at `before`."""
    speed = state[base, MOTOR_SPEED]
    state[base, MOTOR_ANGLE] = before
    for i in range(len(state)):
        if _on_joint(state, i, base):
            x = state[i]
            x[MOTOR_ANGLE] += x[GEAR] * way
            x[MOTOR_SPEED] = x[GEAR] * speed
            _carry_horn(x)
            _settle_accounts(x, x[GEAR] * way / STEP)
            x[SETTLED] = settled


@compiled
def control(state: FloatArray, supplies: FloatArray) -> None:
    """Run every axis' control loop for one step and find the voltage that it works from.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        Gets new EFFORT and VOLTAGE.
    supplies : ndarray of float, shape (supplies, SUPPLY_COLUMNS)
        Gets new SAG.
    """
    for i in range(len(state)):
        x = state[i]
        if not x[SETTLED]:
            _control(x)
        elif x[SATURATED_FOR] > 0.0:
            x[SATURATED_FOR] += STEP
        _add_draw(x, supplies)
    _sag(supplies)
    for i in range(len(state)):
        x = state[i]
        voltage = x[SOURCE] - supplies[int(x[SUPPLY]), SAG]
        if abs(voltage - x[VOLTAGE]) > _SAME_VOLTAGE and _controls_current(x):
            x[SETTLED] = 0.0
            x[LAST_DEMAND] = math.inf
        x[VOLTAGE] = voltage


@compiled
def drive(
    state: FloatArray, supplies: FloatArray, torques: FloatArray, dampings: FloatArray
) -> None:
    """Run the control loops for one step, for mechanics that stand elsewhere.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        As for `control`; SETTLED is cleared, since only those mechanics know what moves.
    supplies : ndarray of float, shape (supplies, SUPPLY_COLUMNS)
        As for `control`.
    torques : ndarray of float, shape (axes,)
        Gets the torque of each motor as long as it stands, and of hands, N m.
    dampings : ndarray of float, shape (axes,)
        Gets what takes from it with the speed, back-EMF and drag of the gears, N m per rad/s.
        Friction is left to the mechanics: FRICTION times FRICTION_FACTOR.
    """
    for i in range(len(state)):
        state[i, SETTLED] = 0.0
    control(state, supplies)
    for i in range(len(state)):
        x = state[i]
        torques[i] = _standing_torque(x)
        dampings[i] = _damping(x)
        if x[HAND_TORQUE] > 0.0:
            _reach_out(x)
            torques[i] += x[HAND_GRIP] * x[HAND_RATE]
            dampings[i] += x[HAND_GRIP]


@compiled
def observe(state: FloatArray, angles: FloatArray, speeds: FloatArray) -> None:
    """Take motors' movement in one step from elsewhere: encoder, current and heat follow.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        As `drive` left it.
    angles, speeds : ndarray of float, shape (axes,)
        Of the motors after the step, before the backlash, rad and rad/s.
    """
    for i in range(len(state)):
        x = state[i]
        mean_speed = (angles[i] - x[MOTOR_ANGLE]) / STEP
        x[MOTOR_ANGLE] = angles[i]
        x[MOTOR_SPEED] = speeds[i]
        _carry_horn(x)
        _settle_accounts(x, mean_speed)


@compiled
def _rest(x: FloatArray, steps: int) -> None:
    """Let heat and the time at full effort go on where nothing else changes."""
    _warm(x, 1.0 - math.exp(-steps * STEP / x[THERMAL_TIME]))
    if x[SATURATED_FOR] > 0.0:
        x[SATURATED_FOR] += steps * STEP


@compiled
def _all_settled(state: FloatArray) -> bool:
    for i in range(len(state)):  # noqa: SIM110 - numba compiles no generator
        if not state[i, SETTLED]:
            return False
    return True


@compiled
def is_quiet(state: FloatArray) -> bool:
    """Whether nothing will happen to any axis until the next command.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        All axes.

    Returns
    -------
    bool
        False as long as one moves, or is at full effort against something.
    """
    for i in range(len(state)):
        if not state[i, SETTLED] or state[i, SATURATED_FOR] > 0.0:
            return False
    return True


@compiled
def is_sound(state: FloatArray) -> bool:
    """Whether no axis needs to be looked into.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        All axes.

    Returns
    -------
    bool
        False where something is beyond what is watched, or at full effort on a horn that nearly
        stands; and for an axis of which nothing is watched.
    """
    for i in range(len(state)):
        x = state[i]
        hot = x[TEMPERATURE] > x[HOTTEST] or x[SATURATED_FOR] > 0.0
        fed = x[LOWEST_VOLTAGE] <= x[VOLTAGE] <= x[HIGHEST_VOLTAGE]
        if hot or not fed or abs(x[ANGLE] - _measured_angle(x)) > x[ENCODER_SLACK]:
            return False
    return True


@compiled
def advance(state: FloatArray, supplies: FloatArray, steps: int) -> None:
    """Advance independent joints, each with all the axes that are coupled there.

    Parameters
    ----------
    state : ndarray of float, shape (axes, COLUMNS)
        Changed in place.
    supplies : ndarray of float, shape (supplies, SUPPLY_COLUMNS)
        Changed in place.
    steps : int
        Of `STEP` each.
    """
    for step in range(steps):
        if _all_settled(state):
            for i in range(len(state)):
                _rest(state[i], steps - step)
            return
        control(state, supplies)
        for i in range(len(state)):
            if state[i, LINK] == FREE:
                _move(state[i])
            elif state[i, LINK] == LEADS:
                _move_joint(state, i)
