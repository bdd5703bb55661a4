r"""Time integration with step size control, on Python floats.

Every step is computed once as a whole and once in two halves, each half with its drive inputs. The error of the
halves is a third of the difference in the judged outputs: temperature, fraction, stress and coordinates.
Rate-dependent laws use Rodas4 with its embedded solution of order three (`martensite.physics.laws.rosenbrock`). A
step with an error above the tolerance is repeated with a smaller length. The estimated heat error of an element is
added to the next step, which makes smooth runs third order. The memory of a law remains valid, since both halves
are regular steps.

A rate-independent law depends on extremes of temperature and stress, but a step evaluates only its ends. A parabola
through both ends and the middle locates a turn between them, and a relevant turn ends the step. Steps also end at
the start and finish of a transformation if the difference shows a relevant error.

A single element with a strip law and a smooth drive takes explicit steps of order five instead
(`martensite.physics.laws.surface_steps`), as if the process at their start lasted. The law judges their ends. Their
interpolant gives the samples, and the places where a process begins, ends or turns back. Other steps have halves.

Steps do not end on samples. A polynomial through the last five points, half steps apart, gives the state at a
sample. It is used if its last term is within the tolerance and it does not overshoot. Otherwise the sample waits
for the next step. If no smooth polynomial fits, a separate step leads from the last point to the sample.

Steps can pass edges of an integrated drive. The source bounds the ripple, which is the difference between the drive
and its mean within a half step. Steps end on edges if the ripple exceeds the tolerance.

`martensite.simulate.marching_native` implements the same algorithm in C.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise, zip_longest

from martensite.base.status import Status
from martensite.signals.moments import Moments
from martensite.simulate.compiled import Functions, feed_step
from martensite.simulate.forks import COUNTS, ForkWatch
from martensite.simulate.ledger import SIMPSON, Ledger
from martensite.simulate.march import SOLVED
from martensite.simulate.marching import FIRST, SECOND, SHORTEST, STEP_TOLERANCE, AbstractMarch, MarchPlan, Row
from martensite.simulate.step_trials import (
    BESIDE,
    LEAST_FALL,
    Node,
    StepTrial,
    SurfaceTrial,
    TakenStep,
    divided_difference,
    find_dip,
    find_extreme,
    find_fall,
    find_missed,
    find_touch,
    interpolate_state,
    interpolate_step,
    join_halves,
    stretch_length,
)

SAFETY = 0.9
LEAST_CHANGE, MOST_CHANGE = 0.2, 3.0
"""Smallest and largest ratio of consecutive step lengths."""
FEW = 3
"""Largest number of edges for which a step ends on the first edge."""
SWING = 2.0
"""Largest phase [rad] of the fastest tone in a step; such a step resolves the tone."""
PRESCRIBED = 0.8
"""Largest phase in a step for signals that prescribe a state and are not integrated."""
BEND = 0.01
"""Fraction of the curvature that counts as error if a signal prescribes a state; the ends are always exact."""
LEAP = 1e-6
"""Length of a step over a jump of a prescribed state, as a fraction of the allowed step."""
TURN = 0.1
"""Accepted error at a turn, as a fraction of the tolerance."""
KINK_MARGIN = 0.03
"""Margin around a kink at the ends of a step, as a fraction of the step."""
STIFF = 2.0
"""Longest step of order five, as a fraction of the time constant of the heat balance."""
LEAST_SMOOTH = 1e-8
"""Shortest step of order five, as a fraction of the run; shorter steps, as over a jump of a fraction, have halves."""
SMOOTH_PHASE, SMOOTH_TOLERANCE = 1.0, 1e-4
"""Largest phase [rad] of the fastest tone in a step of order five, at this tolerance or a larger one.

The error of a cubic in place of the drive grows with the sixth power of the phase, and no error estimate sees it.
"""
ACROSS = 1.01
"""Length of a step across a kink nearby, as a fraction of its distance."""
AGAIN = 0.9
"""Place of a kink, as a fraction of a step, that no longer explains the error if the last trial ended at a kink."""
BEYOND = 5.0
"""Ratio of a step to the longest one of order five from which steps of lower order are tried."""
LEAST_SHRINK, MOST_GROWTH = 0.1, 6.0
"""Smallest and largest ratio of consecutive step lengths of order five."""
SHORT = 0.99
"""Fraction of the distance to an expected kink that a step covers."""
HIDDEN = 3.0
"""Accepted error at a bend near a step end, as a fraction of the tolerance."""
PER_STRESS = 1.0 / 7e6
"""Approximate temperature per stress [K/Pa] with the same effect on a transformation."""
BETWEEN = 1.0
"""Last term of the interpolation as a fraction of the tolerance."""
TRACED = 0.5
"""Largest phase of the fastest tone in a half step that five points resolve; a fourth-order term may vanish by chance.
"""
ROUNDING = 1e-12
"""Relative rounding error."""
CUBIC = 0.385
"""Largest value of |x (x² - 1)| between -1 and 1."""


class AdaptiveMarch(AbstractMarch):
    """Run with step size control."""

    def __init__(self, plan: MarchPlan, functions: Functions) -> None:
        super().__init__(plan, functions)
        self.hair = SHORTEST * self.duration
        """Time [s] that counts as zero: an edge closer than this is reached."""
        self.shortest = plan.shortest
        compiled = plan.compiled
        self.heating = [r for r, w in zip(self.readers, compiled.widths, strict=True) if w > 1]
        self.prescribing = [r for r, w in zip(self.readers, compiled.widths, strict=True) if w == 1]
        share = min(1.0, plan.tolerance / SMOOTH_TOLERANCE)
        self.smooth_phase = SMOOTH_PHASE * math.exp(math.log(share) * (1.0 / 6.0))
        self.decay = 0.0
        """Rate of the heat balance [1/s]."""
        self.on_surface = False
        """True if the last step has order five."""
        self.points = functions["points"](*self.state)
        self.earlier_points = self.points
        """Half a step earlier."""
        self.last_half = plan.first
        self.rates = [0.0] * len(compiled.rates)
        """Rates of the half step before the last."""
        self.nodes = [Node(self.time, self.state, self.judged_outputs)]
        """Start and middle of the last step, and where it ended: here. Behind a kink of a drive
        there is but the last."""
        self.owed = [0.0] * len(compiled.widths)
        self.length, self.after_edge, self.at_edge = plan.first, plan.first, True
        self.after_kink, self.at_kink = math.inf, False
        self.leaps = False
        """True if the step is the one over a jump of a signal that prescribes a state."""
        self.split = False
        """True if a step before the next edge was split, in a run in parts."""
        self.last_step: TakenStep | None = None
        """Last step."""
        self.ledger = Ledger(compiled.book, functions["entries"](*self.state, *self.signals(self.time)))
        self.forks = ForkWatch(len(compiled.forks))
        self.power = 0.0
        """Temperature error [K] by the last ripple, per lapse [s] of its drive."""
        self.rough = 0.0
        """Error of the last step over the power of its length that it grows by; 0 behind a kink."""

    # ---------------------------------------------------------------- one step

    def advance(self) -> None:
        """Take one step, with as many trials as necessary."""
        try:
            self._advance()
        except ArithmeticError:
            self._keep_waiting()
            raise

    def _advance(self) -> None:
        allowed = self._allow_length(min(self._limit_length(self.length), self.duration - self.time))
        self.leaps = self.plan.compiled.follows and self._jumps()
        length = LEAP * allowed if self.leaps else self._before_kink(allowed)
        most = MOST_GROWTH if self.plan.order == 5 else MOST_CHANGE
        planned, cut = 0.0 if length == allowed else allowed, False
        while True:
            length, halves = self._resolve_length(length)
            trial = self._try_step(length, halves)
            good, solved = trial.error <= 1.0, trial.residual <= SOLVED
            if length <= self.shortest and solved:
                break
            kink = self._find_kink(trial) if solved else 1.0
            if good and kink == 1.0:
                break
            self.result.rejected += 1
            if length <= self.shortest:
                self._keep_waiting()
                self.result.status = Status.UNSOLVED
                return
            if good:
                planned = max(planned, length)
            else:
                most = 1.0
            length = max(self._find_next_trial(trial, kink, cut), 0.5 * self.shortest)
            cut = kink < 1.0
        self._accept(trial, most, planned)

    def _limit_length(self, length: float) -> float:
        """Return a length at which a step has order five, unless a much longer step is possible, not behind a kink."""
        limits = [self.smooth_phase / reader.fastest for reader in self.readers if reader.fastest > 0.0]
        if self.decay > 0.0:
            limits.append(STIFF / self.decay)
        most = min(limits, default=math.inf)
        return most if self.on_surface and most < length and (self.at_kink or length < BEYOND * most) else length

    def _allow_length(self, length: float) -> float:
        """Return a length that is short enough for signals that prescribe a state."""
        end = self.duration - self.time
        for reader in self.prescribing:
            if reader.fastest > 0.0:
                length = min(length, PRESCRIBED / reader.fastest)
            edges = reader.edges(self.time + self.hair, self.time + (1.0 + STEP_TOLERANCE) * length)
            end = min(end, edges[0] - self.time) if edges else end
        return stretch_length(length, end)

    def _before_kink(self, length: float) -> float:
        """Return the length to the next expected kink, extrapolated from the last half step."""
        allowed, at = length, 0
        for _, _, size in self.plan.compiled.points:
            for k in range(at + 4, at + size):
                now, fallen = self.points[k], self.earlier_points[k] - self.points[k]
                if not (now > LEAST_FALL and fallen > 0.0):
                    continue
                there = now / fallen * self.last_half
                near = there <= KINK_MARGIN * allowed
                if self.on_surface and near:  # across it; later kinks are found in the step
                    length = min(length, max(ACROSS * there, 2.0 * LEAST_SMOOTH * self.duration, self.shortest))
                if not self.on_surface and SHORT * there > max(KINK_MARGIN * allowed, self.shortest):
                    length = min(length, SHORT * there)
            at += size
        return length

    def _resolve_length(self, length: float) -> tuple[float, list[Row]]:
        """Return a length over which drive means are accurate enough, and the drive inputs."""
        whole = False
        for reader in self.heating:
            edges = reader.edges(self.time + self.hair, self.time + (1.0 + STEP_TOLERANCE) * length)
            if edges and len(edges) <= FEW:
                length = stretch_length(length, edges[0] - self.time)
                whole = whole or length >= edges[0] - self.time
        if self.plan.parted and whole and not self.split:
            length, self.split = 0.5 * length, True
        begin, allowed = self.time, self.plan.tolerance * self._scale(0)
        while True:
            middle = begin + 0.5 * length
            halves = [self._collect_inputs(begin, middle), self._collect_inputs(middle, begin + length)]
            lapse = max(map(_find_lapse, halves))
            shorter = length if self.power * lapse <= allowed else self._to_edge(length)
            if not shorter < length:
                first, last = halves
                return length, [self._feed_step(first, self.owed), self._feed_step(last)]
            length = shorter

    def _to_edge(self, length: float) -> float:
        """Return a shorter length: to the first edge of a heating drive, or resolving its tones."""
        for reader in self.heating:
            edges = reader.edges(self.time + self.hair, self.time + (1.0 - STEP_TOLERANCE) * length)
            if edges:
                length = edges[0] - self.time
            if reader.fastest > 0.0:
                length = min(length, SWING / reader.fastest)
        return length

    def _collect_inputs(self, begin: float, end: float) -> list[Moments | float]:
        """Return the drive inputs of an interval: moments, or the value before its end."""
        return [
            reader.moments(begin, end) if width > 1 else reader.before(end)
            for reader, width in zip(self.readers, self.plan.compiled.widths, strict=True)
        ]

    def _feed_step(self, drive_inputs: Sequence[Moments | float], owed: Sequence[float] = ()) -> Row:
        """Return the inputs of a step; missing heat of the previous step is added to the first half."""
        inputs: list[float] = []
        for one, heat in zip_longest(drive_inputs, owed, fillvalue=0.0):
            inputs += feed_step(one, heat) if isinstance(one, Moments) else (one,)
        return tuple(inputs)

    def _whole(self, halves: Sequence[Row], length: float) -> Row:
        """Return the inputs of the whole step from the inputs of its halves."""
        inputs: list[float] = []
        at = 0
        for width in self.plan.compiled.widths:
            first, last = (half[at : at + width] for half in halves)
            at += width
            if width == 1:
                inputs += last
                continue
            joined = join_halves(Moments(*first[:-1]), Moments(*last[:-1]), length)
            inputs += feed_step(joined, first[-1])
        return tuple(inputs)

    def _try_step(self, length: float, halves: Sequence[Row]) -> StepTrial:
        plan = self.plan
        self.on_surface = plan.order == 5 and self._is_smooth(length, halves)
        one, two, whole, residual, surface = self._solve_step(length, halves)
        doubt = plan.tolerance * surface.unsettled / SOLVED if surface else 0.0
        if plan.order == 4 and self.at_edge:
            one, doubt = self._check_middle(length, halves, one)
        signals, judge = self.signals(self.time + length, before=True), self.functions["judge"]
        coarse, fine = judge(*whole, *signals), judge(*two, *signals)
        part = 1.0 / 3.0 if self._halved else 1.0
        error = doubt
        for k in range(self.convergence_scales):
            error = max(error, part * abs(fine[k] - coarse[k]) / self._scale(k, fine[k]))
        if surface and self.convergence_scales:
            reached = abs(fine[0] - coarse[0]) <= plan.tolerance * self._scale(0, fine[0])
            surface = surface._replace(accurate=reached)
        lapse, ripple = self._measure(length, halves, one)
        error = max(error, ripple / self._scale(0, fine[0]), self._find_bend(length, one, fine)) / plan.tolerance
        if not (residual <= SOLVED and error < math.inf):
            error, residual = math.inf, max(residual, 2.0 * SOLVED)
        owed, points = self._find_owed(fine, coarse), self.functions["points"]
        ends = points(*one), points(*two)
        return StepTrial(length, halves, one, two, fine, ends, owed, error, ripple, residual, lapse, surface)

    @property
    def _halved(self) -> bool:
        """Return whether the last trial was computed in two halves."""
        return self.plan.order != 4 and not self.on_surface

    def _find_owed(self, fine: Row, coarse: Row) -> tuple[float, ...]:
        """Return the heat [J] missing in the halves of a step, by drive."""
        owed, heated = [0.0] * len(self.owed), self.plan.compiled.heated
        if self._halved and heated:
            rows = zip(heated, fine[-len(heated) :], coarse[-len(heated) :], strict=True)
            for place, a, b in rows:
                owed[place] = (1.0 / 3.0) * (a - b)
        return tuple(owed)

    def _is_smooth(self, length: float, halves: Sequence[Row]) -> bool:
        """Return whether a step can have order five: smooth drives, and a slower heat balance."""
        at, lapse = 0, 0.0
        for width in self.plan.compiled.widths:
            lapse = max(lapse, halves[0][at + 4], halves[1][at + 4])
            at += width
        swings = any(reader.fastest * length > (1.0 + STEP_TOLERANCE) * self.smooth_phase for reader in self.readers)
        long = length > LEAST_SMOOTH * self.duration
        return long and not lapse > 0.0 and self.decay * length <= STIFF and not swings

    def _solve_step(self, length: float, halves: Sequence[Row]) -> tuple[Row, Row, Row, float, SurfaceTrial | None]:
        """Return the middle and end of a step, its end to a lower order, the residual, and details of order five."""
        if not self.on_surface:
            solve = self._solve_rosenbrock if self.plan.order == 4 else self._solve_halves
            return *solve(length, halves), None
        size = self.size
        ends = self.functions["surface"](*self.state, *halves[0], *halves[1], length)
        end, middle, coarse, begin, first, last = (ends[k * size : (k + 1) * size] for k in range(6))
        self.decay = ends[-1] / length
        surface = SurfaceTrial(begin, (first, last), ends[6 * size : -2], ends[-2])
        return middle, end, coarse, min(surface.unsettled, SOLVED), surface

    def _solve_halves(self, length: float, halves: Sequence[Row]) -> tuple[Row, Row, Row, float]:
        """Return the middle and end by two halves, the end as a whole, and the largest residual."""
        step, size, plan = self.functions["solve"], self.size, self.plan
        one = step(*self._extrapolate_state(self.state, self.rates, length), *halves[0], 0.5 * length)
        guessed = self._extrapolate_state(one[:size], [self.state[k] for k in plan.compiled.rates], length)
        two = step(*guessed, *halves[1], 0.5 * length)
        mean = [0.5 * (one[k] + two[k]) for k in plan.compiled.rates]
        whole = step(*self._with_rates(self.state, mean), *self._whole(halves, length), length)
        residual = max(whole[size], one[size], two[size])
        return one[:size], two[:size], whole[:size], residual

    def _solve_rosenbrock(self, length: float, halves: Sequence[Row]) -> tuple[Row, Row, Row, float]:
        """Return the middle and end with rate-dependent laws, and the end with a lower order."""
        size, inputs = self.size, self._whole(halves, length)
        ends = self.functions["rosenbrock"](*self.state, *inputs, length)
        return ends[size : 2 * size], ends[:size], ends[2 * size :], 0.0

    def _check_middle(self, length: float, halves: Sequence[Row], middle: Row) -> tuple[Row, float]:
        """Return the middle from a step of half the length, and the difference to the given middle.

        Rates may decay within a fraction of a step after a drive edge, which the error estimate of the step misses.
        """
        signals, judge = self.signals(self.time + 0.5 * length), self.functions["judge"]
        half_state = self.functions["rosenbrock"](*self.state, *halves[0], 0.5 * length)[: self.size]
        pairs = zip(judge(*half_state, *signals), judge(*middle, *signals), strict=True)
        apart = [abs(a - b) / self._scale(k) for k, (a, b) in enumerate(list(pairs)[: self.convergence_scales])]
        return half_state, max(apart, default=0.0)

    def _find_bend(self, length: float, half: Row, fine: Row) -> float:
        """Return the distance of the middle from the mean of the ends, as an error in ranges.

        It is 0 if no signal prescribes a state, or if such a signal jumps at the start of the step.
        """
        signals = self.signals(self.time)
        if not self.plan.compiled.follows or self.leaps:
            return 0.0
        judge = self.functions["judge"]
        start, middle = judge(*self.state, *signals), judge(*half, *self.signals(self.time + 0.5 * length))
        bends = (abs(start[k] - 2.0 * middle[k] + fine[k]) / self._scale(k) for k in range(self.convergence_scales))
        return BEND * max(bends, default=0.0)

    def _jumps(self) -> bool:
        """Return whether a signal that prescribes a state jumps at the current time."""
        return any(reader.value(self.time) != reader.before(self.time) for reader in self.prescribing)

    def _extrapolate_state(self, state: Row, before: Sequence[float], length: float) -> Row:
        """Return the state extrapolated with the change of rates over two half steps."""
        gap = 0.5 * (self.last_half + 0.5 * length)
        first = state is self.state
        ratio = gap / self.last_half if first else 0.5 * length / gap
        rates = [state[k] for k in self.plan.compiled.rates]
        guess = [r + ratio * (r - r0) for r, r0 in zip(rates, before, strict=True)]
        return self._with_rates(state, guess)

    def _with_rates(self, state: Row, rates: Sequence[float]) -> Row:
        row = list(state)
        for place, rate in zip(self.plan.compiled.rates, rates, strict=True):
            row[place] = rate
        return tuple(row)

    def _measure(self, length: float, halves: Sequence[Row], half: Row) -> tuple[float, float]:
        """Return the largest lapse of a drive and its temperature error [K]."""
        at, lapse = 0, 0.0
        for width in self.plan.compiled.widths:
            if width > 1:
                lapse = max(lapse, halves[0][at + 4], halves[1][at + 4])
            at += width
        if not lapse > 0.0:
            return 0.0, 0.0
        pairs = zip((self.state, half), halves, strict=True)
        ripples = [self.functions["ripple"](*s, *u, 0.5 * length)[0] for s, u in pairs]
        self.power = max(ripples) / lapse
        return lapse, max(ripples)

    def _find_kink(self, trial: StepTrial) -> float:
        """Return the place of a relevant turn or bend of a rate-independent law in a step; else 1.

        The error at a turn is its height above the computed points, times the local sensitivity of the fractions. A
        turn that may reach an unseen kink always counts. A bend counts if the error is not small. It also counts if
        it is near a step end and a derivative changes strongly, since the error estimate misses this case.
        """
        if trial.surface is not None:
            return self._find_surface_kink(trial, trial.surface)
        first, at = 1.0, 0
        for fraction, weight, size in self.plan.compiled.points:
            rows = [row[at : at + size] for row in (self.earlier_points, self.points, trial.points[0], trial.points[1])]
            at += size
            dips = (find_dip(*(row[k] for row in rows[1:])) for k in range(4, size))
            first = min([first, *(share for share in dips if BESIDE < share < 1.0 - BESIDE)])
            changed = max(_compute_variation(rows, k) for k in (2, 3))
            allowed = TURN * self.plan.tolerance * self._scale(fraction) / weight
            first = min(first, self._find_touch(trial, rows, allowed))
            if not changed > allowed:
                continue
            drives = [(row[0] - row[1] * PER_STRESS,) for row in rows]
            share, height = find_extreme(*(drive for (drive,) in drives[1:]))
            moved = _compute_variation(drives, 0)
            if BESIDE < share < 1.0 - BESIDE and changed * height > allowed * moved:
                first = min(first, share)
            first = min([first, *self._find_bends(trial, rows, HIDDEN / TURN * allowed)])
        return first

    def _find_touch(self, trial: StepTrial, rows: Sequence[Row], allowed: float) -> float:
        """Return the place in a step in halves, between steps of order five, where an unseen process acts; else 1."""
        if self.plan.order != 5:
            return 1.0
        ratio = 0.0 if self.at_edge else 0.5 * trial.length / self.last_half
        return find_touch(self.functions["events"], self.state, rows, ratio, allowed)

    def _find_surface_kink(self, trial: StepTrial, surface: SurfaceTrial) -> float:
        """Return the place in a step of order five where a process begins, ends or turns back; else 1."""
        turn, ask = surface.find_turn(), self.functions["events"]
        rows = [ask(*surface.begin, *surface.follow_path(x)[:2]) for x in (0.0, turn, 1.0)]
        first = surface.find_event(ask, rows, turn, trial.error > 1.0)
        for fraction, weight, _ in self.plan.compiled.points if surface.accurate else ():
            allowed = TURN * self.plan.tolerance * self._scale(fraction) / weight
            first = min(first, surface.find_reversal(rows, turn, allowed))
        return first

    def _find_bends(self, trial: StepTrial, rows: Sequence[Row], allowed: float) -> Iterator[float]:
        """Yield the fractions of a step at which a law has a relevant bend."""
        ratio = 0.5 * trial.length / self.last_half
        for k in range(4, len(rows[0])):
            share = find_fall(ratio * (rows[0][k] - rows[1][k]), *(row[k] for row in rows[1:]))
            if find_missed(rows, ratio, share) > allowed or (trial.error > 1.0 and BESIDE < share < 1.0 - BESIDE):
                yield share

    def _find_next_trial(self, trial: StepTrial, kink: float, cut: bool) -> float:
        """Return the next trial length after a rejected step: up to its kink, or shorter if its error is too large.

        Args:
            trial: the rejected step.
            kink: place of its kink, as a fraction of the step.
            cut: True if the trial before was cut at a kink, too.
        """
        explains = trial.surface is None or (trial.surface.accurate and not (cut and kink > AGAIN))
        if kink < 1.0 and (explains or trial.error <= 1.0):
            return kink * trial.length
        return min(kink * trial.length, self._shorten_step(trial))

    def _shorten_step(self, trial: StepTrial) -> float:
        """Return the next trial length after a rejected step."""
        if trial.error == math.inf:
            return 0.25 * trial.length
        least = LEAST_SHRINK if self.on_surface else LEAST_CHANGE
        shorter = trial.length * max(least, min(self._change(trial), SAFETY))
        if trial.ripple > self.plan.tolerance * self._scale(0):
            shorter = min(shorter, self._to_edge(trial.length))
        return shorter

    def _change(self, trial: StepTrial) -> float:
        """Return the factor on the step length for the tolerance."""
        return SAFETY * max(trial.error, 1e-9) ** (-1.0 / self._get_exponent())

    def _get_exponent(self) -> float:
        """Return the exponent of the error over the length of the last step."""
        return 5.0 if self.on_surface else 4.0 if self.plan.order == 4 else 3.0

    def _trend(self, trial: StepTrial) -> float:
        """Return the reduction of the next step for errors that keep growing at the last rate."""
        if self.on_surface:
            return 1.0
        power = self._get_exponent()
        rough = max(trial.error, 1e-9) / trial.length**power
        last, self.rough = self.rough, 0.0 if self.at_edge or self.at_kink else rough
        return (last / rough) ** (1.0 / power) if 0.0 < last < rough else 1.0

    def _keep_ledger(self, trial: StepTrial) -> None:
        """Add the heat and work of a step to the ledger, with mean inputs over each half.

        Heating and cooling laws are evaluated at the computed states, whereas the step linearises these laws.
        """
        flows, entries = self.functions["flows"], self.functions["entries"]
        one, two = trial.halves
        ends = (self.state, one), (trial.half, one), (trial.half, two), (trial.full, two)
        rows = [flows(*state, *inputs) for state, inputs in ends]
        self.result.put_in += 0.25 * trial.length * sum(given for given, *_ in rows)
        for share, (_, *lost) in zip(SIMPSON, rows, strict=True):
            self.ledger.lost += share * trial.length * sum(lost)
        half = self.time + 0.5 * trial.length
        middle = entries(*trial.half, *self.signals(half))
        end = entries(*trial.full, *self.signals(self.time + trial.length, before=True))
        self.ledger.enter(middle, end, trial.length)
        self.result.lost = self.ledger.lost
        self.result.accounts = tuple(self.ledger.accounts)

    def _accept(self, trial: StepTrial, most: float, planned: float) -> None:
        if self.plan.recorded:
            self._keep_ledger(trial)
        run, length, end = self.result, trial.length, self.time + trial.length
        if self.duration - end < SHORTEST * self.duration:
            end = self.duration
        nodes = [*self.nodes, *self._reach_ends(trial)]
        begins_at_edge, hair = self.at_edge, STEP_TOLERANCE * length
        self.at_edge = any(reader.edges(end - hair, end + hair) for reader in self.readers)
        step = TakenStep(self.time, self.state, self.owed, trial)
        self._keep_samples(end, step, nodes)
        self.last_step = step
        parts = 2 if self._halved else 1
        run.steps += parts
        run.longest = max(run.longest, length / parts)
        run.ripple = max(run.ripple, trial.ripple)
        missed = self.plan.tolerance * trial.error if trial.error > 1.0 else 0.0  # minimum step length
        run.residual = max(run.residual, trial.residual) + missed
        middle = self.time + 0.5 * length
        self._watch_forks(trial, middle, end)
        self.record_piece(FIRST, self.time, middle, trial.halves[0], trial.half)
        self.record_piece(SECOND, middle, end, trial.halves[1], trial.full)
        if begins_at_edge and not self.leaps:
            self.after_edge = MOST_CHANGE * length
        if self.at_kink:
            self.after_kink = MOST_CHANGE * length
        self.at_kink = planned > 0.0
        self.nodes = nodes[-1:] if self.at_edge or trial.lapse > 0.0 else nodes[-4:]
        self.rates = [trial.half[k] for k in self.plan.compiled.rates]
        self.state, self.owed, self.time = trial.full, list(trial.owed), end
        self.earlier_points, self.points = trial.points
        self.last_half = 0.5 * length
        self._choose_length(length * min(max(self._change(trial) * self._trend(trial), LEAST_CHANGE), most), planned)
        for reader in self.readers:
            reader.forget(step.begin)
        self.see(trial.judged_outputs)

    def _choose_length(self, grown: float, planned: float) -> None:
        """Choose the length [s] of the next step: what the error allows, or what was planned before a kink."""
        self.length = max(grown, planned)
        if self.at_edge:
            self.length, self.split = min(self.length, self.after_edge), False
        if self.at_kink and not self.on_surface:
            self.length = min(self.length, max(self.after_kink, grown))
        self.length = max(self.length, self.shortest)

    def _watch_forks(self, trial: StepTrial, middle: float, end: float) -> None:
        """Look for decisions about forgotten branches at the middle and the end of a step [s]."""
        if not (self.plan.compiled.forks and self.plan.parted):  # the first pass is not parted
            return
        forks, share = self.plan.compiled.forks, COUNTS * self.plan.tolerance
        allowed = [share * self._scale(fork.fraction) / fork.weight for fork in forks]
        for time, state in ((middle, trial.half), (end, trial.full)):
            self.forks.see(time, self.functions["forks"](*state), allowed)
        self.result.decision = self.forks.closest

    # ---------------------------------------------------------------- samples

    def _reach_ends(self, trial: StepTrial) -> list[Node]:
        half, end = self.time + 0.5 * trial.length, self.time + trial.length
        middle = self.functions["judge"](*trial.half, *self.signals(half))
        return [Node(half, trial.half, middle), Node(end, trial.full, trial.judged_outputs)]

    def _keep_samples(self, end: float, step: TakenStep, nodes: Sequence[Node]) -> None:
        """Store the samples up to the end of a step [s], except those that wait for the next step."""
        times, trial = self.plan.times, step.trial
        hair = STEP_TOLERANCE * trial.length
        ends = self._is_last(end, trial)
        smooth: list[bool] | None = None
        while self.sample < len(times) and times[self.sample] <= end + hair:
            time = times[self.sample]
            earlier = bool(time <= self.time)
            state = trial.full if time >= end - hair else None
            if state is None:
                if self.on_surface and not earlier:
                    state = interpolate_step(step, (time - self.time) / trial.length)
                else:
                    smooth = smooth or self._find_smooth(trial, nodes)
                    state = self._between(nodes[-5:], time) if smooth[earlier] else None
            if state is None:
                if not (earlier or ends or time - self.time <= hair):
                    return
                state = self._step_aside((earlier and self.last_step) or step, time, hair)
            self._keep_row(state, time)

    def _keep_waiting(self) -> None:
        """Store the samples that wait for a step which cannot be taken."""
        times = self.plan.times
        while self.last_step and self.sample < len(times) and times[self.sample] <= self.time:
            time = times[self.sample]
            self._keep_row(self._step_aside(self.last_step, time, 0.0), time)

    def _keep_row(self, state: Row, time: float) -> None:
        self.result.rows.append(self.functions["observe"](*state, *self.signals(time)))
        self.sample += 1

    def _is_last(self, end: float, trial: StepTrial) -> bool:
        """Return whether no polynomial continues after a step: at an edge, a jump or the end of the run."""
        if self.at_edge or trial.lapse > 0.0 or end >= self.duration:
            return True
        return self.plan.limits.find_exit(trial.judged_outputs[self.convergence_scales :]) is not None

    def _find_smooth(self, trial: StepTrial, nodes: Sequence[Node]) -> list[bool]:
        """Return whether the polynomial through five points is accurate in a step and in the previous step.

        The criterion is its last term, or the next term if a sixth point is known.
        """
        half, last = 0.5 * trial.length, self.last_half
        traced = all(reader.fastest * max(half, last) <= TRACED for reader in self.readers)
        if len(nodes) < 5 or trial.lapse > 0.0 or not traced:
            return [False, False]
        first, *_, fourth, end = (node.time for node in nodes[-5:])
        way = end - first
        reached = CUBIC * half**3 * (end - nodes[-4].time), CUBIC * last**3 * (fourth - first)
        six = len(nodes) > 5
        return [self._is_flat(nodes[-5:], far) or (six and self._is_flat(nodes, far * way)) for far in reached]

    def _is_flat(self, nodes: Sequence[Node], reached: float) -> bool:
        """Return whether the last term of the polynomial through the points is within the tolerance."""
        times = [node.time for node in nodes]
        for k in range(self.convergence_scales):
            last = divided_difference(times, [node.judged_outputs[k] for node in nodes])
            if not abs(last) * reached <= BETWEEN * self.plan.tolerance * self._scale(k):
                return False
        return True

    def _between(self, nodes: Sequence[Node], time: float) -> Row | None:
        """Return the interpolated state; None if the polynomial overshoots its points."""
        state = list(interpolate_state(nodes, time))
        for k, column in enumerate(zip(*(node.state for node in nodes), strict=True)):
            low, high = min(column), max(column)
            hair = ROUNDING * (abs(low) + abs(high))
            if k not in self.plan.compiled.rates and not low - hair <= state[k] <= high + hair:
                return None
            state[k] = min(max(state[k], low), high)
        return tuple(state)

    def _step_aside(self, step: TakenStep, time: float, hair: float) -> Row:
        """Return the state after a step from the last half step, or this state within a hair [s]."""
        trial, middle = step.trial, step.begin + 0.5 * step.trial.length
        name = "rosenbrock" if self.plan.order == 4 else "solve"
        late = name == "solve" and time >= middle
        begin, state = (middle, trial.half) if late else (step.begin, step.state)
        if time - begin > hair:
            inputs = self._feed_step(self._collect_inputs(begin, time), () if late else step.owed)
            after = self.functions[name](*state, *inputs, time - begin)
            if name == "solve" and not after[self.size] <= SOLVED:  # a straight line between computed states
                share, ahead = (time - begin) / (0.5 * trial.length), trial.full if late else trial.half
                return tuple(a + share * (b - a) for a, b in zip(state, ahead, strict=True))
            state = after[: self.size]
        return state

    def _scale(self, k: int, value: float | None = None) -> float:
        """Return the known range of a judged output."""
        if not self.convergence_scales:
            return 1.0
        low, high = self.low[k], self.high[k]
        if value is not None:
            low, high = min(low, value), max(high, value)
        earlier_range = self.plan.ranges[k] if self.plan.ranges else 0.0
        return max(high - low, earlier_range, self.plan.compiled.convergence_scales[k][1])


def _find_lapse(drive_inputs: Sequence[Moments | float]) -> float:
    return max((one.lapse for one in drive_inputs if isinstance(one, Moments)), default=0.0)


def _compute_variation(rows: Sequence[Row], k: int) -> float:
    return sum(abs(b[k] - a[k]) for a, b in pairwise(rows))
