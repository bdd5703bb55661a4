"""Wear: saturating drift of law parameters with cycles.

    N' = ½ |ξ'| + a max(T - T_h, 0)         completed cycles;   w = 1 - exp(-N/N₀)
    ε_r' = max(ε_∞ σ/σ_r - ε_r, 0) N'/N₀    residual strain: at a constant stress ε_∞ (σ/σ_r) w

Transformation temperatures are shifted by w ΔT, transformation strains multiplied by 1 - w s. Residual strain never
decreases. It follows the fraction at the end of a step, inside its solve, at the initial stress; the law parameters are
those at the start of the step, an error of first order.

Source: an internal variable that saturates exponentially with accumulated transformation, after Tanaka et al. (1995)
and Zaki and Moumni (2007), both from memory. The user must supply all values: no wire data are known.
"""

from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions

TEMPERATURES = ("A_s", "A_f", "M_s", "M_f", "T_L")
STRAINS = ("eps_L", "eps_T", "H_sat", "H_min", "eps_L_compression", "H_sat_compression")
"""Law parameters that are shifted, and that are reduced."""


class Worn(NamedTuple):
    """Wear of an element: cycles, residual strain [-]; fraction and stress [Pa] at that time."""

    cycles: Scalar
    residual: Scalar
    martensite: Scalar
    stress: Scalar


class Wear(Parametrised):
    """Drift of residual strain, transformation strain and temperatures of an element with its cycles."""

    cites = ("tanaka1995", "zaki2007")

    settling_cycles: Number = param("1", "cycles that do 63 % of the change", low=1.0, high=1e9, typical=100.0)
    cycles: Number = param("1", "cycles done before the start, under its stress", low=0.0, high=1e12, default=0.0)
    residual_strain: Number = param("1", "residual strain in the end", low=0.0, high=0.1, default=0.0)
    reference_stress: Number = param("Pa", "stress of that residual strain", above=0.0, high=3e9, default=100e6)
    stroke_loss: Number = param("1", "share of transformation strain lost in the end", low=0.0, high=0.9, default=0.0)
    temperature_shift: Number = param(
        "delta_degC", "shift of transformation temperatures in the end", low=-100.0, high=100.0, default=0.0
    )
    overheat_temperature: Number = param("K", "temperature above which heat wears", low=200.0, high=1e3, default=1e3)
    overheat_rate: Number = param("1/K/s", "cycles done in a second, per kelvin above it", low=0.0, default=0.0)

    @override
    def cautions(self) -> list[str]:
        return ["Wear follows numbers of no known source: it predicts nothing beyond the cycles they were fitted to."]

    def check_law(self, law: AbstractLaw) -> None:
        """Raise `ParameterError` if a law has no wearing parameters, or residual strain grows too fast."""
        values = {leaf.path: leaf.value for leaf in law.leaves()}
        strain = max((values[name] for name in STRAINS if name in values), default=0.0)
        if not strain or not any(name in values for name in TEMPERATURES):
            listed = ", ".join((*STRAINS, *TEMPERATURES))
            raise ParameterError(f"Law `{law.registered_name}` cannot wear: it has none of {listed}.")
        if self.temperature_shift and law.steep and not law.rate_dependent:
            raise ParameterError(f"Law `{law.registered_name}` is too steep for a `temperature_shift`; try law `mas`.")
        if self.residual_strain > 0.1 * strain * self.settling_cycles:
            raise ParameterError(
                f"Parameter `residual_strain` of `Wear` grows by {self.residual_strain / self.settling_cycles:.3g} in "
                f"a cycle, more than a tenth of the transformation strain {strain:.3g}; give more `settling_cycles`."
            )

    def begin(self, xp: Namespace, fractions: Fractions, stress: Scalar) -> Worn:
        """Return the wear of the cycles before the start, at the initial stress [Pa]."""
        new = Worn(0.0, 0.0, fractions.martensite, stress)
        return Worn(self.cycles, self._grow(xp, new, self.cycles), *new[2:])

    def advance(
        self, xp: Namespace, worn: Worn, fractions: Fractions, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Worn:
        """Return the wear after a step of dt [s] that ends at stress [Pa] and temperature [K]."""
        hot = xp.maximum(temperature - self.overheat_temperature, 0.0) * dt
        more = self._turn(xp, worn, fractions) + self.overheat_rate * hot
        return Worn(worn.cycles + more, self._grow(xp, worn, more), fractions.martensite, stress)

    def apply(self, xp: Namespace, law: AbstractLaw, worn: Worn) -> AbstractLaw:
        """Return the worn law."""
        done = self._settle(xp, worn.cycles)
        shift, left = done * self.temperature_shift, 1.0 - done * self.stroke_loss
        numbers = {leaf.path: leaf.value for leaf in law.leaves()}
        changed = {name: numbers[name] + shift for name in TEMPERATURES if name in numbers}
        changed |= {name: numbers[name] * left for name in STRAINS if name in numbers}
        twin, free = law.rebuilt(changed), type(law).free_strain

        def free_strain(xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
            more = self._grow(xp, worn, self._turn(xp, worn, fractions))
            return free(twin, xp, fractions, temperature) + more

        twin.__dict__["free_strain"] = free_strain
        return twin

    def _settle(self, xp: Namespace, cycles: Scalar) -> Scalar:
        """Return the completed fraction of the change."""
        return 1.0 - xp.exp(-cycles / self.settling_cycles)

    def _turn(self, xp: Namespace, worn: Worn, fractions: Fractions) -> Scalar:
        return 0.5 * xp.abs(fractions.martensite - worn.martensite)

    def _grow(self, xp: Namespace, worn: Worn, more: Scalar) -> Scalar:
        """Return the residual strain `more` cycles later."""
        aim = self.residual_strain * (xp.maximum(worn.stress, 0.0) / self.reference_stress)
        return worn.residual + xp.maximum(aim - worn.residual, 0.0) * self._settle(xp, more)
