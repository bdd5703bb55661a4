"""Wear: drift of law parameters with cycles, which settles exponentially and may go on with their logarithm.

    N' = ½ |ξ'| + a max(T - T_h, 0)                     completed cycles
    w = 1 - exp(-N/N₀),  d = log10(1 + N/N₀)            settled fraction, and decades after settling
    ε_r' = max((ε_∞ + ε_d d) S - ε_r, 0) N'/N₀ + ε_d S d'    residual strain, with S = σ/σ_r

At a constant stress ε_r = (ε_∞ w + ε_d d) S. Transformation temperatures are shifted by w ΔT + d ΔT_d, transformation
strains multiplied by 1 - w s - d s_d. Residual strain never decreases. It follows the fraction at the end of a step,
inside its solve, at the initial stress; the law parameters are those at the start of the step, an error of first order.

Source: an internal variable that saturates exponentially with accumulated transformation, after Tanaka et al. (1995)
and Zaki and Moumni (2007), both from memory. The logarithm is empirical. The user must supply all values: no wire data
are known.
"""

import math
from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions

LN_10 = math.log(10.0)
TEMPERATURES = ("A_s", "A_f", "M_s", "M_f", "T_L")
STRAINS = ("eps_L", "eps_T", "H_sat", "H_min", "eps_L_compression", "H_sat_compression")
"""Law parameters that are shifted, and that are reduced."""
LEAST_LEFT = 0.05
"""Least remaining share of a transformation strain."""


class WearState(NamedTuple):
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
    residual_strain_per_decade: Number = param(
        "1", "further residual strain for each factor of 10 in cycles", low=0.0, high=0.02, default=0.0
    )
    stroke_loss_per_decade: Number = param(
        "1", "further loss of transformation strain for each factor of 10 in cycles", low=0.0, high=0.2, default=0.0
    )
    temperature_shift_per_decade: Number = param(
        "delta_degC", "further shift for each factor of 10 in cycles", low=-20.0, high=20.0, default=0.0
    )
    overheat_temperature: Number = param("K", "temperature above which heat wears", low=200.0, high=1e3, default=1e3)
    overheat_rate: Number = param("1/K/s", "cycles done in a second, per kelvin above it", low=0.0, default=0.0)

    @override
    def cautions(self) -> list[str]:
        texts = ["Wear follows numbers of no known source: it predicts nothing beyond the cycles they were fitted to."]
        lost = self._lose(floats, self.cycles)
        if lost > 1.0 - LEAST_LEFT:
            texts.append(
                f"After {self.cycles:g} cycles, wear would take {lost:.0%} of the transformation strain; "
                f"the model keeps {LEAST_LEFT:.0%} of it. Reduce `stroke_loss`, `stroke_loss_per_decade` or `cycles`."
            )
        return texts

    def check_law(self, law: AbstractLaw) -> None:
        """Raise `ParameterError` if a law has no wearing parameters, or residual strain grows too fast."""
        values = {leaf.path: leaf.value for leaf in law.leaves()}
        strain = max((values[name] for name in STRAINS if name in values), default=0.0)
        if not strain or not any(name in values for name in TEMPERATURES):
            listed = ", ".join((*STRAINS, *TEMPERATURES))
            raise ParameterError(f"Law `{law.registered_name}` cannot wear: it has none of {listed}.")
        if (self.temperature_shift or self.temperature_shift_per_decade) and law.has_drive and not law.rate_dependent:
            raise ParameterError(f"Law `{law.registered_name}` is too steep for a `temperature_shift`; try law `mas`.")
        growth = (self.residual_strain + self.residual_strain_per_decade / LN_10) / self.settling_cycles
        if growth > 0.1 * strain:
            raise ParameterError(
                f"Residual strain of `Wear` grows by {growth:.3g} in "
                f"a cycle, more than a tenth of the transformation strain {strain:.3g}; give more `settling_cycles`."
            )

    def begin(self, xp: Namespace, fractions: Fractions, stress: Scalar) -> WearState:
        """Return the wear of the cycles before the start, at the initial stress [Pa]."""
        new = WearState(0.0, 0.0, fractions.martensite, stress)
        return WearState(self.cycles, self._grow(xp, new, self.cycles), *new[2:])

    def advance(
        self, xp: Namespace, worn: WearState, fractions: Fractions, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> WearState:
        """Return the wear after a step of dt [s] that ends at stress [Pa] and temperature [K]."""
        hot = xp.maximum(temperature - self.overheat_temperature, 0.0) * dt
        more = self._turn(xp, worn, fractions) + self.overheat_rate * hot
        return WearState(worn.cycles + more, self._grow(xp, worn, more), fractions.martensite, stress)

    def apply(self, xp: Namespace, law: AbstractLaw, worn: WearState) -> AbstractLaw:
        """Return the worn law."""
        done, decades = self._settle(xp, worn.cycles), self._decades(xp, worn.cycles)
        shift = done * self.temperature_shift + decades * self.temperature_shift_per_decade
        left = xp.maximum(1.0 - self._lose(xp, worn.cycles), LEAST_LEFT)
        numbers = {leaf.path: leaf.value for leaf in law.leaves()}
        changed = {name: numbers[name] + shift for name in TEMPERATURES if name in numbers}
        changed |= {name: numbers[name] * left for name in STRAINS if name in numbers}
        twin, free = law.rebuilt(changed), type(law).free_strain

        def free_strain(xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
            more = self._grow(xp, worn, self._turn(xp, worn, fractions))
            return free(twin, xp, fractions, temperature) + more

        twin.__dict__["free_strain"] = free_strain
        return twin

    def _lose(self, xp: Namespace, cycles: Scalar) -> Scalar:
        """Return the lost share of the transformation strain, above 1 if nothing would be left."""
        return self._settle(xp, cycles) * self.stroke_loss + self._decades(xp, cycles) * self.stroke_loss_per_decade

    def _settle(self, xp: Namespace, cycles: Scalar) -> Scalar:
        """Return the completed fraction of the change."""
        return 1.0 - xp.exp(-cycles / self.settling_cycles)

    def _decades(self, xp: Namespace, cycles: Scalar) -> Scalar:
        """Return the decades of cycles, counted from the settling cycles."""
        return xp.log(1.0 + cycles / self.settling_cycles) * (1.0 / LN_10)

    def _turn(self, xp: Namespace, worn: WearState, fractions: Fractions) -> Scalar:
        return 0.5 * xp.abs(fractions.martensite - worn.martensite)

    def _grow(self, xp: Namespace, worn: WearState, more: Scalar) -> Scalar:
        """Return the residual strain `more` cycles later."""
        load = xp.maximum(worn.stress, 0.0) / self.reference_stress
        decade, slope = self._decades(xp, worn.cycles), self.residual_strain_per_decade * load
        settled = xp.maximum(self.residual_strain * load + slope * decade - worn.residual, 0.0) * self._settle(xp, more)
        return worn.residual + settled + slope * (self._decades(xp, worn.cycles + more) - decade)
