"""Barriers, rates and the exact exchange of the laws of activated layers.

Barriers against brute force on the free energy, the exchange against exact arithmetic, the
scaled error function against SciPy.
"""

from decimal import Decimal, getcontext

import numpy as np
import pytest
from kernels import Kernel, on_c
from mas_paths import TABLE_1, table_1
from scipy import special
from scipy.linalg import expm

from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace
from martensite.physics.kinetics.barriers import BOLTZMANN
from martensite.physics.kinetics.exchange import Flows, exchange_fractions
from martensite.physics.kinetics.layers import VariantFractions
from martensite.physics.thermal.films import ConstantCooling

ARRAYS = ArrayNamespace(np)
FORMS = ("barrier", "well", "edge")


def per_energy(T, volume=TABLE_1["layer_volume"]):
    """λ = V/(k_B T) [m³/J]."""
    return volume / (BOLTZMANN * T)


def corners(law, T):
    """ε_A and ε_M."""
    rise = max(law.linear_transition_stress(T), 0.0)
    return rise / law.E_A, law.eps_T + (rise - law.Delta_sigma) / law.E_M


# ---------------------------------------------------------------- barriers


def landscape(law, T, stress):
    """g(ε) = ψ - σ ε, as a function of an array of strains."""
    return lambda strain: law.free_energy(ARRAYS, strain, T) - stress * strain


def extreme(g, low, high, sign):
    """Least (sign 1) or largest (sign -1) value of g between two strains, on refined grids."""
    for _ in range(3):
        grid = np.linspace(low, high, 2001)
        k = int(np.argmin(sign * g(grid)))
        low, high = grid[max(k - 1, 0)], grid[min(k + 1, 2000)]
    return float(sign * (sign * g(grid)).min())


def brute_force(law, T, stress):
    """Barriers [J/m³] from A to M+ and back, and the difference of the wells A - M+."""
    eps_A, eps_M = corners(law, T)
    g = landscape(law, T, stress)
    austenite, martensite = extreme(g, -eps_A, eps_A, 1), extreme(g, eps_M, eps_M + 0.05, 1)
    saddle = extreme(g, eps_A, eps_M, -1)
    return saddle - austenite, saddle - martensite, austenite - martensite


@pytest.mark.parametrize("T", [300.0, 325.0, 340.0, 370.0])
def test_barriers_are_the_heights_of_the_saddle(T):
    """Inside the thresholds and beyond each of them; out of A while it has a well for M+."""
    law = table_1()
    compared, least = 0, -max(law.linear_transition_stress(T), 0.0)
    for stress in np.linspace(-120e6, 300e6, 43).tolist():
        up, down, _ = brute_force(law, T, stress)
        rates = law.jump_rates(floats, stress, T)
        for rate, barrier in ((rates.to_plus, up), (rates.from_plus, down)):
            expected = -per_energy(T) * barrier
            if expected > -600.0 and (stress > least or barrier is down):
                assert np.log(rate * law.layer_time) == pytest.approx(expected, abs=1e-6)
                compared += 1
    assert compared >= 15


def test_variants_mirror_each_other():
    for form in FORMS:
        law = table_1(rates=form)
        here, there = law.jump_rates(floats, 33e6, 331.0), law.jump_rates(floats, -33e6, 331.0)
        assert here[:2] == there[2:]
        assert here[2:] == there[:2]


def detailed_balance(law, T, stress):
    """log of (p/q) over exp(λ (G_A - G_+)), the wells taken at their bottoms."""
    g = landscape(law, T, stress)
    wells = g(np.array([stress / law.E_A, law.eps_T + stress / law.E_M]))
    rates = law.jump_rates(floats, stress, T)
    balance = per_energy(T, law.layer_volume) * float(wells[0] - wells[1])
    return np.log(rates.to_plus / rates.from_plus) - balance


def test_detailed_balance_of_the_barrier_form():
    """In small layers, whose rates do not underflow anywhere between the thresholds."""
    law = table_1(layer_volume=1e-24)
    for T in (334.0, 345.0, 360.0):
        high = law.linear_transition_stress(T)
        for stress in np.linspace(high - law.Delta_sigma, high, 24)[1:-1].tolist():
            assert abs(detailed_balance(law, T, stress)) < 1e-10


def test_the_other_forms_break_detailed_balance():
    for form in ("well", "edge"):
        law = table_1(rates=form, layer_volume=1e-24)
        gaps = [abs(detailed_balance(law, 345.0, 101e6 - share * 52e6)) for share in (0.1, 0.5)]
        assert max(gaps) > 0.1


@pytest.mark.parametrize("size", [1e3, 1e4])
def test_overstressed_layers_jump_linearly_in_the_form_well(size):
    """√π |u|/τ and √(π E_M/E_A) z/τ, u and z in thermal widths."""
    law, T = table_1(rates="well"), 345.0
    widths = [np.sqrt(2 * E / per_energy(T)) for E in (law.E_A, law.E_M)]
    high = float(law.linear_transition_stress(T) + size * widths[0])
    up = law.jump_rates(floats, high, T).to_plus * law.layer_time
    assert up == pytest.approx(np.sqrt(np.pi) * size, rel=1e-6)
    low = float(law.linear_transition_stress(T) - law.Delta_sigma - size * widths[1])
    down = law.jump_rates(floats, low, T).from_plus * law.layer_time
    assert down == pytest.approx(np.sqrt(np.pi * law.E_M / law.E_A) * size, rel=1e-6)


def test_the_other_forms_saturate():
    for form in ("barrier", "edge"):
        assert table_1(rates=form).jump_rates(floats, 3e9, 345.0).to_plus == 100.0  # 1/τ


# ---------------------------------------------------------------- scaled error function

POINTS = np.concatenate([[0.0], 10 ** np.linspace(-6, 8, 400), np.linspace(4.9, 5.1, 50)])


def of_runtime(runtime):
    if runtime == "floats":
        return np.array([floats.erfcx(x) for x in POINTS.tolist()])
    if runtime == "numpy":
        return ARRAYS.erfcx(POINTS)
    kernel = Kernel({"x": (0.0, 1.0)}, lambda _, xp, x: xp.erfcx(x))
    return on_c(ConstantCooling(h=1.0), kernel, POINTS[None])[0]


@pytest.mark.parametrize("runtime", ["floats", "numpy", "c"])
def test_scaled_error_function(runtime, request):
    if runtime == "c":
        request.getfixturevalue("c_compiler")
    assert np.abs(of_runtime(runtime) / special.erfcx(POINTS) - 1).max() < 1e-14


# ---------------------------------------------------------------- exchange

getcontext().prec = 60


def matrix(flows, number):
    """Generator of (A, x₊, x₋)."""
    up, down, over, back = (number(f) for f in flows)
    zero = number(0.0)
    return np.array([[-up - over, down, back], [up, -down, zero], [over, zero, -back]])


def exactly(flows, before):
    """(A, x₊, x₋) after the step, with sixty digits: scaling, Taylor series, squaring."""
    generator = matrix(flows, Decimal)
    halvings = max(0, int(np.log2(float(abs(generator).sum()) + 1e-300)) + 3)
    small = generator / Decimal(2) ** halvings
    total = term = matrix((0.0,) * 4, Decimal) + np.diag(np.array([Decimal(1)] * 3))
    for k in range(1, 34):
        term = term.dot(small) / k
        total = total + term
    for _ in range(halvings):
        total = total.dot(total)
    return total.dot(np.array([Decimal(x) for x in before])).astype(float)


def random_flows(rng, kind):
    if kind == "any":
        return 10 ** rng.uniform(-12, 6, 4)
    if kind == "some zero":
        return 10 ** rng.uniform(-12, 6, 4) * (rng.random(4) > 0.4)
    if kind == "equal":
        return np.full(4, 10 ** rng.uniform(-12, 6))
    if kind == "moderate":
        return 10 ** rng.uniform(-3, 1, 4)
    twins = 10 ** rng.uniform(-6, 2, 2)  # nearly equal for both variants
    return np.concatenate([twins, twins * (1 + rng.choice([0.0, 1e-9, 1e-5, 1e-4], 2))])


KINDS = {"any": 1e-12, "some zero": 1e-12, "equal": 1e-12, "moderate": 1e-13, "twins": 1e-9}
"""Kind of rates, and the tolerance of fractions besides rounding of large rates."""


def exchange_error(kind, trials=120):
    """Largest error of a fraction over what is allowed."""
    rng, worst = np.random.default_rng(7), 0.0
    for trial in range(trials):
        flows = random_flows(rng, kind).tolist()
        before = np.eye(3)[trial % 3] if trial % 5 == 0 else rng.dirichlet([1.0, 1.0, 1.0])
        plus, minus = (round(x * 2**30) / 2**30 for x in before[1:])
        found = exchange_fractions(floats, VariantFractions(plus, minus), Flows(*flows))
        exact = exactly(flows, (1 - plus - minus, plus, minus))[1:]
        allowed = KINDS[kind] + 2.3e-16 * max(flows)
        worst = max(worst, float(np.abs(np.array(found) - exact).max()) / allowed)
    return worst


@pytest.mark.parametrize("kind", KINDS)
def test_exchange_is_exact(kind):
    assert exchange_error(kind) < 1.0


def test_exchange_equals_the_matrix_exponential_of_scipy():
    rng = np.random.default_rng(8)
    for _ in range(300):
        flows = random_flows(rng, "moderate").tolist()
        before = rng.dirichlet([1.0, 1.0, 1.0])
        found = exchange_fractions(floats, VariantFractions(*before[1:].tolist()), Flows(*flows))
        assert found == pytest.approx((expm(matrix(flows, float)) @ before)[1:], abs=1e-12)


def test_no_flow_changes_nothing():
    before = VariantFractions(0.3, 0.5)
    assert exchange_fractions(floats, before, Flows(0.0, 0.0, 0.0, 0.0)) == before
