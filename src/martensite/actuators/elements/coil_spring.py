"""Close-coiled helical spring: torsion of the wire as an equivalent axial problem.

With wire diameter d, mean coil diameter D, N turns, elongation y and force F

    τ = 8 F D/(π d³),   γ = d y/(π N D²),   σ = √3 τ,   γ = √3 ε,   F y = τ γ Vol/2

so a law in σ and ε, with G = E/3, makes the spring

    F = [G(ξ) d⁴/(8 N D³)] (y - y_tr),      y_tr = π N D² √3 ε_tr/d.

With law `liang-rogers`, `modulus = "mixture"` and `transformation = "stress"` this is the published F = G(ξ) d⁴ y/(8 N
D³) + π d³ Ω ξ/(8 √3 D), where Ω = -ε_L E_M.

Elongation is counted from the unloaded austenite coil of length `free_length`. The stress is the equivalent stress at
the surface of the wire; one state represents the whole section. A coil cannot be shorter than N d: touching turns carry
compression with a stiffness of `contact` spring rates. At `deflection = "large"` the wire is a Kirchhoff rod
(`martensite.actuators.elements.helix`), which stiffens on elongation; force and stress keep the relation of the
unloaded coil. A `stress_factor` multiplies the stress only: law and limit then refer to the inner fibre, otherwise to
the mean of the surface, as published.

Sign convention: tension and elongation positive. Θ of the law would count as a shear, which free expansion does not
cause: leave it zero. Source: Liang and Rogers (1990) as restated, with its equation for the spring, by Ranjith Pillai
et al. (2018).
"""

import math
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from martensite.actuators.elements import coil_theory, helix
from martensite.actuators.elements.base import ELEMENTS, Spring
from martensite.actuators.elements.network import Column
from martensite.actuators.elements.section import ROOT3, AbstractSection
from martensite.base.errors import ParameterError, require_known
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import Fractions

STEEPEST = math.radians(10.0)
"""Largest pitch angle of the flat-coil theory without a caution."""


def _return_one(index: Scalar) -> Scalar:
    return 1.0


STRESS_FACTORS: dict[str, Callable[[Scalar], Scalar]] = {
    "none": _return_one,
    "bergstraesser": coil_theory.compute_bergstraesser_factor,
    "wahl": coil_theory.compute_wahl_factor,
    "exact": coil_theory.exact_stress,
}
STIFFNESS_FACTORS: dict[str, Callable[[Scalar], Scalar]] = {
    "none": _return_one,
    "ancker-goodier": coil_theory.ancker_goodier,
    "exact": coil_theory.exact_stiffness,
}


class Coil(NamedTuple):
    """Coil at a force, without contact."""

    open: Spring
    """Tangent of the open coil."""
    touch: Scalar
    """Force at which the turns touch [N]."""
    compliance: Scalar
    """Compliance at the touching force [m/N]."""


def _draw_out_rod(xp: Namespace, rod: helix.Helix, solid: Scalar, force: Scalar) -> Coil:
    """Return an elongated rod; `solid` is the length at which the turns touch [m]."""
    at, touching = helix.at_force(xp, rod, force), helix.at_length(xp, rod, solid)
    free = at.length - rod.length * rod.sine - at.compliance * at.force
    return Coil(Spring(free, at.compliance), touching.force, touching.compliance)


PHASES = ("austenite", "martensite")
ROOM = 293.15
"""Temperature of a stated spring rate [K], for laws with thermal expansion."""


@ELEMENTS.register("coil-spring")
class CoilSpring(AbstractSection):
    """Helical extension spring of round wire that transforms uniformly."""

    cites = ("liang1990", "ranjith2018", "wahl1963", "ancker1958", "love1927")
    passes: ClassVar[int] = 3
    straight: ClassVar[bool] = False

    diameter: Number = param("m", "wire diameter", above=0.0, high=0.02, typical="0.75 mm")
    coil_diameter: Number = param("m", "coil diameter", above=0.0, high=1.0, typical="4 mm")
    coil_measure: str = option("coil diameter measured between centres of the wire, or over all", "mean", "outer")
    turns: Number = param("1", "number of active turns", above=0.0, high=1e5, typical=10.0)
    free_length: Number = param(
        "m", "length of the active turns as unloaded austenite, at least N d", above=0.0, high=1e3, typical="10 mm"
    )
    deflection: str = option("theory: flat turns, or a rod that is drawn out", "small", "large", default="small")
    poisson: Number = param("1", "Poisson's ratio, for bending at large deflection", low=0.0, high=0.5, default=0.33)
    stress_factor: str = option(
        "what curvature adds to the stress that drives the law and is compared with its limit",
        *STRESS_FACTORS,
        default="none",
    )
    stiffness_factor: str = option("what curvature adds to the spring rate", *STIFFNESS_FACTORS, default="none")
    contact: Number = param("1", "stiffness of closed turns per spring rate", low=1.0, high=1e6, default=1e3)
    section_model: str = option(
        "what stands for the section of its wire: the surface, or fibres all over it",
        "surface",
        "fibres",
        default="surface",
    )

    @override
    def check(self) -> None:
        super().check()
        exact = "exact" in (self.stress_factor, self.stiffness_factor)
        least, words = (coil_theory.LEAST_INDEX, "at least 3") if exact else (1.0, "above 1")
        if self.mean_diameter() <= self.diameter or self.index() < least:
            raise ParameterError(
                f"The spring index D/d of `coil-spring`, from `coil_diameter` and `diameter`, "
                f"must be {words} with these options, but is {self.index():.4g}."
            )
        plain = (self.deflection, self.stress_factor, self.stiffness_factor) == ("small", "none", "none")
        if not (self.uniform or plain):
            raise ParameterError(
                "The fibres of a `coil-spring` are those of flat turns of little curvature: with `section_model` = "
                "`fibres`, `deflection` must be `small` and both factors `none`."
            )
        solid, steep = self.solid_length(), self.circumference() * self.turns
        if not solid * (1.0 - 1e-9) <= self.free_length <= steep:
            raise ParameterError(
                f"Parameter `free_length` of `coil-spring` must be at least the solid length N d = "
                f"{1e3 * solid:.6g} mm and at most pi N D = {1e3 * steep:.6g} mm (45 deg of "
                f"pitch), but is {1e3 * self.free_length:.6g} mm."
            )

    @override
    def cautions(self) -> list[str]:
        pitch = math.atan(self.free_length / (self.circumference() * self.turns))
        if self.deflection == "large" or pitch <= STEEPEST:
            return super().cautions()
        return [*super().cautions(), f'Pitch angle {math.degrees(pitch):.3g} deg: prefer `deflection = "large"`.']

    def mean_diameter(self) -> Scalar:
        """Return D between wire centres [m]."""
        outer = self.coil_measure == "outer"
        return self.coil_diameter - self.diameter if outer else self.coil_diameter

    def circumference(self) -> Scalar:
        """Return π D [m]."""
        return math.pi * self.mean_diameter()

    def index(self) -> Scalar:
        """Return the spring index D/d [-]."""
        return coil_theory.spring_index(self.diameter, self.mean_diameter())

    def solid_length(self) -> Scalar:
        """Return N d [m], the length of touching turns."""
        return self.turns * self.diameter

    def wire_length(self) -> Scalar:
        """Return the length of the wire [m]: π N D of flat turns, √[(π N D)² + L_A²] of a helix."""
        flat = self.circumference() * self.turns
        if self.deflection == "small":
            return flat
        return flat * helix.compute_secant(self.free_length / flat)

    def reach(self) -> Scalar:
        """Return the elongation per equivalent strain [m]; √3 π N D²/d of flat turns."""
        length = self.wire_length()
        return length * length * (ROOT3 / (math.pi * self.turns * self.diameter))

    def spring_rate(self, phase: str = "austenite") -> float:
        """Return the spring rate [N/m] of open turns near the free length, in one phase.

        Args:
            phase: `austenite`, or `martensite` with fixed variants.

        Raises:
            ParameterError: the phase does not exist.
        """
        require_known("phase", phase, PHASES)
        share = float(PHASES.index(phase))
        return 1.0 / self.spring(floats, Fractions(share, 0.0), ROOM, 0.0).compliance

    @override
    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        if not self.uniform:
            return super().spring(xp, fractions, temperature, force)
        strain, compliance = self._wire(xp, fractions, temperature)
        if self.deflection == "large":
            coil = _draw_out_rod(xp, self._rod(strain, compliance), self.solid_length(), force)
        else:
            coil = self._flat(strain, compliance)
        return self._close_turns(xp, coil, coil.compliance / (1.0 + self.contact), force)

    def _close_turns(self, xp: Namespace, coil: Coil, closed: Scalar, force: Scalar) -> Spring:
        """Return a coil whose turns touch at small forces and then have a compliance [m/N]."""
        solid = self.solid_length() - self.free_length - closed * coil.touch
        shut = force < coil.touch
        return Spring(xp.where(shut, solid, coil.open.free), xp.where(shut, closed, coil.open.compliance))

    def fibre_columns(self, xp: Namespace) -> tuple[Column, Column]:
        """Return γ/√3 per elongation [1/m] and volume [m³] of the rings of the wire."""
        return self.cut_rings(0.0, 2.0 / (self.diameter * self.reach()))

    def _contact_rate(self, xp: Namespace) -> Scalar:
        """Return the stiffness of touching turns of fibres [N/m]."""
        _, second, _ = self.compute_moments(xp)
        return self.contact * second / self.law.compliance(xp, Fractions(0.0, 0.0))

    @override
    def add_contact(self, xp: Namespace, open: Spring, force: Scalar) -> Spring:
        closed = open.compliance / (1.0 + open.compliance * self._contact_rate(xp))
        touch = (self.solid_length() - self.free_length - open.free) / open.compliance
        return self._close_turns(xp, Coil(open, touch, open.compliance), closed, force)

    @override
    def elastic_energy(self, xp: Namespace, state: Any) -> Scalar | None:
        energy = super().elastic_energy(xp, state)
        if self.uniform or energy is None:
            return energy
        e = self.locate_surface(xp, state).elongation
        pressed = xp.minimum(e - (self.solid_length() - self.free_length), 0.0)
        return energy + 0.5 * self._contact_rate(xp) * pressed * pressed

    def elastic_energy_at(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Scalar:
        """Return the elastic energy [J] under a force [N], of wire and touching turns."""
        strain, compliance = self._wire(xp, fractions, temperature)
        if self.deflection == "large":
            rod = self._rod(strain, compliance)
            coil = _draw_out_rod(xp, rod, self.solid_length(), force)
            length = helix.at_force(xp, rod, xp.maximum(force, coil.touch)).length
            wire = helix.find_elastic_energy(xp, rod, length)
        else:
            coil = self._flat(strain, compliance)
            drawing = xp.maximum(force, coil.touch)
            wire = 0.5 * coil.compliance * drawing * drawing
        pressed = xp.minimum(force - coil.touch, 0.0)
        closed = coil.compliance / (1.0 + self.contact)
        return wire + closed * pressed * (coil.touch + 0.5 * pressed)

    def _flat(self, strain: Scalar, compliance: Scalar) -> Coil:
        """Return flat turns at a transformation strain [-] and a compliance [1/Pa]."""
        free, per_force = strain * self.reach(), compliance * self.reach() * self._leverage()
        touch = (self.solid_length() - self.free_length - free) / per_force
        return Coil(Spring(free, per_force), touch, per_force)

    def _rod(self, strain: Scalar, compliance: Scalar) -> helix.Helix:
        """Return the wire with a transformation strain [-] and a compliance 1/(3 G) [1/Pa]."""
        square = self.diameter * self.diameter
        return helix.Helix(
            length=self.wire_length(),
            angle=2.0 * math.pi * self.turns / self.wire_length(),
            sine=self.free_length / self.wire_length(),
            bending=(1.0 + self.poisson) * (math.pi / 96.0) * square * square / compliance,
            poisson=self.poisson,
            twist=(2.0 * ROOT3) * strain / self.diameter,
        )

    def _wire(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> tuple[Scalar, Scalar]:
        """Return transformation strain [-], and compliance [1/Pa] with the stiffness factor."""
        stiffening = STIFFNESS_FACTORS[self.stiffness_factor](self.index())
        return self.law.free_strain(xp, fractions, temperature), self.law.compliance(xp, fractions) / stiffening

    def _leverage(self) -> Scalar:
        """Return √3 τ per force, without curvature [Pa/N]."""
        return ROOT3 * coil_theory.shear_stress(1.0, self.diameter, self.mean_diameter())

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Return the equivalent stress √3 τ [Pa] at the surface of the wire, with the chosen factor."""
        factor = STRESS_FACTORS[self.stress_factor](self.index())
        return force * (self._leverage() * factor)

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Return the equivalent strain γ/√3 [-] at the surface of the wire."""
        return elongation / self.reach()
