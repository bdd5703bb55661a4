"""Elements with one phase state and one temperature.

Given the phase fractions at the end of a step, everything else follows in closed form:

    T    heat balance, linearised at the start of the step, with latent heat
    F    balance of the element (a spring at these fractions and T) with the mechanism

so the coupled step is a fixed point of the fractions (`laws.coupling`). It is of second order: power, resistance and
latent heat are mid-step values, to first order, and pure relaxation follows

    ΔT = [Δt (P - Q) + Δt² P' (½ coth(z/2) - 1/z)]/(C g),   g = z/(1 - exp(-z)),   z = Δt Q'/C,

so that one step reaches the steady state, and a linear power causes no error. A nonlinear element is linearised at the
previous force, and again at the new force. With a rate-dependent law the system is a set of ordinary differential
equations, which a method of higher order integrates (`laws.rosenbrock`).
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Self, cast

from martensite.actuators.elements.base import (
    AbstractElement,
    Condition,
    Effort,
    Heating,
    MaterialPoint,
    Pull,
    Spring,
    StoredHeat,
    equilibrium_force,
    points_of,
)
from martensite.actuators.elements.heat_steps import HeatLine, relax_heat
from martensite.base.interfaces import override
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian, value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.exchange import AbstractExchange
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.coupling import StepReport, advance_memory
from martensite.physics.laws.rosenbrock import Coupling, advance_rosenbrock
from martensite.physics.laws.surface_steps import SurfaceCoupling, SurfaceStep, advance_on_surface, fit_drive
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import Environment
from martensite.signals.moments import Moments

Column = Sequence[Scalar]
Loaded = Callable[[Namespace, Fractions, Scalar], Scalar]
"""Force [N] on the load line, at phase fractions and a temperature [K]."""


class LumpedState(NamedTuple):
    """State of a lumped element."""

    memory: Any
    """Memory of the law."""
    force: Scalar
    """[N]"""
    rate: Scalar
    """Rate of the martensite fraction in the last step [1/s], the next first guess."""
    worn: Any = ()
    """Wear by cycles (`laws.wear`)."""


class AbstractLumped(AbstractElement):
    """Uniform element; subclasses define its shape."""

    wear: Wear | None = None
    """Wear by cycles."""

    @property
    def uniform(self) -> bool:
        """Return whether one phase state holds for the whole element."""
        return True

    def apply_wear(self, xp: Namespace, worn: Any) -> Self:
        """Return the worn element, without further wear."""
        return self

    @abstractmethod
    def initial_fractions(self, xp: Namespace, stress: Scalar) -> Fractions:
        """Return the initial phase state under a stress [Pa], as far as the law keeps it."""

    @abstractmethod
    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the heat of the whole forward transformation [J] at (stress, temperature)."""

    @abstractmethod
    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        """Return the tangent at `force` [N] with frozen fractions and temperature [K]."""

    @abstractmethod
    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Return the stress [Pa] in the law, from the force [N]."""

    @abstractmethod
    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Return the strain [-] of the law, from the elongation [m]."""

    @abstractmethod
    def ohms(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, rphase: Scalar = 0.0
    ) -> Scalar:
        """Return the resistance [ohm] at a martensite and an R-phase fraction."""

    @override
    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> LumpedState:
        stress = self.stress(xp, force)
        memory, worn = self.warm_up(xp, stress, temperature)
        return LumpedState(memory, force, 0.0, worn)

    def warm_up(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> tuple[Any, Any]:
        """Return the initial memories of law and wear, under a stress [Pa] and at a temperature [K]."""
        fractions = self.initial_fractions(xp, stress)
        worn = () if self.wear is None else self.wear.begin(xp, fractions, stress)
        law = self.apply_wear(xp, worn).law
        memory = law.warm_up(xp, fractions, stress, temperature)
        return memory, worn if self.wear is None else self.wear.begin(xp, law.fractions(memory), stress)

    def init_in(self, fractions: Fractions, force: float, temperature: float) -> LumpedState:
        """Return the state in given phases under `force` [N] and at `temperature` [K], on floats."""
        stress = self.stress(floats, force)
        worn = () if self.wear is None else self.wear.begin(floats, fractions, stress)
        memory = self.apply_wear(floats, worn).law.init(floats, fractions, stress, temperature)
        return LumpedState(memory, force, 0.0, worn)

    @override
    def force(self, state: LumpedState) -> Scalar:
        return state.force

    @override
    def in_state(
        self, xp: Namespace, state: LumpedState, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> LumpedState:
        stress = self.stress(xp, force)
        law = self.apply_wear(xp, state.worn).law
        worn = state.worn if self.wear is None else state.worn._replace(martensite=fractions.martensite, stress=stress)
        moved = law.relocate(xp, state.memory, fractions, stress, temperature)
        return LumpedState(moved, force, state.rate, worn)

    @override
    def tangent(self, xp: Namespace, state: LumpedState, force: Scalar) -> Spring:
        fractions = self.law.fractions(state.memory)
        return self.apply_wear(xp, state.worn).spring(xp, fractions, state.memory.temperature, force)

    @override
    def advance(
        self, xp: Namespace, state: LumpedState, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[LumpedState, StepReport]:
        if self.wear is not None:
            after, report = self.apply_wear(xp, state.worn).advance(xp, state, heating, pull, dt)
            end, memory = self.law.fractions(after.memory), after.memory
            worn = self.wear.advance(xp, state.worn, end, memory.stress, memory.temperature, dt)
            return after._replace(worn=worn), report

        def loaded(xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
            return self._find_force(xp, fractions, temperature, pull, state.force)

        line = self._heat_line(xp, state, heating, loaded, dt)
        imposed = heating.temperature

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            temperature = line.temperature(fractions) if imposed is None else imposed
            return self.stress(xp, loaded(xp, fractions, temperature)), temperature

        memory, report = advance_memory(xp, self.law, state.memory, settle, dt, state.rate * dt)
        end = self.law.fractions(memory)
        force = loaded(xp, end, memory.temperature)
        moves = dt > 0.0
        change = end.martensite - line.fractions.martensite
        rate = xp.detach(xp.where(moves, change / xp.where(moves, dt, 1.0), state.rate))
        return LumpedState(memory, force, rate), report._replace(ripple=line.ripple)

    def _find_force(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, pull: Pull, force: Scalar
    ) -> Scalar:
        """Return the force [N] on the load line at frozen fractions and temperature [K], from a force nearby."""

        def near(xp: Namespace, force: Scalar) -> Spring:
            return self.spring(xp, fractions, temperature, force)

        return equilibrium_force(xp, near, pull, force, self.passes)

    @property
    def exchanges(self) -> bool:
        """Return True if the law is an exchange of layers, without wear."""
        return isinstance(self.law, AbstractExchange) and self.wear is None

    def advance_rosenbrock(
        self, xp: Namespace, state: LumpedState, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[LumpedState, LumpedState, LumpedState]:
        """Return states after a step of dt [s], in its middle, and after it to a lower order.

        The law must be an exchange of layers; `owed` of the heating is ignored.
        """
        law = cast(AbstractExchange, self.law)
        coupling, lumped = self._couple(xp, state, heating, pull, dt)
        after, middle, coarse = advance_rosenbrock(xp, law, state.memory, coupling, dt)
        return lumped(after), lumped(middle), lumped(coarse)

    @property
    @override
    def has_surface(self) -> bool:
        law = self.law
        return self.uniform and law.has_surface and law.constant_heat and self.wear is None and not law.has_rphase

    @override
    def advance_on_surface(
        self, xp: Namespace, state: LumpedState, halves: Sequence[Heating], pull: Pull, dt: Scalar
    ) -> SurfaceStep:
        first = halves[0]
        moments, later = (cast(Moments, one.drive) for one in halves)
        drive = fit_drive(moments, later, dt)

        def force(xp: Namespace, at: Column) -> Scalar:
            return self._find_force(xp, Fractions(at[0], at[0]), at[1], pull, state.force)

        def stress(xp: Namespace, at: Column) -> Scalar:
            return self.stress(xp, force(xp, at))

        def power(xp: Namespace, at: Column, share: float) -> Scalar:
            fractions = Fractions(at[0], at[0])
            ohms = self._ohms_of(xp, fractions, self._strain_under(xp, fractions, at[1], force(xp, at)), at[1])
            given = first.power_at(xp, drive(share), ohms) + first.owed / dt
            return given - self.heat_loss(xp, at[1], first.environment)

        latent = self.latent_heat_total(xp, state.memory.stress, state.memory.temperature)
        coupling = SurfaceCoupling(stress, power, latent, self.heat_capacity_total())
        step = advance_on_surface(xp, self.law, state.memory, coupling, dt)

        def lumped(memory: Any) -> LumpedState:
            change = step.slopes[1].fraction / dt
            return LumpedState(memory, force(xp, [memory.fraction, memory.temperature]), change)

        def incline(memory: Any, slope: Any) -> LumpedState:
            """Return the change of a state over the step at a slope of its memory."""
            at = [memory.fraction, memory.temperature]
            _, ((by_fraction, by_temperature),) = compute_jacobian(xp, lambda xp, x: [force(xp, x)], at)
            pulled = by_fraction * slope.fraction + by_temperature * slope.temperature
            return LumpedState(slope, pulled, 0.0)

        return step.convert(lumped, incline)

    @override
    def find_events(self, xp: Namespace, state: LumpedState, temperature: Scalar, stress: Scalar) -> list[Scalar]:
        return self.law.kinks(xp, state.memory._replace(temperature=temperature, stress=stress))

    def _couple(
        self, xp: Namespace, state: LumpedState, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[Coupling, Callable[[Any], LumpedState]]:
        """Return the coupling of a rate-dependent law in a step of dt [s], and a constructor of states."""
        law = cast(AbstractExchange, self.law)
        start, imposed = state.memory.temperature, heating.temperature

        def loaded(xp: Namespace, at: Column) -> Scalar:
            return self._find_force(xp, Fractions(at[0], at[1]), at[2], pull, state.force)

        def stress(xp: Namespace, at: Column) -> Scalar:
            return self.stress(xp, loaded(xp, at))

        def power(xp: Namespace, at: Column) -> Column:
            if imposed is not None:
                return [self.heat_capacity_total() * (imposed - start) / dt, 0.0]
            fractions, force = Fractions(at[0], at[1]), loaded(xp, at)
            strain = self._strain_under(xp, fractions, at[2], force)
            heat = heating.heat(xp, self.ohms(xp, at[0], strain, at[2]))
            return [heat.mean - self.heat_loss(xp, at[2], heating.environment), heat.slope]

        def latent(xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
            free = imposed is None
            return self.latent_heat_total(xp, stress, temperature) if free else 0.0

        def lumped(memory: Any) -> LumpedState:
            force = loaded(xp, [*law.fractions(memory), memory.temperature])
            return LumpedState(memory, force, state.rate)

        return Coupling(stress, power, latent, self.heat_capacity_total()), lumped

    @override
    def rates(self, state: LumpedState) -> list[Scalar]:
        return [state.rate]

    @override
    def warm_start(self, state: LumpedState, solved: LumpedState) -> LumpedState:
        return state._replace(rate=solved.rate)

    def _heat_line(self, xp: Namespace, state: LumpedState, heating: Heating, loaded: Loaded, dt: Scalar) -> HeatLine:
        """Return T at the end of the step as a function of the fractions there."""
        law, memory = self.law, state.memory
        start, stress = memory.temperature, memory.stress
        fractions = law.fractions(memory)
        phases, rphase = type(fractions), fractions[2:]
        strain = self._strain_under(xp, fractions, start, state.force)

        def loss(xp: Namespace, temperature: Scalar) -> Scalar:
            return self.heat_loss(xp, temperature, heating.environment)

        def power(xp: Namespace, at: Column) -> Column:
            heat = heating.heat(xp, self._ohms_of(xp, phases(at[0], at[0], *at[3:]), at[1], at[2]))
            return [heat.mean, heat.slope]

        def reached(xp: Namespace, at: Column) -> Column:
            there = phases(at[0], at[1], *at[3:])
            force = loaded(xp, there, at[2])
            return [self._strain_under(xp, there, at[2], force), self.stress(xp, force)]

        def latent(xp: Namespace, at: Column) -> Column:
            return [self.latent_heat_total(xp, *at)]

        lost, slope = value_and_slope(xp, loss, start)
        (given, change), (by_point, _) = compute_jacobian(xp, power, [fractions.martensite, strain, start, *rphase])
        _, (by_strain, by_stress) = compute_jacobian(xp, reached, [*fractions[:2], start, *rphase])
        (heat,), (by_state,) = compute_jacobian(xp, latent, [stress, start])
        capacity = self.heat_capacity_total()
        less = slope - by_point[2] - by_point[1] * by_strain[2]
        ohms = self._ohms_of(xp, fractions, strain, start)
        share, taken = relax_heat(xp, dt, capacity, given - lost, change, less)
        return HeatLine(
            fractions=fractions,
            start=start,
            share=share,
            heat=taken + heating.owed,
            by_martensite=heat + 0.5 * dt * (by_point[0] + by_point[1] * by_strain[0]),
            by_oriented=0.5 * dt * by_point[1] * by_strain[1],
            by_rphase=0.5 * dt * (by_point[3] + by_point[1] * by_strain[3]) if rphase else 0.0,
            latent=heat,
            released_fraction=law.released_fraction,
            bend_martensite=0.5 * by_state[0] * by_stress[0],
            bend_oriented=0.5 * by_state[0] * by_stress[1],
            bend_temperature=0.5 * (by_state[0] * by_stress[2] + by_state[1]),
            ripple=heating.ripple(xp, ohms, capacity, dt),
        )

    def _ohms_of(self, xp: Namespace, fractions: Fractions, strain: Scalar, temperature: Scalar) -> Scalar:
        rphase = [fractions.rphase_fraction] if self.law.has_rphase else []
        return self.ohms(xp, fractions.martensite, strain, temperature, *rphase)

    def _strain_under(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Scalar:
        """Return the strain [-] by elongation; in coils stress and contact do not follow the law's strain."""
        spring = self.spring(xp, fractions, temperature, force)
        return self.strain(xp, spring.free + spring.compliance * force)

    @override
    def points(self, xp: Namespace, state: LumpedState) -> list[MaterialPoint]:
        return points_of(xp, self.apply_wear(xp, state.worn).law, [state.memory])

    def heat_content(self, xp: Namespace, state: LumpedState) -> Scalar | None:
        """Return C T - λ ξ [J] for a constant latent heat λ."""
        if not self.law.constant_heat:
            return None
        memory = state.memory
        latent = self.latent_heat_total(xp, memory.stress, memory.temperature)
        released = self.law.released_fraction(self.law.fractions(memory))
        return self.heat_capacity_total() * memory.temperature - latent * released

    @override
    def stored_heat(self, xp: Namespace, state: LumpedState) -> StoredHeat:
        memory = state.memory
        latent = self.apply_wear(xp, state.worn).latent_heat_total(xp, memory.stress, memory.temperature)
        released = self.law.released_fraction(self.law.fractions(memory))
        sensible = self.heat_capacity_total() * memory.temperature
        return StoredHeat(sensible, (Effort(-latent, released),))

    @override
    def elastic_energy(self, xp: Namespace, state: LumpedState) -> Scalar | None:
        fractions, temperature = self.law.fractions(state.memory), state.memory.temperature
        return self.elastic_energy_at(xp, fractions, temperature, state.force)

    def elastic_energy_at(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> Scalar | None:
        """Return ½ compliance · force² [J] under a force [N]; None for a nonlinear element."""
        if self.passes > 1:
            return None
        spring = self.spring(xp, fractions, temperature, force)
        return 0.5 * spring.compliance * force * force

    @override
    def condition(self, xp: Namespace, state: LumpedState, force: Scalar, environment: Environment) -> Condition:
        memory = state.memory
        fractions, temperature = self.law.fractions(memory), memory.temperature
        strain = self.strain(xp, self.elongation(xp, state, force))
        return Condition(
            temperature=temperature,
            hottest=temperature,
            martensite_fraction=fractions.martensite,
            oriented_fraction=fractions.oriented,
            stress=self.stress(xp, force),
            strain=strain,
            resistance=self._ohms_of(xp, fractions, strain, temperature),
            heat_loss=self.heat_loss(xp, temperature, environment),
            rphase_fraction=fractions.rphase_fraction,
        )
