r"""Steady rotations of a machine as curves with folds over a drive or parameter.

Continuation follows a machine with a rotor under constant drives, including unstable states that no simulation
reaches. Every point has its Floquet multipliers. At a fold of a stable curve a simulation jumps, which is the
Sommerfeld effect.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.base import JUDGED
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes
from martensite.simulate.steady.continuation import STEADY_STEPS, Curve, CurvePoint, CurveSteps
from martensite.simulate.steady.equilibria import rest_signals
from martensite.simulate.steady.periodic_motion import TURN, PeriodicMotion, Stability, VariedNumber
from martensite.simulate.steady.stretch import Stretch
from martensite.simulate.steady.subjects import Subject

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

STEPS = 512
"""Steps per turn; the error near a resonance is a few parts in 10⁵."""
FINER = 8.0
"""Refinement of the longest step of a mechanism, to preserve its resonance."""
CHUNK, CHUNKS = 4000, 100
"""Steps per chunk, and maximum number of chunks."""
STEADY = 1e-3
"""Relative change of the rotor speed per chunk below which the equations are solved."""
WARMED = 0.05
"""Accepted change of a temperature per chunk [K]."""
Tell = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class ResponseCurve:
    """Steady rotations along a parameter; arrays of shape (points,)."""

    varied: VariedNumber
    parameter: Numbers
    """Varied parameter, in SI."""
    speed: Numbers
    """Mean speed of the rotor [rad/s]."""
    mean: dict[str, Numbers]
    """Means of all outputs over a turn, in SI."""
    amplitude: dict[str, Numbers]
    """Half the range in a turn."""
    multiplier: Numbers
    """Absolute value of the largest Floquet multiplier."""
    neutral: Numbers
    """Number of neutral directions."""
    fold: Numbers
    """True where the parameter turns back."""
    points: tuple[CurvePoint, ...]
    motion: PeriodicMotion
    units: dict[str, str]
    """SI unit of every output."""
    subject: Subject
    """Subject of the curve."""

    @property
    def stable(self) -> Numbers:
        """Return where all changes decay, except neutral ones; a fold ends a stable section."""
        return (self.multiplier < 1.0) & ~self.fold

    @property
    def folds(self) -> Numbers:
        """Return the parameter at the folds, in curve order."""
        return self.parameter[self.fold]


def trace_response(
    subject: Scenario | AbstractSystem,
    over: str,
    low: float,
    high: float,
    *,
    drive: Mapping[str, float] | None = None,
    start: str = "low",
    steps: int = STEPS,
    how: CurveSteps = STEADY_STEPS,
    tell: Tell | None = None,
) -> ResponseCurve:
    """Trace the steady rotation of a machine along a drive or parameter, around folds.

    Only the branch connected to the start is found.

    Args:
        subject: a scenario, or a system, with a rotating coordinate.
        over: drive name, or the path (or unique ending) of a parameter.
        low: lower bound, in SI.
        high: upper bound, in SI.
        drive: constant levels of other drives, by name; optional for constant drives of the scenario.
        start: `low` or `high`: bound of the initial simulation.
        steps: number of steps per turn.
        how: step settings along the curve.
        tell: progress callback with the activity and the completed fraction of the range.

    Raises:
        InputError: nothing rotates, a name is unknown, or a drive is not given.
        ParameterError: the bounds are not ascending.
        CompileError: no C compiler was found.
        SolveError: no steady rotation is found at the start, the curve cannot be followed, or an element with
            memory is heated or cooled along it.
    """
    if not low < high:
        raise ParameterError(f"The bounds of `{over}` must rise, but are {low:g} and {high:g}.")
    one = Subject.read(subject)
    varied = one.vary(over, low, high)
    given = dict(drive or {})
    if varied.path is None:
        given[one.names()[varied.drive]] = low
    signals = one.hold(given)
    begin = {"low": low, "high": high}.get(start)
    if begin is None:
        raise InputError(f"A curve begins at `low` or at `high`, not at `{start}`.")
    motion, guess = begin_rotation(one, varied, begin, signals, steps)
    curve = Curve(motion, how)
    points = list[CurvePoint]()
    for point in curve.follow(curve.begin(guess, high - low if start == "low" else low - high), low, high):
        points.append(point)
        if tell is not None:
            tell("following the curve", abs(point.parameter - begin) / (high - low))
    return _describe_curve(motion, varied, points, one)


def continue_response(
    curve: ResponseCurve,
    place: int,
    over: str,
    low: float,
    high: float,
    *,
    how: CurveSteps = STEADY_STEPS,
    tell: Tell | None = None,
) -> ResponseCurve:
    """Trace another parameter from a point of a response curve, at its constant first parameter.

    Use it to follow isolated or unstable states along a damping or an unbalance.

    Args:
        curve: a response curve.
        place: index of the point, from 0.
        over: drive name, or the path (or unique ending) of a parameter.
        low: lower bound, in SI.
        high: upper bound, in SI; the present value must lie between.
        how: step settings along the curve.
        tell: progress callback with the activity and the completed fraction of the range.

    Returns:
        The curve between two bounds through the point.

    Raises:
        ParameterError: the point or parameter does not exist, or the bounds do not enclose the present value.
        SolveError: the curve cannot be followed, or an element with memory is heated or cooled along it.
    """
    if not 0 <= place < len(curve.points):
        raise ParameterError(f"The curve has {len(curve.points)} points, but no fold {place}.")
    point, before = curve.points[place].unknowns, curve.motion
    system, signals = curve.subject.at(curve.varied, float(point[-1]), before.signals)
    one = Subject(system, curve.subject.waveforms, curve.subject.title, curve.subject.scenario)
    varied = one.vary(over, low, high)
    now = one.value(varied, signals)
    if not low <= now <= high:
        raise ParameterError(f"`{varied.name}` is {now:g} {varied.unit}, which its bounds must enclose.")
    motion = PeriodicMotion(system, signals, [varied], rotor=before.rotor, steps=before.steps)
    motion.angle = before.angle
    guess, halves = np.append(point[:-1], now), list[list[CurvePoint]]()
    for direction in (-1.0, 1.0):
        follower = Curve(motion, how)
        halves.append([])
        for one_point in follower.follow(follower.begin(guess, direction), low, high):
            halves[-1].append(one_point)
            if tell is not None:
                tell("following the curve", abs(one_point.parameter - now) / (high - low))
    return _describe_curve(motion, varied, [*halves[0][:0:-1], *halves[1]], one)


def begin_rotation(
    one: Subject, varied: VariedNumber, value: float, signals: Numbers, steps: int
) -> tuple[PeriodicMotion, Numbers]:
    """Return the equations of a turn, and a simulated solution: state, time of a turn, value.

    Raises:
        InputError: nothing rotates.
        SolveError: the speed does not become steady.
    """
    system, levels = one.at(varied, value, signals)
    state, place, speed = spin_up(system, levels)
    motion = PeriodicMotion(one.system, signals, [varied], rotor=place, steps=steps)
    motion.angle = state[place] % TURN
    state[place] = motion.angle
    return motion, np.concatenate([state, [TURN / speed, value]])


def find_angles(system: AbstractSystem) -> list[int]:
    """Return the indices of angles in the state."""
    mechanism = system.mechanism
    if not isinstance(mechanism, AbstractMultibody) or not mechanism.moves:
        return []
    turning = [k for k, one in enumerate(mechanism.coordinates()) if one.unit == "rad"]
    read_position: Callable[[Any], Any] = lambda state: state.mechanism.course.position  # noqa: E731
    places = Stretch(system).place(read_position)
    return [places[k] for k in turning]


def spin_up(system: AbstractSystem, signals: Numbers) -> tuple[Numbers, int, float]:
    """Return the state, angle index and mean speed [rad/s] of a steady rotation from equilibrium.

    Raises:
        InputError: no coordinate rotates.
        SolveError: the speed does not become steady.
    """
    angles = find_angles(system)
    lanes, dt = Lanes(system, 1), longest_step(system) / FINER
    lanes.reset(rest_signals(system)[:, None])
    warm = [lanes.names.index(system.label(port, "temperature")) for port in system.actuators()]
    last, signal_rows = 0.0, np.broadcast_to(signals[:, None], (CHUNK, len(signals), 1))
    heat = lanes.observe(signals[:, None])[warm, 0]
    for _ in range(CHUNKS):
        before = lanes.state[:, 0].copy()
        lanes.advance(signal_rows, dt, shown=False)
        if lanes.status[0].failed:
            raise SolveError(f"The run to a steady rotation failed. {lanes.status[0].sentence}")
        turned = [float(lanes.state[k, 0] - before[k]) for k in angles]
        most = max(turned, key=abs, default=0.0)
        speed, before_heat = most / (CHUNK * dt), heat
        heat = lanes.observe(signals[:, None])[warm, 0]
        still = bool(np.all(np.abs(heat - before_heat) <= WARMED))
        if abs(most) > TURN and abs(speed - last) <= STEADY * abs(speed) and still:
            return lanes.state[:, 0].copy(), angles[turned.index(most)], speed
        if abs(most) < TURN and abs(speed) <= abs(last):
            raise InputError(
                "Nothing turns: no coordinate of this system goes on through whole turns under the held drives. "
                "Compute the steady state or the cycle of its drives instead."
            )
        last = speed
    raise SolveError(f"The rotor has no steady speed after {CHUNKS * CHUNK * dt:.3g} s under held drives.")


def _describe_curve(
    motion: PeriodicMotion, varied: VariedNumber, points: list[CurvePoint], one: Subject
) -> ResponseCurve:
    """Return the outputs and stability of all points."""
    names = list(one.system.outputs())
    mean, amplitude = ({name: np.empty(len(points)) for name in names} for _ in range(2))
    judged = list[Stability]()
    for k, point in enumerate(points):
        judged.append(motion.judge(point.unknowns))
        _, outputs = motion.observe(point.unknowns)
        for name in names:
            mean[name][k] = outputs[name][:-1].mean()
            amplitude[name][k] = 0.5 * np.ptp(outputs[name])
    require_same_heat(motion, mean)
    return ResponseCurve(
        varied,
        np.array([point.parameter for point in points]),
        np.array([TURN / motion.period(point.unknowns) for point in points]),
        mean,
        amplitude,
        np.array([each.largest for each in judged]),
        np.array([each.neutral for each in judged]),
        np.array([point.is_fold for point in points]),
        tuple(points),
        motion,
        {name: output.unit for name, output in one.system.outputs().items()},
        one,
    )


def require_same_heat(motion: PeriodicMotion, mean: Mapping[str, Numbers]) -> None:
    """Raise `SolveError` if elements with memory are heated or cooled along a curve.

    The curve would skip transformations between its points.
    """
    system = motion.stretch.system
    if not motion.stretch.compiled.points:
        return
    for port in system.actuators():
        name = system.label(port, "temperature")
        change = float(np.ptp(mean[name]))
        if change > JUDGED["temperature"]:
            raise SolveError(
                f"Along this curve `{name}` changes by {change:.3g} K. The transformation then depends on the path, "
                "which a curve does not follow. Compute a separate curve for each temperature."
            )


@dataclass(frozen=True, eq=False)
class ResponseSweep:
    """Result of a run with stepwise constant parameter; arrays of shape (levels,)."""

    parameter: Numbers
    speed: Numbers
    """Mean speed of the rotor [rad/s]."""
    amplitude: dict[str, Numbers]
    """Amplitude of every output: half of its range."""

    def cut(self, begin: int, end: int) -> ResponseSweep:
        """Return selected levels."""
        amplitude = {name: column[begin:end] for name, column in self.amplitude.items()}
        return ResponseSweep(self.parameter[begin:end], self.speed[begin:end], amplitude)


def sweep_response(
    subject: Scenario | AbstractSystem,
    over: str,
    levels: Numbers,
    hold: float,
    *,
    drive: Mapping[str, float] | None = None,
) -> ResponseSweep:
    """Simulate a machine through held levels of a drive, and return the state at the end of each.

    Args:
        subject: a scenario, or a system, with a rotating coordinate.
        over: name of the varied drive.
        levels: levels in sequence, in SI.
        hold: time per level [s]; slow machines need long.
        drive: levels of the other drives, by name.

    Raises:
        InputError: a name is unknown, or no drive.
    """
    one = Subject.read(subject)
    varied = one.vary(over, float(np.min(levels)), float(np.max(levels)))
    if varied.path is not None:
        raise InputError(f"A run goes through levels of a drive, which `{over}` is not.")
    angles, names = find_angles(one.system), list(one.system.outputs())
    lanes, dt = Lanes(one.system, 1), longest_step(one.system) / FINER
    lanes.reset(rest_signals(one.system)[:, None])
    count, rows = max(math.ceil(hold / dt), 2), list[tuple[float, Numbers]]()
    tail = max(count // 4, 1)
    for level in levels:
        signals = one.hold({**(drive or {}), one.names()[varied.drive]: float(level)})[:, None]
        lanes.advance(np.broadcast_to(signals, (count - tail, *signals.shape)), dt, shown=False)
        before = lanes.state[angles, 0].copy()
        outputs = lanes.advance(np.broadcast_to(signals, (tail, *signals.shape)), dt)[:, : len(names), 0]
        turned = lanes.state[angles, 0] - before
        rows.append((float(np.abs(turned).max(initial=0.0)) / (tail * dt), 0.5 * np.ptp(outputs, axis=0)))
    table = np.array([row for _, row in rows])
    amplitude = dict(zip(names, table.T, strict=True))
    return ResponseSweep(np.array(levels, float), np.array([speed for speed, _ in rows]), amplitude)
