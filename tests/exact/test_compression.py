"""Laws that know compression, against closed forms: plateaus, strains, reorientation, two-way strain, cautions."""

from __future__ import annotations

import math
from typing import Any

import pytest
from builders import LAW_A, ZERO

from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.brinson import Brinson
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.physics.laws.strip_laws import Elahinia, LiangRogers, Tanaka
from martensite.simulate.point import PathLeg, material_point
from martensite.testing.laws import Point, find_end, follow_path

OTHER: dict[str, Any] = {"eps_L_compression": 0.025, "C_M_compression": 12e6, "C_A_compression": 15e6}
HOT, COLD = 90.0 + ZERO, 20.0 + ZERO
SIGMA = {"sigma_s": 80e6, "sigma_f": 150e6}


def find_strain_at(law: Any, points: list[Point], fraction: float = 0.0) -> float:
    """Strain less its elastic part [-]."""
    memory = law.init(floats, Fractions(fraction, fraction), *points[0])
    for s, t in points[1:]:
        memory, _ = law.kinetics(floats, memory, s, t, 1.0)
    return law.free_strain(floats, law.fractions(memory), memory.temperature)


@pytest.mark.parametrize("cls", [LiangRogers, Elahinia])
@pytest.mark.parametrize("rule", ["resume", "restart"])
def test_the_plateau_of_compression_has_numbers_of_its_own(cls: Any, rule: str) -> None:
    law = cls(**(LAW_A | OTHER | {"Theta": 0.0}), compression="asymmetric", history=rule)
    start, finish = (12e6 * (HOT - LAW_A[name]) for name in ("M_s", "M_f"))
    assert find_end(law, [(0.0, HOT), (-start, HOT)], 0.0) == (0.0, 0.0)
    half = find_end(law, [(0.0, HOT), (-0.5 * (start + finish), HOT)], 0.0)
    assert [*half] == pytest.approx([0.5, -0.5], abs=1e-12)
    assert find_strain_at(law, [(0.0, HOT), (-finish - 1e6, HOT)]) == pytest.approx(-0.025, abs=1e-12)
    assert find_strain_at(law, [(0.0, HOT), (8e6 * (HOT - LAW_A["M_f"]) + 1e6, HOT)]) == pytest.approx(0.04, abs=1e-12)
    back = 15e6 * (HOT - 0.5 * (LAW_A["A_s"] + LAW_A["A_f"]))
    down = find_end(law, [(0.0, HOT), (-finish - 1e6, HOT), (-back, HOT)], 0.0)
    assert [*down] == pytest.approx([0.5, -0.5], abs=1e-12)
    assert [*find_end(law, [(0.0, HOT), (-finish - 1e6, HOT), (0.0, HOT)], 0.0)] == [0.0, 0.0]


def test_one_fraction_keeps_its_orientation_until_load_drives_it_back() -> None:
    """Martensite of tension goes back at T + |σ|/C_A, and comes again as martensite of compression."""
    law = LiangRogers(**LAW_A, compression="symmetric")
    kelvin = 60.0 + ZERO  # between M_s and A_s
    starts, ends = (10e6 * (LAW_A[name] - kelvin) for name in ("A_s", "A_f"))
    path = [(300e6, kelvin), (0.0, kelvin), (-starts, kelvin)]
    assert [*find_end(law, path, 1.0)] == [1.0, 1.0]
    share = 0.4
    stress = starts + share * (ends - starts)
    forms = math.cos(0.5 * math.pi * min((LAW_A["M_s"] - kelvin + stress / 8e6) / 10.0, 1.0)) ** 2
    left = math.cos(0.5 * math.pi * share) ** 2
    found = find_end(law, [*path, (-stress, kelvin)], 1.0)
    new = (1.0 - left) * (1.0 - forms)
    assert found.martensite == pytest.approx(left + new, abs=1e-9)
    assert found.oriented == pytest.approx(left - new, abs=1e-9)
    assert [*find_end(law, [*path, (-ends - 100e6, kelvin)], 1.0)] == pytest.approx([1.0, -1.0], abs=1e-9)


def test_cold_martensite_of_brinson_reorients_over_its_detwinning_stresses() -> None:
    law = Brinson(**LAW_A, **SIGMA, sigma_s_compression=120e6, sigma_f_compression=200e6, compression="asymmetric")
    path = [(200e6, COLD), (0.0, COLD)]
    for stress, wanted in ((120e6, 1.0), (160e6, 0.0), (200e6, -1.0)):
        found = find_end(law, [*path, (-stress, COLD)], 1.0)
        assert [*found] == pytest.approx([1.0, wanted], abs=1e-12)
    again = find_end(law, [*path, (-210e6, COLD), (115e6, COLD)], 1.0)
    assert [*again] == pytest.approx([1.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_wire_that_cools_without_load_has_its_two_way_strain(sign: float) -> None:
    free = [(0.0, HOT), (0.0, COLD)]
    for law in (
        LiangRogers(**LAW_A, compression="symmetric", H_min=sign * 0.01),
        Brinson(**LAW_A, **SIGMA, compression="symmetric", H_min=sign * 0.01),
    ):
        found = find_end(law, free, 0.0)
        assert [*found] == pytest.approx([1.0, sign * 0.25], abs=1e-12)
    law = LiangRogers(**LAW_A, compression="symmetric", H_min=sign * 0.01, H_k=1e-8)
    for stress in (60e6, -60e6):
        decay = math.exp(-0.6)
        wanted = math.copysign(0.04, stress) * (1.0 - decay) + sign * 0.01 * decay
        strain = find_strain_at(law, [(stress, HOT), (stress, COLD)])
        assert strain + law.Theta * (COLD - law.T_ref) / law.E_A == pytest.approx(wanted, abs=1e-12)


def test_a_strain_driven_cycle_passes_through_zero_stress() -> None:
    """Strain runs from tension to compression and back; the second loop is the first, and all steps are solved."""
    law = Elahinia(**(LAW_A | OTHER | {"Theta": 0.0}), compression="asymmetric")
    cycle = [PathLeg(strain=e, steps=30) for e in (0.056, -0.05)]
    run = material_point(law, [*cycle * 3, PathLeg(strain=0.0, steps=30)], start=(0.0, HOT), tension_only=False)
    assert run.status == 0
    first, second = (run.stress[run.ends[k] : run.ends[k + 2]] for k in (1, 3))
    assert list(first) == pytest.approx(list(second), abs=1e3)
    assert min(run.oriented) == pytest.approx(-1.0, abs=1e-9) and max(run.oriented) == pytest.approx(1.0, abs=1e-9)


def test_tension_laws_say_that_compression_is_not_theirs() -> None:
    legs = [PathLeg(stress=-80e6, steps=10)]
    quiet = material_point(LiangRogers(**LAW_A), [PathLeg(stress=-3e6, steps=10)], start=(0.0, HOT))
    assert not any("knows tension only" in one for one in quiet.warnings)
    for law, silent in ((LiangRogers(**LAW_A), False), (Tanaka(**LAW_A, compression="symmetric"), True)):
        assert law.tension_only is not silent
        run = material_point(law, legs, start=(0.0, HOT))
        assert any("knows tension only" in one for one in run.warnings) is not silent


def test_rules_that_compression_does_not_know_are_refused() -> None:
    with pytest.raises(ParameterError, match="no return points"):
        LiangRogers(**LAW_A, compression="symmetric", history="return-point")
    with pytest.raises(ParameterError, match="in compression"):
        Brinson(**LAW_A, **SIGMA, compression="asymmetric", sigma_s_compression=160e6)
    with pytest.raises(ParameterError, match="`H_min` must not exceed"):
        LiangRogers(**LAW_A, compression="symmetric", H_min=0.05)
    surface: dict[str, Any] = {n: v for n, v in LAW_A.items() if n not in ("eps_L", "Theta")}
    surface |= {"sigma_cal": 100e6, "H_k": 0.0}
    with pytest.raises(ParameterError, match="sigma_cal"):
        Lagoudas(**surface, H_min=0.04, H_sat=0.04, compression="symmetric")


def test_memories_go_where_an_observer_puts_them() -> None:
    law = LiangRogers(**LAW_A, compression="symmetric")
    memory = follow_path(law, [(0.0, HOT), (-330e6, HOT)], 0.0)[-1]
    assert law.relocate(floats, memory, law.fractions(memory), memory.stress, memory.temperature) == memory
    moved = law.relocate(floats, memory, Fractions(0.6, -0.6), -320e6, HOT)
    assert law.fractions(moved) == (0.6, -0.6)


def test_martensite_of_lagoudas_goes_back_and_forms_anew_until_it_has_no_strain() -> None:
    """Above A_s loops close. Below it what has no mean strain any more stays, for it knows no reorientation."""
    surface: dict[str, Any] = {n: v for n, v in LAW_A.items() if n not in ("eps_L", "Theta")}
    surface["sigma_cal"] = 150e6
    law = Lagoudas(**surface, H_min=0.0, H_sat=0.04, H_k=2e-8, compression="symmetric")
    legs = [PathLeg(strain=e, steps=40) for e in (0.05, -0.05, 0.05, -0.05)]
    for celsius, turns in ((62.0, (0.0, 0.0)), (85.0, (1.0, -1.0))):
        run = material_point(law, legs, start=(0.0, celsius + ZERO), tension_only=False)
        assert run.warnings == [] and run.steps < 10_000
        assert [run.oriented[run.ends[k]] for k in (3, 4)] == pytest.approx(turns, abs=0.1)
