"""Thermally activated exchange between austenite and two martensite variants.

The free energy of a layer has parabolic wells for austenite (A) and the variants M+ and M-, joined by concave parabolas
with continuous slope:

    σ_A(T) = max(0, σ_L + s (T - T_L)),       σ_M = σ_A - Δσ
    ε_A = σ_A/E_A,   ε_M = ε_T + σ_M/E_M,     K = Δσ/(ε_M - ε_A)

Layers jump over the barrier ΔG from A to M+ at the rate p = exp(-λ ΔG)/τ, λ = V/(k_B T), and back in the same way; M-
mirrors M+ in σ. Three forms of the barrier:

- `barrier`: height of the saddle over the well, at given stress. Detailed balance is exact.
- `well`: layers at the edge of their well, a partition function over the well (erf, erfc). Rates keep growing beyond
  the threshold; softer plateaus; no exact detailed balance.
- `edge`: (σ_A - σ)²/2E_A and (σ - σ_M)²/2E_M, the barrier form with a rigid bridge.

With y = ±√(λ ΔG), negative beyond the threshold, p = q(y) exp(-⟨y⟩²)/τ. Over a step y is linear from y₀ to y₁. A
growing rate is averaged by the closed integral of the Gaussian. A falling rate counts with its end value, as in an
implicit step, so that a plateau held by feedback does not ring. The linear exchange at mean rates is solved exactly, so
a step never overshoots.

Sources: Achenbach (1989); Seelecke and Müller (2004), Appl. Mech. Rev. 57, for the model; the step is this package's.
"""

from typing import NamedTuple

from martensite.kernels.floats import ROOT_PI
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import compute_if

BOLTZMANN = 1.380649e-23
"""[J/K], exact by definition."""
COLDEST = 100.0
"""Lowest temperature of the rates [K]; solvers may try lower temperatures."""
FARTHEST = 26.0
"""Root of a barrier over which no layer jumps: exp(-y²) is below 1e-293."""
FLATTEST = 0.05
"""Lowest threshold σ_A in the form `well`, in thermal widths."""


class BarrierConstants(NamedTuple):
    """Constants of free energy and layers."""

    E_A: Scalar
    E_M: Scalar
    eps_T: Scalar
    width: Scalar
    """Δσ [Pa]."""
    volume: Scalar
    """V [m³]."""
    time: Scalar
    """τ [s]."""


class Wells(NamedTuple):
    """Free energy at one temperature."""

    stress_A: Scalar
    """A → M± at |σ| = stress_A [Pa]."""
    stress_M: Scalar
    gap: Scalar
    """ε_M - ε_A [-]."""
    per_energy: Scalar
    """λ [m³/J]."""


class Process(NamedTuple):
    """Transition over one barrier at one stress and temperature."""

    y: Scalar
    """Root of the barrier in thermal units; negative beyond the threshold."""
    factor: Scalar
    """Prefactor q of the Gaussian."""
    height: Scalar
    """⟨y⟩², without the root."""


class RateStart(NamedTuple):
    """Start of a step, for the mean rate."""

    y: Scalar
    tail: Scalar
    """(√π/2) erfc(⟨y⟩)."""


def build_wells(xp: Namespace, material: BarrierConstants, threshold: Scalar, temperature: Scalar, form: str) -> Wells:
    """Return the free energy for a threshold σ_A [Pa] before its limit at zero."""
    per_energy = material.volume / BOLTZMANN / xp.maximum(temperature, COLDEST)
    least = 0.0
    if form == "well":
        least = FLATTEST * xp.sqrt(2.0 * material.E_A / per_energy)
    stress_A = xp.maximum(threshold, least)
    stress_M = stress_A - material.width
    gap = material.eps_T + stress_M / material.E_M - stress_A / material.E_A
    gap = xp.maximum(gap, 1e-3 * material.eps_T)
    return Wells(stress_A, stress_M, gap, per_energy)


class BarrierScales(NamedTuple):
    """y per stress inside σ_A and σ_M [1/Pa]."""

    A: Scalar
    M: Scalar
    A_squared: Scalar
    """Square of `A`."""
    M_squared: Scalar


def compute_scales(xp: Namespace, material: BarrierConstants, at: Wells, form: str) -> BarrierScales:
    """Return the reciprocal thermal widths; the bridge between the wells softens the saddle."""
    bridge = at.gap / material.width if form == "barrier" else 0.0
    half = 0.5 * at.per_energy
    square_A, square_M = half * (1.0 / material.E_A + bridge), half * (1.0 / material.E_M + bridge)
    return BarrierScales(xp.sqrt(square_A), xp.sqrt(square_M), square_A, square_M)


def compute_edges(xp: Namespace, at: Wells, scale: BarrierScales, stress: Scalar) -> tuple[Process, Process]:
    """Return the processes inside σ_A and σ_M, to the variant favoured by positive stress and back."""
    up, down = at.stress_A - stress, stress - at.stress_M
    return _pass_edge(xp, up, scale.A, scale.A_squared), _pass_edge(xp, down, scale.M, scale.M_squared)


def _pass_edge(xp: Namespace, inside: Scalar, scale: Scalar, square: Scalar) -> Process:
    """Return the process at a stress inside its threshold [Pa]."""
    positive = xp.maximum(inside, 0.0)
    return Process(inside * scale, 1.0, square * positive * positive)


def build_processes(
    xp: Namespace, material: BarrierConstants, at: Wells, stress: Scalar, form: str
) -> tuple[Process, Process]:
    """Return the processes from austenite to the variant favoured by positive `stress`, and back."""
    scale = compute_scales(xp, material, at, form)
    over, back = compute_edges(xp, at, scale, stress)
    if form == "edge":
        return over, back
    if form == "barrier":
        return _compute_saddle(xp, material, at, stress, over, back)
    v = (at.stress_A + stress) * scale.A
    ratio = xp.sqrt(material.E_M / material.E_A)
    return _out_of_well(xp, over.y, v), back._replace(factor=ratio * _half_line(xp, back.y))


def _compute_saddle(
    xp: Namespace, material: BarrierConstants, at: Wells, stress: Scalar, over: Process, back: Process
) -> tuple[Process, Process]:
    """Return the processes inside their thresholds; beyond the other threshold without saddle."""
    up, down = at.stress_A - stress, stress - at.stress_M
    middle = (stress - 0.5 * (at.stress_A + at.stress_M)) * at.gap
    square = xp.where(stress < -at.stress_A, -4.0 * at.stress_A * stress, up * up)
    deep_A = at.per_energy * (0.5 * square / material.E_A - middle)
    deep_M = at.per_energy * (0.5 * down * down / material.E_M + middle)

    def choose(beyond: Flag, deep: Scalar, inside: Process) -> Process:
        y = xp.where(beyond, xp.sqrt(deep), inside.y)
        return Process(y, 1.0, xp.where(beyond, deep, inside.height))

    return choose(down < 0.0, deep_A, over), choose(up < 0.0, deep_M, back)


def _out_of_well(xp: Namespace, u: Scalar, v: Scalar) -> Process:
    """Return the rate over the edge at u of a well from -v to u, in thermal widths."""
    beyond, behind = u < 0.0, v < 0.0
    a, b = xp.abs(u), xp.abs(v)
    scaled_a, scaled_b = xp.erfcx(a), xp.erfcx(b)
    inner = 2.0 - xp.exp(-a * a) * scaled_a - xp.exp(-b * b) * scaled_b
    fade = xp.exp(-xp.abs(v * v - u * u))
    outer = xp.where(beyond, scaled_a - fade * scaled_b, scaled_b - fade * scaled_a)
    outside = xp.either(beyond, behind)
    weight = xp.where(outside, outer, inner)
    y = xp.where(behind, xp.sqrt((u - v) * (u + v)), u)
    a = xp.maximum(y, 0.0)
    return Process(y, 1.0 / xp.maximum(weight, 1e-12), a * a)


def _half_line(xp: Namespace, z: Scalar) -> Scalar:
    """Return the exp(⟨z⟩²)-scaled rate out of an unbounded well."""
    a = xp.abs(z)
    scaled = xp.erfcx(a)
    return 1.0 / xp.where(z > 0.0, 2.0 - xp.exp(-a * a) * scaled, scaled)


def compute_rate(xp: Namespace, process: Process, time: Scalar) -> Scalar:
    """Return the rate of a process [1/s]."""
    return process.factor * xp.exp(-process.height) / time


def keep_process(xp: Namespace, process: Process) -> RateStart:
    """Return the quantities at the start of a step that the mean rate needs."""

    def find_tail(y: Scalar) -> Scalar:
        return _compute_bell(xp, y)[1]

    acts = xp.both(process.y > 0.0, process.y < FARTHEST)
    other = xp.where(process.y > 0.0, 0.0, 0.5 * ROOT_PI)
    return RateStart(process.y, compute_if(xp, acts, find_tail, other, process.y))


def _compute_bell(xp: Namespace, a: Scalar) -> tuple[Scalar, Scalar]:
    """Return exp(-a²) and (√π/2) erfc(a), for a ≥ 0."""
    bell = xp.exp(-a * a)
    return bell, bell * (0.5 * ROOT_PI) * xp.erfcx(a)


def mean_rate(xp: Namespace, start: RateStart, end: Process) -> Scalar:
    """Return τ times the rate over a step: the mean of a growing rate, the end value of a falling one."""

    def average(before: Scalar, after: Scalar, tail: Scalar) -> Scalar:
        a = xp.maximum(after, 0.0)
        bell, left = _compute_bell(xp, a)
        fall = before - after
        grows = fall > 1e-7 * (1.0 + a)
        saturated = xp.maximum(-after, 0.0) - xp.maximum(-before, 0.0)
        mean = xp.where(grows, (saturated + left - tail) / xp.where(grows, fall, 1.0), bell)
        return xp.clip(mean, 0.0, 1.0)

    acts = xp.both(xp.maximum(start.y, end.y) > 0.0, end.y < FARTHEST)
    other = xp.where(end.y > 0.0, 0.0, 1.0)
    return end.factor * compute_if(xp, acts, average, other, start.y, end.y, start.tail)
