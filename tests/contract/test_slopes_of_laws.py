"""Slopes of every registered law, by dual numbers, are those of differences."""

import numpy as np
import pytest
from builders import along, examples, label, stepper

from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope

LAWS = examples("law")
LONG = (
    "lagoudas-none-smooth-work",
    "lagoudas-none-waisted-work",
    "lagoudas-none-smooth-curved",
    "lagoudas-symmetric-smooth-work",
    "lagoudas-asymmetric-smooth-work",
    "brinson-return-point-none",
    "brinson-resume-symmetric",
    "brinson-resume-asymmetric",
    "elahinia-resume-symmetric",
    "elahinia-resume-asymmetric",
    "tanaka-resume-symmetric-austenite",
    "tanaka-resume-asymmetric-austenite",
    "liang-rogers-resume-symmetric-austenite-strain-cosine-straight",
    "tanaka-return-point-none-austenite",
    "elahinia-return-point-none",
    "r-phase-return-point",
    "mas-polycrystal-constant-15-barriers",
    "mas-polycrystal-constant-15-internal-stress",
)
"""Laws whose differences take long."""
MOST = pytest.mark.parametrize(
    "law", [pytest.param(law, marks=[pytest.mark.slow] if label(law) in LONG else []) for law in LAWS], ids=label
)


def differenced(function, x, h=1e-4):
    """Slope by central differences of fourth order; None near a kink or a jump."""
    near = [function(floats, x + k * h) for k in (-2, -1, 0, 1, 2)]
    second, third = (np.abs(np.diff(near, order)).max() for order in (2, 3))
    if third > 0.05 * second + 1e-13:  # of a smooth function it is smaller by h
        return None
    return (8 * (near[3] - near[1]) - (near[4] - near[0])) / (12 * h)


def random_points(rng, count):
    return [(float(rng.uniform(0, 500e6)), float(rng.uniform(270, 420))) for _ in range(count)]


def turning_stress(law, memory, kelvin, share):
    """Stress at which the answer of the law has made a share of its change, by bisection."""
    low, high, advance = 0.0, 500e6, stepper(law)

    def answer(sigma):
        return law.fractions(advance(memory, sigma, kelvin, 1.0)).oriented

    wanted = answer(low) + share * (answer(high) - answer(low))
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if answer(middle) < wanted else (low, middle)
    return high


def slopes(law, slope_of):
    """Slopes in T [1/K] and in σ [1/(10 MPa)] found by `slope_of` and by differences.

    Half of the points are where the answer is changing, which random points seldom hit in laws
    that jump.
    """
    rng, pairs = np.random.default_rng(2), []
    for turn in range(80):
        memory = along(law, random_points(rng, 3), rng.random())[-1]
        ((sigma, kelvin),) = random_points(rng, 1)
        if turn % 2:
            sigma = turning_stress(law, memory, kelvin, float(rng.uniform(0.1, 0.9)))

        def in_temperature(xp, t, memory=memory, sigma=sigma):
            return law.kinetics(xp, memory, sigma, t, 1.0)[1].oriented

        def in_stress(xp, s, memory=memory, kelvin=kelvin):
            return law.kinetics(xp, memory, s * 1e7, kelvin, 1.0)[1].oriented

        for function, x in ((in_temperature, kelvin), (in_stress, sigma / 1e7)):
            difference = differenced(function, x)
            if difference is not None:
                pairs.append((slope_of(function, x), difference))
    return np.array(pairs).T


@MOST
def test_slopes_are_those_of_finite_differences(law):
    found, wanted = slopes(law, lambda function, x: value_and_slope(floats, function, x)[1])
    assert np.sum(np.abs(wanted) > 1e-3) > 15
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-8)


def test_a_wrong_slope_is_noticed():
    found, wanted = slopes(LAWS[0], lambda function, x: value_and_slope(floats, function, x)[1] * (1 + 1e-4))
    assert found != pytest.approx(wanted, rel=1e-5, abs=1e-8)
