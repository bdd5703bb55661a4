"""Statics in closed form: how many strands, how long, under which stresses, against what.

With A the section of a strand, n strands, force F, stroke s, return stress σ_r, largest stress σ_m:

    spring   n A (σ_m - (1 + ρ) σ_r) ≥ F        preload n A σ_r, rate ρ n A σ_r/s
    weight   n A σ_m ≥ F                        weight W = max(F, n A σ_r)
    strain   ε = min(ε_m, 0.98 ε_f)             ε_f = ε_L + σ_c/E_M - σ_h/E_A
    length   l = s/ε

σ_c is the stress of the cold wire and σ_h that of the hot one at the end of the stroke: what the
wire stretches as its load grows is taken off its stroke. ρ is the growth of the return spring's
force over the stroke as a share of its preload.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.design.sizing.request import WireRequest
from martensite.design.sizing.strand import Strand
from martensite.physics.materials.wires import GRAVITY, WireSize

USABLE = 0.98
"""Share of the strain between the pure phases that a design may use: the rest comes slowly."""


@dataclass(frozen=True)
class Statics:
    """Number, length and loads of the strands; forces are those of all strands together."""

    count: int
    strand: Strand
    strain: float
    """Contraction over the stroke [-]."""
    reachable: float
    """Contraction between the pure phases under these stresses [-]."""
    cold_stress: float
    """Stress at rest [Pa]."""
    hot_stress: float
    """Stress at the end of the stroke [Pa]."""
    preload: float
    """Force that stretches the cold strands [N]: of the return spring, or the whole weight."""
    stiffness: float
    """Rate of the return spring [N/m]; 0 with a weight."""
    extra: float
    """Part of the weight that is needed only to stretch the strands [N]; 0 with a spring."""
    work_force: float
    """Force of the strands at the end of the stroke [N]."""

    def mechanism(self, stroke: float, share: int = 1) -> AbstractMechanism:
        """Return and load together, or that part of them which one of `share` strands carries."""
        if self.stiffness == 0.0:
            return DeadWeight(mass=self.preload / GRAVITY / share)
        rate = (self.work_force - self.preload) / stroke
        return BiasSpring(stiffness=rate / share, preload=self.preload / share)


def compute_statics(request: WireRequest, size: WireSize, alloy: str) -> Statics:
    """The smallest number of strands of a size that carries the request, and their length."""
    area = size.section
    if request.bias == "spring":
        left = request.stress - (1.0 + request.spring_rise) * request.return_stress
        count = _count_strands(request.force, area * left)
        preload = count * area * request.return_stress
        stiffness, extra = request.spring_rise * preload / request.stroke, 0.0
        work = request.force + preload + stiffness * request.stroke
    else:
        count = _count_strands(request.force, area * request.stress)
        preload = work = max(request.force, count * area * request.return_stress)
        stiffness, extra = 0.0, preload - request.force
    cold, hot = preload / (count * area), work / (count * area)
    reachable = Strand(size, alloy, 1.0, request.ambient).reachable_strain(cold, hot)
    strain = min(request.strain, USABLE * reachable)
    strand = Strand(size, alloy, request.stroke / strain, request.ambient)
    return Statics(count, strand, strain, reachable, cold, hot, preload, stiffness, extra, work)


def _count_strands(force: float, each: float) -> int:
    """Whole strands for a force; a rounding error does not make one more."""
    return max(1, math.ceil(force / each * (1.0 - 1e-12)))
