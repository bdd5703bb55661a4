"""Sections of fibres are second order in the step, as elements of one state are."""

from __future__ import annotations

import numpy as np
from builders import example, problem_a, raised_cosine
from section_cases import bar

from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.simulate.api import simulate


def test_errors_fall_with_the_square_of_the_step(c_compiler) -> None:
    """A heated ribbon against a spring: all that is sampled, over the range of each; fibres cross their kinks."""
    law, ohms = example(Lagoudas), PerLengthResistance(r_A=8.3, r_M=9.5)
    ribbon = bar("bent ribbon", diameter=0.3e-3, arm=5e-3, law=law, initial_fraction=1.0, fibres="5", resistance=ohms)
    system = problem_a(element=ribbon.with_values({"latent_heat": 24e3}), source=PowerSource())
    wave = raised_cosine(12.0, 20.0)

    def run(step: float) -> np.ndarray:
        found = simulate(system, wave, 20.0, step=step, samples=21, runtime="c")
        return np.array([found[n] for n in ("temperature", "martensite_fraction", "oriented_fraction", "position")])

    exact = run(0.00625)
    spans = np.ptp(exact, axis=1)
    assert spans[1] > 0.5
    coarse, fine = (np.abs(run(step) - exact).mean(axis=1) / spans for step in (0.2, 0.05))
    assert (coarse < 4e-5).all()
    assert (fine < coarse / 10.0).all()
