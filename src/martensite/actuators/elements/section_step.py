"""One step of an element with fibres.

The unknowns are the stress σ_i of each fibre, and the common elongation e and temperature T. A law is explicit in
stress and temperature, so plane sections, heat and force read

    ε_i(σ_i, T) = ℓ_i e,      T = T_b + share · Σ V_i h_i (ξ_i - ξ_i0) + …,      F = Σ V_i ℓ_i σ_i,

where ε_i includes the fractions of the law. Linearised, F and heat are sums, linear in e and T, T is eliminated, and
the mechanism meets a spring: Newton's method for all unknowns, with one evaluation of the law per fibre.

ε_i rises with σ_i; with the fibres solved, the heat mismatch rises with T, and then F with e. If a correction exceeds a
quarter of the smallest before, an iteration solves one level below: fibres at given e and T, T at given e, or e, each
in a shrinking bracket. A law selects its process at the start of a move. Transforming fibres load the others: if there
are both, all select again at the new elongation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.base import Heating, Pull, Spring, equilibrium_force
from martensite.actuators.elements.columns import LARGE, Bracket, Point, Round, SectionHeat, Turn
from martensite.actuators.elements.heat_steps import relax_heat
from martensite.actuators.elements.network import Column
from martensite.kernels.dual import compute_jacobian, value_and_slope, values_and_slopes
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, sum_column, sum_columns
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.coupling import StepReport

if TYPE_CHECKING:
    from martensite.actuators.elements.section import AbstractSection, Section

TURNS, ROUNDS = 80, 4
"""Largest numbers of iterations, and of rounds in which processes are selected."""
QUARTER = 0.25
PER_KELVIN = 1e-3
"""Strain equivalent to one kelvin in the comparison of corrections [1/K]."""
SOLVED, NEAR, FORESEEN = 1e-15, 1e-10, 1e-17
"""Correction [-] that ends the solve; one below which the next is predicted; predicted size that ends the solve."""
MOVED = 1e-13
"""Change of a fraction [-] above which a fibre transforms."""
WIDER = 1.01
"""Factor that widens bounds, because the root may lie on a bound."""
LEAST = 1e-300


def advance_section(
    xp: Namespace, element: AbstractSection, state: Section, heating: Heating, pull: Pull, dt: Scalar
) -> tuple[Section, StepReport]:
    """Return the state after a step of dt [s], and the report of the step."""
    heat = _balance_heat(xp, element, state, heating, element.locate_surface(xp, state), dt)
    return advance_fibres(xp, element, state, heat, pull, dt)


def advance_fibres(
    xp: Namespace, element: AbstractSection, state: Section, heat: SectionHeat, pull: Pull, dt: Scalar
) -> tuple[Section, StepReport]:
    """Return the state after a step of dt [s] with a given heat balance, and the report of the step."""
    start = element.locate_surface(xp, state)
    move = NestedShape(element.law.select(xp, state.memories[0], 0.0, heat.base))
    step = SectionStep(element, state, pull, dt, start, heat, move, *element.fibre_columns(xp))
    trial = Point(step.meet_mechanism(xp, element.freeze_fibres(xp, state, heat.base))[0], heat.base)
    none = (0.0,) * len(step.levers)
    begin = Round(1.0, 1.0, trial, 0.0, none, none, none, (none,) * len(flatten_numbers(move.example)))
    return step.commit_fibres(xp, _iterate(xp, ROUNDS, step.solve_round, begin))


def _iterate(xp: Namespace, most: int, body: Callable[[Namespace, Any], Any], begin: Any) -> Any:
    """Return the state after iterations of a body while its first value is above 0."""
    shape = NestedShape(begin)

    def turn(*numbers: Scalar) -> list[Scalar]:
        return flatten_numbers(body(xp, shape.rebuild(numbers)))

    return shape.rebuild(xp.iterate(most, turn, *flatten_numbers(begin)))


def _balance_heat(
    xp: Namespace, element: AbstractSection, state: Section, heating: Heating, start: Point, dt: Scalar
) -> SectionHeat:
    """Return the heat balance, linearised at the start of the step."""
    capacity = element.heat_capacity_total()

    def resist(xp: Namespace, at: Column) -> Scalar:
        return element.ohms(xp, at[0], element.strain(xp, at[1]), at[2])

    def power(xp: Namespace, at: Column) -> Column:
        heat = heating.heat(xp, resist(xp, at))
        return [heat.mean, heat.slope]

    at = [element.mean_fractions(xp, state).martensite, *start]
    ripple = heating.ripple(xp, resist(xp, at), capacity, dt)
    if heating.temperature is not None:
        return SectionHeat(heating.temperature, 0.0, 0.0, 0.0, ripple)
    lost, slope = value_and_slope(xp, lambda xp, t: element.heat_loss(xp, t, heating.environment), start.temperature)
    (given, change), (by_point, _) = compute_jacobian(xp, power, at)
    share, taken = relax_heat(xp, dt, capacity, given - lost, change, slope - by_point[2])
    by_martensite = 0.5 * dt * by_point[0] / sum_column(element.fibre_columns(xp)[1])
    return SectionHeat(
        start.temperature + share * (taken + heating.owed), share, by_martensite, 0.5 * dt * by_point[1], ripple
    )


@dataclass(frozen=True)
class SectionStep:
    """One step of an element of fibres; levers [1/m] and volumes [m³] are columns."""

    element: AbstractSection
    state: Section
    pull: Pull
    dt: Scalar
    start: Point
    heat: SectionHeat
    move: NestedShape
    """Shape of a process of the law."""
    levers: Column
    volumes: Column

    def meet_mechanism(self, xp: Namespace, spring: Spring) -> Sequence[Scalar]:
        """Return the equilibrium elongation [m] and force [N] of the section, as a spring, and the mechanism."""

        def near(xp: Namespace, force: Scalar) -> Spring:
            return self.element.add_contact(xp, spring, force)

        force = equilibrium_force(xp, near, self.pull, self.state.force, self.element.passes)
        whole = near(xp, force)
        return whole.free + whole.compliance * force, force

    def list_columns(self, moves: Sequence[Column] = ()) -> list[Column]:
        """Return levers, volumes, memories and moves, one column per value."""
        before = zip(*map(flatten_numbers, self.state.memories), strict=True)
        return [self.levers, self.volumes, *map(list, before), *moves]

    def split_row(self, numbers: Sequence[Scalar]) -> tuple[Any, Any]:
        """Return memory and move from the values of a fibre."""
        shape = NestedShape(self.state.memories[0])
        size = len(flatten_numbers(shape.example))
        return shape.rebuild(numbers[:size]), self.move.rebuild(numbers[size:]) if numbers[size:] else None

    def solve_round(self, xp: Namespace, now: Round) -> Round:
        """Return the solve with the processes that frozen fibres start at a point."""
        law, (e, temperature) = self.element.law, now.point

        def select(lever: Scalar, volume: Scalar, *flat: Scalar) -> list[Scalar]:
            memory, _ = self.split_row(flat)
            stress = self.element.find_fibre_stress(xp, law.fractions(memory), lever * e, temperature)
            move = law.select(xp, memory, stress, temperature)
            return [stress, law.crossing(xp, memory, move, stress, temperature), *flatten_numbers(move)]

        trial, crossing, *moves = xp.each(select, *self.list_columns())
        stress = tuple(xp.where(now.first > 0.0, a, b) for a, b in zip(trial, now.stress, strict=True))
        fill = [(x,) * len(stress) for x in (*Bracket()[:2], 0.0, 0.0)]
        begin = Turn(1.0, now.point, LARGE, LARGE, 0.0, Bracket(), Bracket(), LARGE, stress, *fill)
        last: Turn = _iterate(xp, TURNS, lambda xp, turn: self.take_step(xp, turn, moves), begin)
        far = PER_KELVIN * xp.abs(last.point.temperature - temperature)
        far = far + self.levers[-1] * xp.abs(last.point.elongation - e)
        going = xp.where(xp.both(last.mixed > 0.0, far > NEAR), 1.0, 0.0)
        ends = last.stress, last.martensite, last.oriented
        return Round(going, 0.0, last.point, find_largest(xp, crossing), *ends, tuple(map(tuple, moves)))

    def find_heat(
        self, xp: Namespace, memory: Any, volume: Scalar, stress: Scalar, temperature: Scalar, end: Fractions
    ) -> Scalar:
        """Return the heat [J] released by a fibre on its way to an end, at mean stress and temperature."""
        element, middle = self.element, (0.5 * (memory.stress + stress), 0.5 * (memory.temperature + temperature))
        latent = element.law.heat(xp, element.density * element.latent_heat, *middle)
        change = element.law.released_fraction(end) - element.law.released_fraction(element.law.fractions(memory))
        return volume * (latent + self.heat.by_martensite) * change

    def linearise_fibres(
        self, xp: Namespace, point: Point, stresses: Column, moves: Sequence[Column]
    ) -> tuple[Column, list[Column]]:
        """Return sums over the section; per fibre strain, derivatives, compliance, change and fractions.

        The sums are ∂F/∂e, F at zero elongation, -∂F/∂T, then the same of the heat of transformation (positive sign),
        and that heat.
        """
        law, temperature = self.element.law, point.temperature

        def one(stress: Scalar, lever: Scalar, volume: Scalar, *flat: Scalar) -> tuple[Scalar, ...]:
            memory, move = self.split_row(flat)

            def answer(xp: Namespace, stress: Scalar, temperature: Scalar) -> list[Scalar]:
                end = law.follow(xp, move, stress, temperature, self.dt)
                warm = self.find_heat(xp, memory, volume, stress, temperature, end)
                return [law.strain(xp, end, stress, temperature), warm, end.martensite, end.oriented]

            (strain, warm, *end), along = values_and_slopes(xp, lambda xp, s: answer(xp, s, temperature), stress)
            _, across = values_and_slopes(xp, lambda xp, t: answer(xp, stress, t), temperature)
            per, grows, grip = 1.0 / along[0], across[0], volume * lever
            gains = along[1] * per
            force = grip * lever * per, grip * (stress - strain * per), grip * grows * per
            heat = gains * lever, warm - gains * strain, across[1] - gains * grows
            before = law.fractions(memory)
            change = xp.abs(end[0] - before.martensite) + xp.abs(end[1] - before.oriented)
            slopes = along[2], across[2], along[3], across[3]
            return *force, *heat, warm, strain, per, grows, law.compliance(xp, Fractions(*end)), change, *end, *slopes

        columns = xp.each(one, stresses, *self.list_columns(moves))
        return sum_columns(xp, *columns[:7]), list(columns[7:])

    def solve_elongation(self, xp: Namespace, sums: Column, at: Scalar) -> tuple[Scalar, Callable[[Scalar], Scalar]]:
        """Return the elongation of the linearised balance at a temperature, and the warming at an elongation."""
        heat, (stiffness, push, softening, by_elongation, frozen, by_temperature, _) = self.heat, sums
        per = 1.0 / (1.0 - heat.share * by_temperature)
        none = per * (heat.base - at + heat.share * (frozen - heat.by_elongation * self.start.elongation))
        rate = per * heat.share * (by_elongation + heat.by_elongation)
        soft = 1.0 / (stiffness - softening * rate)
        return self.meet_mechanism(xp, Spring(soft * (softening * none - push), soft))[0], lambda e: none + rate * e

    def take_step(self, xp: Namespace, now: Turn, moves: Sequence[Column]) -> Turn:
        """Return the next iterate, from one evaluation of the law."""
        (e, at), levers, heat = now.point, self.levers, self.heat
        sums, (strain, per, grows, elastic, change, *ends) = self.linearise_fibres(xp, now.point, now.stress, moves)
        aim, warm = self.solve_elongation(xp, sums, at)
        off = find_largest(xp, [xp.abs(s - w * e) for s, w in zip(strain, levers, strict=True)])
        off_e, off_t = levers[-1] * xp.abs(aim - e), PER_KELVIN * xp.abs(warm(e))
        worst = xp.maximum(off, xp.maximum(off_e, off_t))
        ratio = worst / xp.maximum(now.last, LEAST)
        near = xp.either(worst * ratio * ratio <= FORESEEN, ratio >= 0.5)
        last = xp.either(worst <= SOLVED, xp.both(worst <= NEAR, near))
        quick = xp.either(last, worst < QUARTER * now.least)
        alone = xp.both(xp.negate(quick), off > QUARTER * xp.maximum(off_e, off_t))
        still = xp.both(xp.negate(quick), xp.either(alone, off_t > QUARTER * off_e))
        up, warmer = aim > e, warm(e) > 0.0
        outer = now.outer.narrow(xp, e, up, xp.where(up, LARGE, -LARGE))
        gap = heat.base - at + heat.share * (sums[6] + heat.by_elongation * (e - self.start.elongation))
        size = WIDER * xp.maximum(xp.abs(gap), xp.abs(warm(e)))
        middle = now.middle.narrow(xp, at, warmer, at + xp.where(warmer, size, -size))
        to = xp.where(quick, aim, xp.where(still, e, outer.limit(xp, aim, off_e)))
        hot = at + warm(to)
        hot = xp.where(alone, at, xp.where(still, middle.limit(xp, hot, off_t), hot))

        def move(lever: Scalar, *row: Scalar) -> tuple[Scalar, ...]:
            stress, strain, per, grows, elastic, low, high, *ends = row
            over, warmer = strain - lever * e, hot - at
            step = (lever * to - strain - grows * warmer) * per
            inner = Bracket(low, high, now.off).narrow(xp, stress, over < 0.0, stress - WIDER * over / elastic)
            step = xp.where(alone, inner.limit(xp, stress + step, xp.abs(over)) - stress, step)
            return stress + step, *Bracket().choose(xp, alone, inner)[:2], *_extrapolate(ends, step, warmer)

        columns = xp.each(move, levers, now.stress, strain, per, grows, elastic, now.low, now.high, *ends)
        some, all_do = find_largest(xp, change) > MOVED, find_largest(xp, [-x for x in change]) < -MOVED
        return Turn(
            xp.where(last, 0.0, 1.0),
            Point(to, hot),
            xp.minimum(now.least, worst),
            worst,
            xp.where(xp.both(some, xp.negate(all_do)), 1.0, 0.0),
            outer._replace(last=off_e).choose(xp, still, now.outer).choose(xp, quick, Bracket()),
            middle._replace(last=off_t).choose(xp, alone, now.middle).choose(xp, xp.negate(still), Bracket()),
            xp.where(alone, off, LARGE),
            *(tuple(column) for column in columns),
        )

    def commit_fibres(self, xp: Namespace, solved: Round) -> tuple[Section, StepReport]:
        """Return all fibres at the solved fractions, with exact plane sections and force."""
        law, (at, m, o) = self.element.law, self._follow_root(xp, solved)
        e, force = self.meet_mechanism(xp, self.element.combine_fibres(xp, m, o, at))

        def commit(m: Scalar, o: Scalar, lever: Scalar, volume: Scalar, *flat: Scalar) -> list[Scalar]:
            end, (memory, move) = Fractions(m, o), self.split_row(flat)
            stress = self.element.find_fibre_stress(xp, end, lever * e, at)
            reached = law.follow(xp, move, stress, at, self.dt)
            apart = xp.maximum(xp.abs(reached.martensite - m), xp.abs(reached.oriented - o))
            return [apart, *flatten_numbers(law.commit(xp, memory, move, end, stress, at, self.dt))]

        residual, *columns = xp.each(commit, m, o, *self.list_columns(solved.moves))
        memories = tuple(self.split_row(flat)[0] for flat in zip(*columns, strict=True))
        report = StepReport(find_largest(xp, residual), solved.crossing, self.heat.ripple)
        return self.state._replace(memories=memories, force=force), report

    def _follow_root(self, xp: Namespace, solved: Round) -> tuple[Scalar, Column, Column]:
        """Return temperature and fractions, with the derivatives of one Newton step."""
        e, at = (xp.detach(x) for x in solved.point)
        stress = [xp.detach(x) for x in solved.stress]
        sums, (strain, per, grows, _, _, *ends) = self.linearise_fibres(xp, Point(e, at), stress, solved.moves)
        aim, warm = self.solve_elongation(xp, sums, at)
        warmer = warm(aim)

        def follow(m: Scalar, o: Scalar, lever: Scalar, *row: Scalar) -> tuple[Scalar, Scalar]:
            strain, per, grows, *ends = row
            to_m, to_o = _extrapolate(ends, (lever * aim - strain - grows * warmer) * per, warmer)
            return xp.implicit_root(m, to_m), xp.implicit_root(o, to_o)

        columns = solved.martensite, solved.oriented, self.levers, strain, per, grows, *ends
        martensite, oriented = xp.each(follow, *columns)
        return xp.implicit_root(solved.point.temperature, at + warmer), martensite, oriented


def _extrapolate(ends: Sequence[Scalar], stress: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
    """Return the fractions after a change of stress and temperature, by their derivatives."""
    m, o, m_stress, m_heat, o_stress, o_heat = ends
    return m + m_stress * stress + m_heat * temperature, o + o_stress * stress + o_heat * temperature
