"""Directions that data do not determine, found and named right.

Sources of truth: Jacobians written out from models with known redundancies; NumPy's singular
values; what the sentences promise, tried on the model itself.
"""

import math
import re
from typing import Any

import numpy as np
import pytest

from martensite.base.errors import DataError, ParameterError
from martensite.search.identifiability import assess_identifiability
from martensite.search.weak_direction import find_weak_directions

AT = np.linspace(280.0, 400.0, 150)
NAMES = ["k_s", "s", "Delta_sigma", "sigma_L", "E", "V", "T_L"]
UNITS = ["N/m", "Pa/K", "Pa", "Pa", "Pa", "m^3", "K"]
VALUES = [50.0, 4e6, 52e6, 1e6, 30e9, 5e-23, 320.0]
RANGES = [40.0, 3e6, 110e6, 49.5e6, 20e9, 1e-22, 100.0]


def offset(p: np.ndarray) -> np.ndarray:
    """y = a (T - (T_L - σ_L/s)): only the slope and one temperature can be seen."""
    a, t_l, sigma_l, s = p
    return a * (AT - (t_l - sigma_l / s))


def machine(p: np.ndarray) -> np.ndarray:
    """All stresses over the stiffness of a spring, and the thermal energy over V."""
    k, s, width, sigma_l, e, v, t_l = p
    x = (AT - 280.0) / 40.0
    start = (s * (AT - t_l) + sigma_l) / k
    return (
        1e-6 * start + 1e-7 * width / k * np.sin(3 * x) + 1e-10 * e / k * np.cos(5 * x) + 1e-22 / (v * k) * np.exp(-x)
    )


def slopes(model, values, ranges) -> np.ndarray:
    """Jacobian per range by complex steps: exact to rounding."""
    columns = []
    for k, value in enumerate(values):
        moved = np.asarray(values, complex)
        moved[k] += 1e-30j * value
        columns.append(model(moved).imag / (1e-30 * value) * ranges[k])
    return np.stack(columns, axis=1)


def judge(model, names, values, ranges, units, noise=0.01):
    return assess_identifiability(
        slopes(model, values, ranges), names, values=values, scales=ranges, units=units, noise=noise
    )


def judged_offset(units=("1", "K", "Pa")):
    def without_slope(p: np.ndarray) -> np.ndarray:
        return offset(np.append(p, 4e6))

    names, values, ranges = ["a", "T_L", "sigma_L"], [0.02, 320.0, 1e6], [0.1, 100.0, 49.5e6]
    return judge(without_slope, names, values, ranges, units)


# ---------------------------------------------------------------- exact redundancy


def test_a_temperature_and_a_stress_are_told_to_make_up_for_each_other():
    found = judged_offset()
    assert not found.determined
    assert found.condition == math.inf
    (weak,) = found.weak
    assert weak.exact
    assert weak.names == ("sigma_L", "T_L")
    assert weak.changes == pytest.approx((20e6, 5.0), rel=1e-9)  # 4 MPa/K
    assert weak.effect < 1e-12
    assert weak.sentence == (
        "Only the combination `sigma_L` - 4 MPa/K × `T_L` is determined: raising `sigma_L` by "
        "20 MPa together with `T_L` by 5 K changes nothing (the error changes by less than a "
        "millionth of its noise)."
    )


def test_the_sentence_follows_the_unit_and_the_sign():
    plain = judged_offset(("1", "K", "1")).sentences[0]
    assert "`sigma_L` - 4e+06 1/K × `T_L`" in plain

    def falling(p: np.ndarray) -> np.ndarray:
        return p[0] * AT + 2.0 * p[0] * p[1]

    (one,) = judge(falling, ["p", "q"], [3.0, 1.0], [2.0, 2.0], ["1", "1"], 1e-9).sentences
    assert one.startswith("All parameters are determined")

    def sum_of_two(p: np.ndarray) -> np.ndarray:
        return AT * (p[0] + 2.0 * p[1])

    (two,) = judge(sum_of_two, ["p", "q"], [3.0, 5.0], [2.0, 2.0], ["1", "1"]).sentences
    assert "`p` + 2 × `q`" in two
    assert "raising `p` by 1 while lowering `q` by 0.5 changes nothing" in two


@pytest.mark.parametrize("seed", range(8))
def test_the_amounts_of_a_random_redundancy_leave_the_error_alone(seed: int):
    """The named changes, applied to a nonlinear model, change nothing to first order."""
    random = np.random.default_rng(seed)
    mix = random.normal(size=(3, 4))
    values, ranges = random.uniform(1, 2, 4).tolist(), random.uniform(0.5, 5, 4).tolist()

    def model(p: np.ndarray) -> np.ndarray:
        q = mix @ p
        return np.tanh(q[0] * AT / 400.0) + q[1] * AT / 400.0 + q[2]

    names = ["a", "b", "c", "d"]
    (weak,) = judge(model, names, values, ranges, ["1"] * 4, 1e-3).weak
    step = np.zeros(4)
    for name, change in zip(weak.names, weak.changes, strict=True):
        step[names.index(name)] = change
    assert abs(mix @ step).max() < 1e-9
    assert set(re.findall(r"`(\w)`", weak.sentence)) == set(weak.names)
    wrong = step * np.where(np.arange(4) == names.index(weak.names[0]), 1.1, 1.0)
    assert abs(mix @ wrong).max() > 1e-3


def test_two_redundancies_at_once_are_told_apart():
    """A gauge of forces and an offset of temperature: not one mixture of both."""
    found = judge(machine, NAMES, VALUES, RANGES, UNITS)
    assert [one.exact for one in found.weak] == [True, True]
    offset_, gauge = found.weak
    assert set(offset_.names) == {"T_L", "sigma_L"}
    assert not offset_.gauge
    assert set(gauge.names) == {"k_s", "s", "Delta_sigma", "sigma_L", "E", "V"}
    assert gauge.gauge
    assert np.abs(gauge.relative) == pytest.approx([0.1] * 6, rel=1e-6)


def test_a_gauge_is_said_as_a_factor_that_holds_on_the_model():
    sentence = judge(machine, NAMES, VALUES, RANGES, UNITS).sentences[1]
    multiplied, divided = sentence.split("multiplying ")[1].split(" and dividing ")
    up, down = (set(re.findall(r"`(\w+)`", part)) for part in (multiplied, divided))
    if "V" in up:
        up, down = down, up
    assert (up, down) == ({"k_s", "s", "Delta_sigma", "sigma_L", "E"}, {"V"})
    assert "by the same factor changes nothing" in sentence
    for factor, far in ((1.3, False), (0.5, False), (1.3, True)):
        moved = [
            v * (factor if n in up else 1.0 / factor if n in down and not far else 1.0)
            for n, v in zip(NAMES, VALUES, strict=True)
        ]
        same = machine(np.asarray(moved)) == pytest.approx(machine(np.asarray(VALUES)), rel=1e-12)
        assert same is not far


@pytest.mark.parametrize(("power", "kind"), [(1.0, "product"), (-1.0, "ratio")])
def test_two_factors_of_one_number(power: float, kind: str):
    def model(p: np.ndarray) -> np.ndarray:
        return p[0] * p[1] ** power * AT

    (one,) = judge(model, ["a", "b"], [2.0, 7.0], [1.0, 1.0], ["1", "1"]).weak
    assert one.gauge
    both = " and ".join(f"`{name}`" for name in one.names)
    assert one.sentence.startswith(f"Only the {kind} of {both} is determined: multiplying")


# ---------------------------------------------------------------- weak, without effect, determined


def test_a_column_of_zeros_is_a_parameter_without_effect():
    columns = np.stack([AT, 0 * AT, AT**0], axis=1)
    found = assess_identifiability(columns, ["a", "b", "c"], values=[1, 1, 1], scales=[1, 1, 1])
    assert found.without_effect == ("b",)
    assert found.sentences == ("`b` is not determined: it has no effect on the error.",)
    everything = assess_identifiability(np.zeros((5, 2)), ["a", "b"], values=[1, 1], scales=[1, 1])
    assert everything.without_effect == ("a", "b")


@pytest.mark.parametrize(("noise", "weak"), [(0.5, False), (2.0, True)])
def test_a_parameter_is_weak_when_it_is_uncertain_by_more_than_its_range(noise: float, weak: bool):
    """One column of norm 1: the standard error is `noise` ranges, by hand."""
    columns = np.stack([np.full(100, 30.0), np.tile([0.1, -0.1], 50)], axis=1)
    found = assess_identifiability(
        columns, ["a", "E_M"], values=[1.0, 30e9], scales=[1.0, 20e9], units=["1", "Pa"], noise=noise
    )
    assert found.uncertainties == pytest.approx((noise / 300.0, noise))
    assert found.determined is not weak
    if weak:
        (one,) = found.weak
        assert not one.exact
        assert one.uncertainty == pytest.approx(noise)
        assert one.sentence == (
            "`E_M` is not determined: its whole range, 20000 MPa, changes the error by only 0.05 of its noise."
        )
    else:
        assert found.sentences == (
            "All parameters are determined. The least certain direction has an error of 50 % of the search range.",
        )


def test_a_weak_pair_that_is_not_redundant_is_not_called_so():
    columns = np.stack([AT, AT + 1e-3 * np.sin(AT)], axis=1)
    (one,) = assess_identifiability(columns, ["p", "q"], values=[1, 3], scales=[1, 1]).weak
    assert not one.exact
    assert "by only" in one.sentence
    assert "nothing" not in one.sentence
    assert assess_identifiability(columns, ["p", "q"], values=[1, 3], scales=[1, 1], noise=1e-4).determined


def test_a_small_mover_is_named_only_if_it_is_needed():
    """3 % of the largest: without it the sentence would be false in one case, not in the other."""
    base = np.stack([AT / 400.0, np.sin(AT), np.cos(AT / 9.0)], axis=1)
    strong = np.stack([base[:, 0], base[:, 1], -(base[:, 0] + base[:, 1]) / 0.03], axis=1)
    needed = assess_identifiability(strong, ["a", "b", "c"], values=[1, 2, 3], scales=[1, 1, 1], noise=0.1)
    assert set(needed.weak[0].names) == {"a", "b", "c"}
    small = 0.1 / np.linalg.norm(base[:, 2])
    second = -base[:, 0] + 1.6 * small * base[:, 2] + 1e-3 * base[:, 1]
    nearly = np.stack([base[:, 0], second, base[:, 2]], axis=1)
    nearly[:, 2] *= 60.0 * small
    named = assess_identifiability(nearly, ["a", "b", "c"], values=[1, 2, 3], scales=[1, 1, 1], noise=0.1)
    assert [set(one.names) for one in named.weak] == [{"a", "b"}]
    assert np.count_nonzero(find_weak_directions(nearly, 0.1)[0]) == 3


@pytest.mark.parametrize("count", [5, 30])
def test_singular_values_and_the_number_of_weak_directions(count: int):
    random = np.random.default_rng(count)
    columns = random.normal(size=(80, count))
    columns[:, 2] = columns[:, 0] - columns[:, 1]
    columns[:, 4] = columns[:, 1] + 3.0 * columns[:, 3]
    given: Any = {"values": [1.0] * count, "scales": [2.0] * count}
    found = assess_identifiability(columns, [f"p{k}" for k in range(count)], noise=1e-6, **given)
    assert found.singular_values == pytest.approx(np.linalg.svd(columns)[1].tolist(), abs=1e-12)
    assert {frozenset(one.names) for one in found.weak} == {
        frozenset({"p0", "p1", "p2"}),
        frozenset({"p1", "p3", "p4"}),
    }
    assert found.sensitivities == pytest.approx((np.linalg.norm(columns, axis=0) / np.sqrt(80) / 1e-6).tolist())


@pytest.mark.parametrize("seed", range(6))
def test_many_parameters_are_covered_by_leaving_columns_out(seed: int, monkeypatch):
    """Directions found one by one span the same space as the singular vectors."""
    monkeypatch.setattr("martensite.search.weak_direction.MANY_SETS", 0)
    random = np.random.default_rng(seed)
    columns = random.normal(size=(40, 9))
    columns[:, [1, 4, 7]] = columns[:, [0, 2, 3]] @ random.normal(size=(3, 3))
    found = find_weak_directions(columns, 1e-9)
    assert len(found) == 3
    null = np.linalg.svd(columns)[2][-3:]
    inside = np.stack(found) @ null.T
    assert np.linalg.norm(inside, axis=1) == pytest.approx(1.0, abs=1e-9)
    assert np.linalg.matrix_rank(np.stack(found), 1e-6) == 3


def test_fewer_residuals_than_parameters_leave_directions_open():
    random = np.random.default_rng(3)
    found = assess_identifiability(
        random.normal(size=(2, 3)), ["a", "b", "c"], values=[1, 2, 0], scales=[1, 1, 1], noise=1e-3
    )
    assert found.singular_values[-1] == 0.0
    assert set(found.weak[0].names) == {"a", "b", "c"}


def test_a_redundancy_that_is_broken_is_noticed():
    """With a second slope the offset is determined, and no sentence may say otherwise."""

    def bent(p: np.ndarray) -> np.ndarray:
        return offset(np.append(p[:3], 4e6)) + 1e-16 * p[2] ** 2 * np.sin(AT / 10.0)

    values, ranges = [0.02, 320.0, 1e6], [0.1, 100.0, 49.5e6]
    found = judge(bent, ["a", "T_L", "sigma_L"], values, ranges, ["1", "K", "Pa"], 1e-6)
    assert found.determined
    assert found.condition < 1e7


# ---------------------------------------------------------------- bad input


def test_bad_input_is_refused():
    good: Any = {"values": [1.0], "scales": [1.0]}
    for bad in (np.zeros(3), np.zeros((3, 2)), np.zeros((0, 1)), [[math.nan]]):
        with pytest.raises(DataError, match="Jacobian must"):
            assess_identifiability(bad, ["a"], **good)
    with pytest.raises(ParameterError, match="noise"):
        assess_identifiability([[1.0]], ["a"], noise=0.0, **good)
    with pytest.raises(ParameterError, match="equal lengths"):
        assess_identifiability([[1.0]], ["a"], values=[1.0, 2.0], scales=[1.0])
    with pytest.raises(ParameterError, match="scale of `a`"):
        assess_identifiability([[1.0]], ["a"], values=[1.0], scales=[0.0])
