"""Müller–Achenbach–Seelecke law of a polycrystal: groups of layers in series.

    ε = Σ wᵢ { ε_T (x₊ᵢ - x₋ᵢ) + σ [(x₊ᵢ + x₋ᵢ)/E_M + Aᵢ/E_A] }

Every group follows the single-crystal law with the barrier form of the rates. Groups differ by a normal distribution of
standard deviation `spread`, at the medians of equally probable classes of equal weight:

- `barriers` (default): each group has its own threshold σ_A + δᵢ. Plateaus get slopes, minor loops are smooth, a wire
  under tension returns to its start.
- `internal-stress`: each group has its own stress σ + σᵢ, for comparison. Groups with σ + σᵢ < 0 turn into M- on
  cooling and a weak bias cannot turn them back: a tension wire loses part of its stroke, a known defect.

With zero spread both are the single crystal.

Sources: Heintze and Seelecke (2008) and Massad and Smith (2005) for the superposition.
"""

from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import NamedTuple

from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column
from martensite.physics.kinetics.barriers import (
    Process,
    RateStart,
    build_wells,
    compute_edges,
    compute_rate,
    compute_scales,
    keep_process,
)
from martensite.physics.kinetics.exchange import AbstractExchange, Flows, exchange_fractions, mean_flows
from martensite.physics.kinetics.layers import PRESENT, Pull, VariantFractions, split_variants
from martensite.physics.laws.base import LAWS, Fractions

Column = Sequence[Scalar]


class PolycrystalMemory(NamedTuple):
    """Memory of a polycrystal: the variants of each group."""

    plus: Column
    minus: Column
    mean: Fractions
    stress: Scalar
    temperature: Scalar


class PolycrystalStep(NamedTuple):
    """Step from the remembered point; one entry per group."""

    plus: Column
    minus: Column
    starts: tuple[Column, ...]
    pull: Pull
    rest: Scalar
    """Overshoot at the start [Pa]; a process in progress stays near it."""


@LAWS.register("mas-polycrystal")
class MullerAchenbachSeeleckePolycrystal(AbstractExchange):
    """Groups of layers with distributed barriers (or internal stresses), in series."""

    has_groups = True
    cites = ("heintze2008", "massad2005", "ullrich2014")

    spread: Number = param("Pa", "standard deviation of barriers or internal stresses", low=0.0, high=1e9, default=20e6)
    groups: str = option("number of groups", "31", "15", default="31")
    distribution: str = option("what differs between groups", "barriers", "internal-stress", default="barriers")

    def quantiles(self) -> tuple[float, ...]:
        """Return the deviations of the groups in standard deviations [-]."""
        count = int(self.groups)
        return tuple(NormalDist().inv_cdf((k + 0.5) / count) for k in range(count))

    def shifts(self, quantile: Scalar) -> tuple[Scalar, Scalar]:
        """Return the shifts of threshold and stress of a group [Pa]."""
        shift = self.spread * quantile
        return (shift, 0.0) if self.distribution == "barriers" else (0.0, shift)

    @override
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> PolycrystalMemory:
        present, count = split_variants(fractions), int(self.groups)
        columns = (present.plus,) * count, (present.minus,) * count
        return PolycrystalMemory(*columns, fractions, stress, temperature)

    def relocate(
        self, xp: Namespace, memory: PolycrystalMemory, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> PolycrystalMemory:
        """Scale a shrinking variant by one factor in all groups; a growing one grows in proportion to austenite."""
        before, after = split_variants(memory.mean), split_variants(fractions)

        def shrunk(now: Scalar, then: Scalar) -> Scalar:
            falls = now > then
            return xp.where(falls, then / xp.where(falls, now, 1.0), 1.0)

        keep = VariantFractions(*(shrunk(a, b) for a, b in zip(before, after, strict=True)))
        free = 1.0 - before.plus * keep.plus - before.minus * keep.minus
        some = free > PRESENT
        per = xp.where(some, 1.0 / xp.where(some, free, 1.0), 0.0)
        grow = VariantFractions(*(per * xp.maximum(b - a, 0.0) for a, b in zip(before, after, strict=True)))

        def group(plus: Scalar, minus: Scalar) -> tuple[Scalar, Scalar]:
            plus, minus = plus * keep.plus, minus * keep.minus
            left = 1.0 - plus - minus
            return plus + grow.plus * left, minus + grow.minus * left

        columns = xp.each(group, memory.plus, memory.minus)
        plus, minus = columns
        return self.remember(xp, plus, minus, stress, temperature)

    @override
    def populations(self, memory: PolycrystalMemory) -> tuple[Column, Column]:
        return memory.plus, memory.minus

    @override
    def remember(
        self, xp: Namespace, plus: Column, minus: Column, stress: Scalar, temperature: Scalar
    ) -> PolycrystalMemory:
        mean = self.mean(xp, plus, minus)
        return PolycrystalMemory(tuple(plus), tuple(minus), mean, stress, temperature)

    @override
    def jumps(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Callable[[Scalar], Flows]:
        four, time = self.group(xp, stress, temperature), self.layer_time
        return lambda quantile: Flows(*(compute_rate(xp, process, time) for process in four(quantile)))

    @override
    def fractions(self, memory: PolycrystalMemory) -> Fractions:
        return memory.mean

    def mean(self, xp: Namespace, plus: Column, minus: Column) -> Fractions:
        """Return the fractions of all groups together."""
        share = 1.0 / len(plus)
        a, b = share * sum_column(plus), share * sum_column(minus)
        return Fractions(xp.minimum(a + b, 1.0), a - b)

    @override
    def select(self, xp: Namespace, memory: PolycrystalMemory, stress: Scalar, temperature: Scalar) -> PolycrystalStep:
        group = self.group(xp, memory.stress, memory.temperature)

        def start(quantile: Scalar) -> tuple[Scalar, ...]:
            return tuple(n for process in group(quantile) for n in keep_process(xp, process))

        pull = self.strongest(xp, split_variants(memory.mean), stress, temperature)
        rest = self.overshoot(xp, pull, memory.stress, memory.temperature)
        starts = xp.each(start, self.quantiles())
        return PolycrystalStep(memory.plus, memory.minus, starts, pull, rest)

    def group(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Callable[[Scalar], tuple[Process, ...]]:
        """Return the four processes at a point, as a function of the quantile of a group.

        All groups use the bridge between the wells of the mean threshold; beyond the opposite threshold, where no layer
        jumps, the barrier grows as a parabola.
        """
        constants, threshold = self.material(), self.linear_transition_stress(temperature)
        middle = build_wells(xp, constants, threshold, temperature, self.form)
        scale = compute_scales(xp, constants, middle, self.form)

        def four(quantile: Scalar) -> tuple[Process, ...]:
            barrier, inner = self.shifts(quantile)
            rise, local = xp.maximum(threshold + barrier, 0.0), stress + inner
            at = middle._replace(stress_A=rise, stress_M=rise - self.Delta_sigma)
            return *compute_edges(xp, at, scale, local), *compute_edges(xp, at, scale, -local)

        return four

    def groups_after(
        self, xp: Namespace, move: PolycrystalStep, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[Column, Column]:
        """Return the variants of all groups if the step of dt [s] ends at (stress, temperature)."""
        group = self.group(xp, stress, temperature)

        def advance(quantile: Scalar, plus: Scalar, minus: Scalar, *numbers: Scalar) -> tuple[Scalar, Scalar]:
            starts = [RateStart(*pair) for pair in zip(numbers[::2], numbers[1::2], strict=True)]
            flows = mean_flows(xp, starts, group(quantile), dt / self.layer_time)
            return exchange_fractions(xp, VariantFractions(plus, minus), flows)

        plus, minus = xp.each(advance, self.quantiles(), move.plus, move.minus, *move.starts)
        return plus, minus

    @override
    def follow(
        self, xp: Namespace, move: PolycrystalStep, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        return self.mean(xp, *self.groups_after(xp, move, stress, temperature, dt))

    @override
    def commit(
        self,
        xp: Namespace,
        memory: PolycrystalMemory,
        move: PolycrystalStep,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> PolycrystalMemory:
        plus, minus = self.groups_after(xp, move, stress, temperature, dt)
        return self.remember(xp, plus, minus, stress, temperature)

    @override
    def drive(self, xp: Namespace, move: PolycrystalStep, stress: Scalar, temperature: Scalar, dt: Scalar) -> Scalar:
        return self.overshoot(xp, move.pull, stress, temperature) - move.rest
