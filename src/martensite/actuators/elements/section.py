"""Elements with a strain that varies over the section: twisted, bent, or wound into a coil.

Plane sections stay plane: with the strain ℓ_i per elongation e, a fibre of volume V_i has

    ε_i = ℓ_i e,        F = Σ V_i ℓ_i σ_i

by virtual work. Each fibre has a memory of the law, all have one temperature; at frozen fractions they are parallel
springs. With `section_model = "surface"` the surface fibre represents all: F = σ Σ V_i ℓ_i²/ℓ_n, exact for an elastic
section. Torsion is equivalent to σ = √3 τ and ε = γ/√3.

Sections and laws are symmetric: fibres in compression mirror the other side and are not computed. A fibre may still
change the sign of its stress, such as the surface of a yielded bar on unloading; the law then handles this stress.
"""

import math
from abc import abstractmethod
from functools import cache
from typing import Any, NamedTuple

from martensite.actuators.elements.base import (
    AbstractElement,
    Condition,
    Effort,
    Heating,
    MaterialPoint,
    Pull,
    Spring,
    StoredHeat,
    points_of,
)
from martensite.actuators.elements.columns import Point, SectionHeat
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.actuators.elements.network import Column
from martensite.actuators.elements.section_step import advance_fibres, advance_section
from martensite.actuators.elements.wire import AbstractRoundWire
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import option
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import choose_tuple, map_tuples, sum_column, sum_columns
from martensite.physics.laws.base import COLD, SHELF_TIME, Fractions
from martensite.physics.laws.coupling import StepReport
from martensite.physics.thermal.base import Environment

ROOT3 = math.sqrt(3.0)
"""Equivalent stress per shear stress."""
LOST = 1e-9
"""Loss of martensite fraction above which a section is no longer in its trained state."""


class Section(NamedTuple):
    """State of a section of fibres: memories, the surface last, and the force [N]."""

    memories: tuple[Any, ...]
    force: Scalar
    rate: Scalar = 0.0


@cache
def find_section_points(count: int) -> tuple[tuple[float, float], ...]:
    """Return rising points in (0, 1] and weights of the interpolating rule at cos(2πk/(2n - 1)), k = 0 … n - 1.

    One point is on the surface; weights are positive with sum 1, and polynomials of degree n - 1 are exact.
    """
    whole, rows = 2 * count - 1, list[tuple[float, float]]()
    for k in range(count - 1, -1, -1):
        angle = 2.0 * math.pi * k / whole
        weight = 1.0 + 2.0 * sum(math.cos(j * angle) / (1 - j * j) for j in range(2, count, 2))
        rows.append((0.5 + 0.5 * math.cos(angle), (2.0 if k else 1.0) * weight / whole))
    return tuple(rows)


class AbstractSection(AbstractRoundWire, AbstractLumped):
    """Section of fibres; subclasses place them."""

    section_model: str = option(
        "what stands for the section: its surface, or fibres all over it", "surface", "fibres", default="fibres"
    )
    fibres: str = option("number of fibres, from the core to the surface", "5", "10", "20", "40", "80", default="20")

    @abstractmethod
    def fibre_columns(self, xp: Namespace) -> tuple[Column, Column]:
        """Return the strain per elongation [1/m] and volume [m³] of each fibre, the surface last."""

    def cut_rings(self, inner: Scalar, per_radius: Scalar) -> tuple[Column, Column]:
        """Return levers and volumes of rings outside a diameter [m], at a strain per elongation and radius [1/m²]."""
        wall, length = 0.5 * (self.diameter - inner), self.wire_length()
        rings = [(0.5 * inner + wall * s, wall * w) for s, w in find_section_points(int(self.fibres))]
        return [per_radius * r for r, _ in rings], [2.0 * math.pi * length * r * w for r, w in rings]

    def add_contact(self, xp: Namespace, open: Spring, force: Scalar) -> Spring:
        """Return the linear spring of the element near a force [N]; `open` is that of its fibres without contact."""
        return open

    @property
    @override
    def uniform(self) -> bool:
        return self.section_model == "surface"

    @override
    def check(self) -> None:
        super().check()
        law, lopsided = self.law, getattr(self.law, "compression", "") == "asymmetric"
        if not self.uniform and (lopsided or law.rate_dependent or law.has_groups or law.has_rphase or self.wear):
            raise ParameterError(
                f"Fibres of `{self.registered_name}` take symmetric laws of two phases without rates, such as "
                f"`brinson`, and no `wear`, but have `{law.registered_name}`"
                f"{' with `compression` = `asymmetric`' * lopsided}; try `section_model` = `surface`."
            )

    @override
    def cautions(self) -> list[str]:
        law, cautions = self.law, super().cautions()
        cold, hot = (law.free_strain(floats, Fractions(0.0, 0.0), kelvin) for kelvin in (300.0, 400.0))
        if not self.uniform and cold != hot:
            cautions.append(
                "Thermal strain counts as a strain of the section, which expansion neither twists nor bends."
            )
        if not self.uniform and not law.has_twins:
            words = (
                f"All martensite of law `{law.registered_name}` is strained, in the core too, where a section is not"
            )
            cautions.append(f"{words}: what forms on cooling bears stress of both signs; prefer law `brinson`.")
        return cautions

    def compute_moments(self, xp: Namespace) -> tuple[Scalar, Scalar, Scalar]:
        """Return Σ V ℓ, Σ V ℓ² and the lever of the surface."""
        levers, volumes = self.fibre_columns(xp)
        grips = [v * w for w, v in zip(levers, volumes, strict=True)]
        return sum_column(grips), sum_column([g * w for g, w in zip(grips, levers, strict=True)]), levers[-1]

    @override
    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        first, second, lever = self.compute_moments(xp)
        per_strain = 1.0 / lever if self.uniform else first / second
        free = self.law.free_strain(xp, fractions, temperature) * per_strain
        return self.add_contact(xp, Spring(free, self.law.compliance(xp, fractions) / second), force)

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Return the stress at the surface of an elastic section [Pa]; for torsion √3 τ."""
        _, second, lever = self.compute_moments(xp)
        return force * (lever / second)

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Return the strain at the surface [-]; for torsion γ/√3."""
        return elongation * self.compute_moments(xp)[2]

    def find_fibre_stress(self, xp: Namespace, fractions: Fractions, strain: Scalar, temperature: Scalar) -> Scalar:
        """Return the stress [Pa] of a fibre at frozen fractions."""
        return (strain - self.law.free_strain(xp, fractions, temperature)) / self.law.compliance(xp, fractions)

    def combine_fibres(self, xp: Namespace, martensite: Column, oriented: Column, temperature: Scalar) -> Spring:
        """Return fibres at frozen fractions as one spring."""

        def one(m: Scalar, o: Scalar, lever: Scalar, volume: Scalar) -> tuple[Scalar, Scalar]:
            grip = volume * lever / self.law.compliance(xp, Fractions(m, o))
            return grip * lever, grip * self.law.free_strain(xp, Fractions(m, o), temperature)

        stiffness, pull = xp.each(one, martensite, oriented, *self.fibre_columns(xp))
        whole, pulls = sum_columns(xp, stiffness, pull)
        soft = 1.0 / whole
        return Spring(soft * pulls, soft)

    def freeze_fibres(self, xp: Namespace, state: Section, temperature: Scalar) -> Spring:
        """Return the fibres of a state as one spring, at a temperature [K]."""
        fractions = [self.law.fractions(memory) for memory in state.memories]
        return self.combine_fibres(xp, [f.martensite for f in fractions], [f.oriented for f in fractions], temperature)

    def mean_fractions(self, xp: Namespace, state: Section) -> Fractions:
        """Return the volume average of the phase state."""
        volumes = self.fibre_columns(xp)[1]
        fractions = [self.law.fractions(memory) for memory in state.memories]
        rows = list(zip(volumes, fractions, strict=True))
        m, o = sum_columns(xp, [v * f.martensite for v, f in rows], [v * f.oriented for v, f in rows])
        return Fractions(m / sum_column(volumes), o / sum_column(volumes))

    def locate_surface(self, xp: Namespace, state: Section) -> Point:
        """Return the elongation [m] and temperature [K] at the end of the last step, from the surface."""
        last = state.memories[-1]
        strain = self.law.strain(xp, self.law.fractions(last), last.stress, last.temperature)
        return Point(strain / self.fibre_columns(xp)[0][-1], last.temperature)

    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Any:
        """Return the initial equilibrium under `force` [N] and at `temperature` [K].

        The section was cold and trained, and was warmed under the force. If no fibre loses martensite, it starts as
        trained.
        """
        if self.uniform:
            return super().init(xp, force, temperature)
        trained, cold = (self._init_trained(xp, force, at) for at in (temperature, COLD))
        heat = SectionHeat(temperature, 0.0, 0.0, 0.0, 0.0)
        warm, _ = advance_fibres(xp, self, cold, heat, lambda xp, spring: force, SHELF_TIME)
        before, after = (self.mean_fractions(xp, one).martensite for one in (trained, warm))
        flag = after < before - LOST

        def choose(one: Any, other: Any) -> Any:
            return choose_tuple(xp, flag, one, other)

        memories = map_tuples(choose, xp, warm.memories, trained.memories)
        return Section(tuple(memories), xp.where(flag, warm.force, trained.force))

    def _init_trained(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Section:
        """Return the trained state: orientation (without twins all martensite) falls to zero at the core."""
        levers, stress = self.fibre_columns(xp)[0], self.stress(xp, force)

        def train(lever: Scalar) -> tuple[Scalar, Scalar]:
            share = lever / levers[-1]
            own = self.initial_fractions(xp, stress * share)
            return own.martensite if self.law.has_twins else own.martensite * share, own.oriented * share

        martensite, oriented = xp.each(train, levers)
        whole = self.add_contact(xp, self.combine_fibres(xp, martensite, oriented, temperature), force)
        e = whole.free + whole.compliance * force

        def load(martensite: Scalar, oriented: Scalar, lever: Scalar) -> Any:
            fractions = Fractions(martensite, oriented)
            stress = self.find_fibre_stress(xp, fractions, lever * e, temperature)
            return self.law.init(xp, fractions, stress, temperature)

        return Section(tuple(map_tuples(load, xp, martensite, oriented, levers)), force)

    @override
    def tangent(self, xp: Namespace, state: Any, force: Scalar) -> Spring:
        if self.uniform:
            return super().tangent(xp, state, force)
        return self.add_contact(xp, self.freeze_fibres(xp, state, state.memories[-1].temperature), force)

    @override
    def advance(self, xp: Namespace, state: Any, heating: Heating, pull: Pull, dt: Scalar) -> tuple[Any, StepReport]:
        if self.uniform:
            return super().advance(xp, state, heating, pull, dt)
        return advance_section(xp, self, state, heating, pull, dt)

    @override
    def in_state(self, xp: Namespace, state: Any, fractions: Fractions, temperature: Scalar, force: Scalar) -> Any:
        if self.uniform:
            return super().in_state(xp, state, fractions, temperature, force)
        return AbstractElement.in_state(self, xp, state, fractions, temperature, force)

    @property
    @override
    def exchanges(self) -> bool:
        return self.uniform and super().exchanges

    @override
    def points(self, xp: Namespace, state: Any) -> list[MaterialPoint]:
        return super().points(xp, state) if self.uniform else points_of(xp, self.law, state.memories)

    @override
    def heat_content(self, xp: Namespace, state: Any) -> Scalar | None:
        if self.uniform or not self.law.constant_heat:
            return super().heat_content(xp, state) if self.uniform else None
        stored = self.stored_heat(xp, state)
        return stored.sensible + stored.latent[0].way

    @override
    def stored_heat(self, xp: Namespace, state: Any) -> StoredHeat:
        if self.uniform:
            return super().stored_heat(xp, state)
        latent, law = self.density * self.latent_heat, self.law

        def hold(volume: Scalar, memory: Any) -> Effort:
            heat = volume * law.heat(xp, latent, memory.stress, memory.temperature)
            return Effort(-heat, law.released_fraction(law.fractions(memory)))

        efforts = map_tuples(hold, xp, self.fibre_columns(xp)[1], state.memories)
        if law.constant_heat:  # the energy itself, as one number
            efforts = [Effort(1.0, *sum_columns(xp, [heat * share for heat, share in efforts]))]
        return StoredHeat(self.heat_capacity_total() * state.memories[-1].temperature, tuple(efforts))

    @override
    def elastic_energy(self, xp: Namespace, state: Any) -> Scalar | None:
        if self.uniform:
            return super().elastic_energy(xp, state)

        def store(volume: Scalar, memory: Any) -> Scalar:
            return 0.5 * volume * self.law.compliance(xp, self.law.fractions(memory)) * memory.stress**2

        return sum_columns(xp, map_tuples(store, xp, self.fibre_columns(xp)[1], state.memories))[0]

    def condition(self, xp: Namespace, state: Any, force: Scalar, environment: Environment) -> Condition:
        """Return the measurable condition under a force [N]; the stress is the largest in the section."""
        if self.uniform:
            return super().condition(xp, state, force, environment)
        temperature, e = state.memories[-1].temperature, self.elongation(xp, state, force)

        def load(lever: Scalar, memory: Any) -> Scalar:
            return self.find_fibre_stress(xp, self.law.fractions(memory), lever * e, temperature)

        def compare(largest: Scalar, stress: Scalar) -> tuple[Scalar]:
            return (xp.where(xp.abs(stress) > xp.abs(largest), stress, largest),)

        stresses = map_tuples(load, xp, self.fibre_columns(xp)[0], state.memories)
        largest = xp.scan(compare, (0.0,), stresses)[0][-1]
        mean, strain = self.mean_fractions(xp, state), self.strain(xp, e)
        return Condition(
            temperature=temperature,
            hottest=temperature,
            martensite_fraction=mean.martensite,
            oriented_fraction=mean.oriented,
            stress=largest,
            strain=strain,
            resistance=self.ohms(xp, mean.martensite, strain, temperature),
            heat_loss=self.heat_loss(xp, temperature, environment),
        )
