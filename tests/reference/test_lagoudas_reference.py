"""The law equals the independent return mapping: isobars, superelastic loops, partial cycles."""

from dataclasses import asdict
from itertools import pairwise

import lagoudas_reference as reference
import numpy as np
import pytest
from builders import stepper

from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.lagoudas import Lagoudas

TOLERANCE = 1e-8
CUTS = 48
ROUND = {"n_1": 0.17, "n_2": 0.27, "n_3": 0.25, "n_4": 0.35}
CURVED = {"curvature_f": 6e-17, "curvature_r": -4e-17, "widening_f": 1.5e-8, "widening_r": 5e-9}
P = reference.Parameters(
    E_A=66.2e9,
    E_M=25.6e9,
    A_s=315.0,
    A_f=330.0,
    M_s=310.0,
    M_f=285.0,
    C_A=9.02e6,
    C_M=8.34e6,
    sigma_cal=150e6,
    H_min=0.004,
    H_sat=0.048,
    H_k=1.29e-8,
    sigma_crit=20e6,
    n_1=0.95,
    n_2=0.9,
    n_3=0.85,
    n_4=1.0,
)
SETS = {
    "nearly linear": P,
    "round": reference.Parameters(**(asdict(P) | ROUND)),
    "waisted": reference.Parameters(**(asdict(P) | ROUND | {"waist_f": 0.5, "waist_r": 0.95})),
    "curved": reference.Parameters(**(asdict(P) | CURVED)),
    "one strain": reference.Parameters(**(asdict(P) | {"H_min": 0.048})),
}
MPA = 1e6
ISOBARS = ("isobar", "isobars at three loads", "partial isobar")
PATHS = {
    "isobar": [(150 * MPA, 260.0), (150 * MPA, 390.0), (150 * MPA, 260.0)],
    "isobars at three loads": [
        (50 * MPA, 260.0),
        (50 * MPA, 380.0),
        (50 * MPA, 260.0),
        (200 * MPA, 260.0),
        (200 * MPA, 400.0),
        (200 * MPA, 260.0),
        (100 * MPA, 260.0),
        (100 * MPA, 400.0),
    ],
    "superelastic": [(0.0, 345.0), (700 * MPA, 345.0), (0.0, 345.0)],
    "partial superelastic": [
        (0.0, 345.0),
        (480 * MPA, 345.0),
        (185 * MPA, 345.0),
        (430 * MPA, 345.0),
        (170 * MPA, 345.0),
        (450 * MPA, 345.0),
        (0.0, 345.0),
    ],
    "partial isobar": [
        (150 * MPA, 400.0),
        (150 * MPA, 317.0),
        (150 * MPA, 339.0),
        (150 * MPA, 312.0),
        (150 * MPA, 343.0),
        (150 * MPA, 400.0),
    ],
    "stretched cold, heated loaded": [(0.0, 330.0), (150 * MPA, 290.0), (60 * MPA, 290.0), (60 * MPA, 380.0)],
}


def law_of(p, **changes):
    numbers = asdict(p) | changes
    waisted = numbers["waist_f"] > 0.0 or numbers["waist_r"] > 0.0
    surfaces = "curved" if any(numbers[name] for name in CURVED) else "work"
    return Lagoudas(hardening="waisted" if waisted else "smooth", surfaces=surfaces, **numbers)


def worst(p, law, path, xi, oriented, cuts=CUTS):
    """Largest difference of ξ and of ε_t at the corners of a path."""
    state = reference.start(p, xi, oriented, *path[0])
    memory = law.init(floats, Fractions(xi, oriented), path[0][0], path[0][1])
    found, step = [0.0, 0.0], stepper(law)
    for begin, end in pairwise(path):
        state = reference.advance(p, state, end[0], end[1], cuts)
        for k in range(1, cuts + 1):
            sigma, T = (a + k / cuts * (b - a) for a, b in zip(begin, end, strict=True))
            memory = step(memory, sigma, T, 0.0)
        fractions = law.fractions(memory)
        found[0] = max(found[0], abs(state.xi - fractions.martensite))
        found[1] = max(found[1], abs(state.strain - law.H_sat * fractions.oriented))
    return found


@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS)
@pytest.mark.parametrize("p", SETS.values(), ids=SETS)
def test_law_equals_reference(p, path):
    """From a mixture; paths of every set pass through austenite and oriented martensite."""
    xi, oriented = 0.6, 0.1
    fraction, strain = worst(p, law_of(p), path, xi, oriented)
    loose = 100.0 if p.waist_f else 1.0  # ∫H dξ through a waist, in as many cuts
    assert fraction <= loose * TOLERANCE
    assert strain <= loose * 1e-9


@pytest.mark.parametrize("path", ISOBARS)
def test_a_strong_waist_at_constant_stress_equals_reference(path):
    p = reference.Parameters(**(asdict(P) | ROUND | {"waist_f": 0.98, "waist_r": 0.9}))
    fraction, strain = worst(p, law_of(p), PATHS[path], 0.0, 0.0)
    assert fraction <= TOLERANCE
    assert strain <= 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_random_isobars_and_isotherms(seed):
    """From any state, legs at constant stress or temperature of any length."""
    rng = np.random.default_rng(seed)
    numbers = asdict(P) | dict(zip(ROUND, rng.uniform(0.1, 1.0, 4), strict=True))
    numbers |= {"C_A": rng.uniform(7e6, 9e6)}
    if seed % 2:
        numbers |= {"waist_f": rng.uniform(0.0, 0.5), "waist_r": rng.uniform(0.0, 0.98)}
    p = reference.Parameters(**numbers)
    path = [(float(rng.uniform(0, 400e6)), float(rng.uniform(270, 400)))]
    for k in range(6):
        sigma, T = float(rng.uniform(0, 400e6)), float(rng.uniform(270, 400))
        path.append((path[-1][0], T) if k % 2 else (sigma, path[-1][1]))
    xi = float(rng.random())
    fraction, strain = worst(p, law_of(p), path, xi, xi * float(rng.random()))
    assert fraction <= 10 * TOLERANCE
    assert strain <= 1e-8


def test_constants_agree():
    """Closed forms of calibration against the linear system."""
    for p in SETS.values():
        found, wanted = law_of(p).constants(floats), reference.constants(p)
        assert list(found) == pytest.approx([wanted[name] for name in ("s", "u", "a1", "a2", "a3", "Y", "D")], rel=1e-8)
