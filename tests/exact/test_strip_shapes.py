"""Strips of `liang-rogers` with curved lines and with branches of their own shapes.

Source of truth: the law `lagoudas`, which shares no code of the strips, and closed forms.
"""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from builders import LAW_A

from martensite.kernels import floats
from martensite.physics.kinetics.hardening import apply_waist, compute_hardening
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.testing.laws import find_end, follow_path

SHAPES: dict[str, Any] = {"n_1": 0.3, "n_2": 0.6, "n_3": 0.8, "n_4": 0.2, "waist_f": 0.7, "waist_r": 0.9}
CURVES: dict[str, Any] = {"curvature_f": 1e-16, "curvature_r": -5e-17, "widening_f": 6e-8, "widening_r": 2e-8}
STRIPS: dict[str, Any] = {n: v for n, v in LAW_A.items() if n not in ("C_A", "C_M", "E_M", "eps_L", "Theta")}


@pytest.mark.parametrize("hardening", ["smooth", "waisted"])
def test_shapes_are_those_of_the_law_of_surfaces(hardening: str) -> None:
    """With one modulus, one H and equal slopes work shifts the surfaces of `lagoudas` along straight lines."""
    same = STRIPS | SHAPES | CURVES | {"C_A": 8e6, "C_M": 8e6, "E_M": LAW_A["E_A"], "sigma_cal": 100e6}
    options: Any = {"hardening": hardening, "surfaces": "curved"}
    laws = (LiangRogers(eps_L=0.04, **same, **options), Lagoudas(H_min=0.04, H_sat=0.04, H_k=0.0, **same, **options))
    for stress in (0.0, 60e6, 180e6):
        ends = [(stress, t) for t in (420.0, 280.0, 420.0)]
        path = [ends[0], *((stress, t) for a, b in pairwise(ends) for t in np.linspace(a[1], b[1], 60).tolist())]
        one, other = ([law.fractions(m).martensite for m in follow_path(law, path, 0.0)] for law in laws)
        assert one == pytest.approx(other, abs=1e-11)
        assert sum(0.01 < x < 0.99 for x in one) > 3


@pytest.mark.parametrize("hardening", ["smooth", "waisted"])
def test_what_a_shape_leaves_is_the_inverse_of_its_share(hardening: str) -> None:
    law = LiangRogers(**(LAW_A | SHAPES), hardening=hardening)
    for d in np.linspace(0.0, 0.95, 20).tolist():
        rests = law.remaining_fraction_of(floats, d, True), law.remaining_fraction_of(floats, d, False)
        exponents = (law.n_2, law.n_1), (law.n_3, law.n_4)  # 1 - h(ξ) is h(1 - ξ) with the exponents exchanged
        shares = [compute_hardening(floats, rest, *pair) for rest, pair in zip(rests, exponents, strict=True)]
        if hardening == "waisted":
            shares = [apply_waist(h, b) for h, b in zip(shares, (law.waist_f, law.waist_r), strict=True)]
        assert shares == pytest.approx([d, d], abs=1e-9)
    assert law.remaining_fraction_of(floats, 0.4, True) != pytest.approx(
        law.remaining_fraction_of(floats, 0.4, False), abs=1e-3
    )


@pytest.mark.parametrize("rule", ["resume", "restart", "return-point"])
def test_a_leg_turns_where_its_line_does(rule: str) -> None:
    """M_s rises with stress up to 156 MPa and falls beyond it: the fraction is that of its highest point."""
    law = LiangRogers(**LAW_A, history=rule, surfaces="curved", curvature_f=-4e-16, widening_f=1e-9)
    top = 1.0 / LAW_A["C_M"] / (2.0 * 4e-16)
    kelvin = LAW_A["M_s"] + top / LAW_A["C_M"] - 4e-16 * top**2 - 3.0
    whole, cut = (find_end(law, [(1e6, kelvin), (2.0 * top, kelvin)], 0.0, n).martensite for n in (1, 64))
    assert whole == pytest.approx(cut, abs=1e-11)
    half = find_end(law, [(1e6, kelvin), (top, kelvin)], 0.0).martensite
    assert whole == pytest.approx(half, abs=1e-4)  # the range widens a little, which moves its highest point
    wanted = math.cos(0.5 * math.pi * (1.0 - (3.0 + 0.5e-9 * top) / (10.0 + 1e-9 * top))) ** 2
    assert half == pytest.approx(wanted, abs=1e-12)


def test_numbers_of_shapes_that_no_option_calls_for_are_said() -> None:
    assert len(LiangRogers(**(LAW_A | SHAPES | CURVES)).cautions()) == len(LiangRogers(**LAW_A).cautions()) + 2
    falls = LiangRogers(**LAW_A, surfaces="curved", curvature_f=-4e-16)
    assert any("Above 156.2 MPa `M_f` falls" in one for one in falls.cautions())
    meets = LiangRogers(**(LAW_A | CURVES), surfaces="curved").doubt()
    assert meets is not None
    forward, reverse = LiangRogers(**(LAW_A | CURVES), surfaces="curved").strips()
    ends = []
    for strip in (forward, reverse):  # the start lines, where the distance is 1
        low, high = 200.0, 600.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            rises = strip.distance(meets.stress, middle) > 1.0
            low, high = (low, middle) if rises == (strip.per_width > 0.0) else (middle, high)
        ends.append(low)
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)
