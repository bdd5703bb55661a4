"""Exact derivatives: against closed forms, and against differences of whole runs."""

import math
from functools import cache

import numpy as np
import pytest
from benchmarks.problem_a import GRADIENT_P, OBJECTIVE_P, THETA, target_factors
from builders import SINE_A, ZERO, chamber, hanging_wire, law_a, problem_a, through

from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.batch import compute_sensitivity

RUN = {"step": 10e-3, "samples": 601}


def differenced(system, path, share):
    """d(stroke)/d(parameter) by central differences of fourth order, of runs in C."""
    x = system.value_of(path)
    width = share * (10.0 if path.endswith("A_f") else x)

    def stroke(k):
        other = system.with_values({path: x + k * width})
        return simulate(other, SINE_A, 60.0, **RUN, runtime="c").stroke

    return (8 * (stroke(1) - stroke(-1)) - (stroke(2) - stroke(-2))) / (12 * width)


@cache
def sensitive(rule="resume"):
    """Slopes of a run by the parameters of both tests below, computed once."""
    return compute_sensitivity(problem_a(rule), SINE_A, 60.0, [*PARAMETERS, "C_M"], **RUN)


PARAMETERS = {"A_f": 1e-4, "C_A": 1e-4, "h0": 1e-4, "diameter": 1e-5}


@pytest.mark.parametrize("rule", ["resume", pytest.param("restart", marks=pytest.mark.slow)])
@pytest.mark.usefixtures("c_compiler")
def test_slopes_of_the_stroke_are_those_of_differences(rule):
    system = problem_a(rule)
    found = sensitive(rule)
    assert np.ptp(found.column) == pytest.approx(simulate(system, SINE_A, 60.0, **RUN).stroke, rel=1e-12)
    for name, share in PARAMETERS.items():
        path = system.resolve(name)
        assert found.of_range()[path] == pytest.approx(differenced(system, path, share), rel=1e-6, abs=0), name


def test_printed_gradient_of_the_benchmark_objective():
    """J = mean[(x - x_d)²]/range(x_d)², by the chain rule from the slopes of the position."""
    system = problem_a()
    names = {"h0": "h0", "latent": "latent_heat", "c": "heat_capacity"}
    paths = [system.resolve(names.get(name, name)) for name in THETA]
    at = {path: system.value_of(path) for path in paths}
    zeros = {p: ZERO if p[-3:] in ("A_s", "A_f", "M_s", "M_f") else 0.0 for p in paths}
    factors = zip(paths, target_factors(), strict=True)
    wanted = {p: zeros[p] + (at[p] - zeros[p]) * q for p, q in factors}
    target = np.array(simulate(system.with_values(wanted), SINE_A, 60.0, **RUN)["position"])
    found = compute_sensitivity(system, SINE_A, 60.0, paths, **RUN)
    error, span = found.column - target, np.ptp(target)
    assert np.mean(error**2) / span**2 == pytest.approx(OBJECTIVE_P, rel=2e-5)
    gradient = [2 * np.mean(error * found.slopes[p]) * (at[p] - zeros[p]) / span**2 for p in paths]
    assert gradient == pytest.approx(GRADIENT_P, abs=1e-6)


# ---------------------------------------------------------------- closed forms


def test_steady_temperature():
    """T = T_a + P/(h S): slopes -ΔT/h, -ΔT/d, 0 for the latent heat, 1 for T_a."""
    system = hanging_wire(mass=0.5, h=80.0)
    rise = 1.5 / (80.0 * math.pi * 0.381e-3 * 0.25)
    run = compute_sensitivity(
        system,
        Constant(level=1.5),
        200.0,
        ["h", "diameter", "latent_heat", "environment.temperature"],
        step=0.05,
        samples=11,
        output="temperature",
    )
    assert run.column[-1] == pytest.approx(20 + ZERO + rise, abs=1e-8)
    last = {path.split(".")[-1]: slope[-1] for path, slope in run.slopes.items()}
    assert last["h"] == pytest.approx(-rise / 80.0, rel=1e-8)
    assert last["diameter"] == pytest.approx(-rise / 0.381e-3, rel=1e-8)
    assert last["latent_heat"] == pytest.approx(0.0, abs=1e-12)
    assert last["temperature"] == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize("rule", ["resume", pytest.param("restart", marks=pytest.mark.slow)])
def test_contraction_of_a_hanging_wire(rule):
    """x = l (ε_L + σ/E_A ...) (1 - ξ), ξ = ½ {1 + cos[π (T - A_s - σ/C_A)/(A_f - A_s)]}."""
    law = law_a(rule, "austenite", Theta=0.0)
    system = chamber(law, mass=1.0)
    stress = 9.80665 / (math.pi * 0.381e-3**2 / 4)
    celsius = 75.0 + stress / 10e6
    names = ["eps_L", "A_s", "A_f", "C_A", "length", "E_A"]
    run = compute_sensitivity(system, through([20 + ZERO, celsius + ZERO]), 1.0, names, step=0.02, samples=51)
    angle = math.pi * 0.7
    gone = 0.5 * (1 - math.cos(angle))
    assert run.column[-1] == pytest.approx(0.25 * 0.04 * gone, rel=1e-9)
    per_angle = 0.25 * 0.04 * 0.5 * math.sin(angle)
    expected = {
        "eps_L": 0.25 * gone,
        "A_s": per_angle * math.pi / 10.0 * (0.7 - 1.0),
        "A_f": per_angle * math.pi / 10.0 * -0.7,
        "C_A": per_angle * math.pi / 10.0 * stress / 10e6**2,
        "length": 0.04 * gone,
        "E_A": 0.0,
    }
    for name, slope in expected.items():
        found = run.slopes[system.resolve(name)][-1]
        assert found == pytest.approx(slope, rel=1e-8, abs=1e-22), name
