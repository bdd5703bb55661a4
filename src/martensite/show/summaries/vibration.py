"""A free vibration: frequency, damping, and what follows for a given stiffness or mass."""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.base.confidence import LEVEL
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.characterise.estimate import MeasuredValue, propagate_errors
from martensite.characterise.free_vibration import LogDecrement, damping_ratio, moving_mass
from martensite.characterise.spectrum import SpectralPeak


@dataclass(frozen=True)
class Oscillator:
    """What vibrates: a stiffness or a moving mass, in SI; at most one of them is given."""

    stiffness: float | None
    mass: float | None

    def derive_numbers(self, fit: LogDecrement) -> dict[str, tuple[MeasuredValue, str]]:
        """Mass or stiffness, and damping, by name with their units; empty if nothing is given."""

        def rate(period: float, delta: float) -> float:
            return math.hypot(2.0 * math.pi, delta) / period

        def damping(period: float, delta: float) -> float:
            omega = rate(period, delta)
            half = self.mass * omega if self.mass is not None else (self.stiffness or 0.0) / omega
            return 2.0 * damping_ratio(delta) * half

        c = propagate_errors(damping, fit.period, fit.decrement)
        if self.stiffness is not None:
            k = self.stiffness
            found = propagate_errors(lambda f: moving_mass(k, f), fit.frequency)
            return {"moving_mass": (found, "kg"), "damping": (c, "N*s/m")}
        if self.mass is not None:
            m = self.mass
            found = propagate_errors(lambda f: m * (2.0 * math.pi * f) ** 2, fit.frequency)
            return {"stiffness": (found, "N/m"), "damping": (c, "N*s/m")}
        return {}


def summarise_vibration(peak: SpectralPeak, fit: LogDecrement, oscillator: Oscillator, title: str) -> Summary:
    """Everything about a free vibration."""
    derived = oscillator.derive_numbers(fit)
    found = [
        ("natural frequency", fit.frequency, "Hz"),
        ("damped frequency", fit.damped_frequency, "Hz"),
        ("logarithmic decrement", fit.decrement, ""),
        ("damping ratio", fit.zeta, ""),
        *((name.replace("_", " "), *one) for name, one in derived.items()),
    ]
    rows = [(name, one.write(), unit) for name, one, unit in found]
    blocks = [
        Sentence(
            f"Spectrum: {peak.frequency:.5g} Hz, resolution {peak.resolution:.3g} Hz, "
            f"{peak.prominence:.3g} times the median of the spectrum"
        ),
        DataTable(("quantity", "value", "unit"), rows, right=(1,)),
        Sentence(f"± half the {100 * LEVEL:g} % interval; rest at {fit.offset.value:.4g}."),
    ]
    data = {
        "spectrum": peak.to_dict(),
        "decay": fit.to_dict(),
        "derived": {name: number.to_dict() for name, (number, _) in derived.items()},
    }
    return Summary(title, blocks, data)
