"""What clamped ends cost a lumped wire, and the scenario that names them.

Sources of truth: the fin with a uniform source in closed form, the bar with a uniform source
without a film (mean overtemperature P l/(12 k A)), and the axial wire.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from axial_cases import AMBIENT, HEALING, IDEAL, H, K, L, axial, clamped, fin, thin_wire
from builders import law_a, wire_a
from hypothesis import given
from hypothesis import strategies as st
from one_wire import cool, hang, write_wire

from martensite.actuators.elements.axial_wire import AxialWire
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.physics.thermal.base import Cylinder
from martensite.physics.thermal.ends import PARABOLA_LIMIT, AdiabaticEnds, ClampedEnds
from martensite.scenario.scenario import read_scenario
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate

D = 0.1e-3
SECTION, EDGE = 0.25 * math.pi * D * D, math.pi * D
ENDS = ClampedEnds(thermal_conductivity=K, contact=IDEAL)


def conductance(film: float, length: float = L, **numbers: float) -> float:
    """Heat flow per mean overtemperature [W/K]."""
    usual = {"thermal_conductivity": K, "contact": IDEAL}
    return ClampedEnds(**(usual | numbers)).conductance(floats, film, Cylinder(D, length))


@pytest.mark.parametrize("length", [1e-3, 4e-3, 20e-3, 0.2, 2.0])
@pytest.mark.parametrize("contact", [1e-6, 1e-4, IDEAL])
def test_conductance_is_that_of_the_fin(length: float, contact: float) -> None:
    mean, _ = fin(1.0, length, contact)
    assert conductance(H, length, contact=contact) * mean == pytest.approx(1.0, rel=1e-9)


@given(st.floats(1e-3, 1e4), st.floats(1e-3, 1.0), st.floats(1e-6, 1e3), st.floats(0.1, 500.0))
def test_ends_add_to_the_surface_but_no_more_than_they_can(
    film: float, length: float, contact: float, k: float
) -> None:
    """More than the surface alone; less than surface and, unheated by a film, bar in a row."""
    found = conductance(film, length, contact=contact, thermal_conductivity=k)
    surface = film * EDGE * length
    bar = 1.0 / (length / (12.0 * k * SECTION) + 0.5 / contact)
    assert found > surface * (1.0 - 1e-9)
    assert found > bar * (1.0 - 1e-4)
    through = 2.0 * math.sqrt(film * EDGE * k * SECTION)  # two endless fins
    assert found < surface + min(2.0 * contact, 2.0 * through + bar) + 1e-12


def test_a_long_wire_loses_one_healing_length_of_surface_at_each_end() -> None:
    """1/(1 - φ) = 1 + φ + φ² + …, φ = 2 (healing length)/l."""
    for length in (0.1, 0.5, 5.0):
        share = 2.0 * HEALING / length
        excess = conductance(H, length) / (H * EDGE * length) - 1.0
        assert excess == pytest.approx(share + share * share, rel=2.0 * share**2)


def test_contacts_that_conduct_nothing_are_adiabatic() -> None:
    for film, length in ((H, L), (50.0, 2e-3), (1e3, 0.3)):
        expected = AdiabaticEnds().conductance(floats, film, Cylinder(D, length))
        assert expected == pytest.approx(film * EDGE * length, rel=1e-15)
        assert conductance(film, length, contact=1e-12) == pytest.approx(expected, rel=1e-5)
    near = [conductance(H, contact=c) - H * EDGE * L for c in (1e-6, 1e-8)]
    assert near == pytest.approx([2e-6, 2e-8], rel=0.02)


@pytest.mark.parametrize("contact", [1e-6, 1e-4, IDEAL])
@pytest.mark.parametrize("film", [0.0, 1e-9])
def test_without_a_film_it_is_the_heated_bar(film: float, contact: float) -> None:
    """12 k A/l and both contacts in a row, and no more than a film that is hardly felt."""
    bar = 1.0 / (L / (12.0 * K * SECTION) + 0.5 / contact)
    least = 0.25 * K * D * (PARABOLA_LIMIT / (0.5 * L)) ** 2  # 0.5 mW/(m² K)
    assert conductance(film, contact=contact) == pytest.approx(bar, abs=1.3 * least * EDGE * L)


def test_slopes_are_finite_where_nothing_blows() -> None:
    for film in (0.0, 1e-12, 1e-3, H):
        value, slope = value_and_slope(floats, lambda xp, h: ENDS.conductance(xp, h, Cylinder(D, L)), film)
        assert math.isfinite(value)
        assert math.isfinite(slope)
        assert slope >= 0.0


def test_slope_is_that_of_finite_differences() -> None:
    _, slope = value_and_slope(floats, lambda xp, h: ENDS.conductance(xp, h, Cylinder(D, L)), H)
    assert slope == pytest.approx((conductance(H + 0.01) - conductance(H - 0.01)) / 0.02, rel=1e-6)


# ---------------------------------------------------------------- in a wire


@pytest.mark.parametrize(
    ("length", "contact"),
    [
        (4e-3, IDEAL),
        (20e-3, 1e-4),
        pytest.param(20e-3, IDEAL, marks=pytest.mark.slow),
        pytest.param(60e-3, 1e-5, marks=pytest.mark.slow),
    ],
)
def test_lumped_ends_give_the_mean_of_the_axial_wire(length: float, contact: float) -> None:
    """To the error of its cells: 2e-4 at 80, with the lumped wire right on the fin."""
    watts = length
    ends = ClampedEnds(thermal_conductivity=K, contact=contact)
    elements: list[Any] = [thin_wire(length, ends=ends), axial(thin_wire(length), contact=contact, cells="80")]
    lumped, cut = (simulate(clamped(e), Constant(level=watts), 60.0, step=0.5, samples=2) for e in elements)
    rise = lumped["temperature"][-1] - AMBIENT
    assert rise == pytest.approx(fin(watts, length, contact)[0], rel=1e-9)
    assert cut["temperature"][-1] - AMBIENT == pytest.approx(rise, rel=2e-4)
    assert lumped["heat_loss"][-1] == pytest.approx(watts, rel=1e-9)


def test_adiabatic_ends_are_the_default() -> None:
    assert isinstance(wire_a(law_a()).ends, AdiabaticEnds)


def test_another_conductivity_is_noticed() -> None:
    mean, _ = fin(1.0, L)
    wrong = conductance(H, thermal_conductivity=1.05 * K)
    assert wrong * mean != pytest.approx(1.0, rel=1e-3)


# ---------------------------------------------------------------- scenario files

SCENARIO = write_wire(
    element='material = "flexinol-90"\nends = ENDS',
    law='"liang-rogers"',
    diameter="0.1 mm",
    length="30 mm",
    cooling=cool(100),
    mechanism=hang("100 g"),
    drive='kind = "power"\nwaveform = { kind = "constant", level = "0.02 W" }',
    run='duration = "5 s"',
)
AXIAL = SCENARIO.replace("ends = ENDS\n", "").replace(
    'kind = "wire"\nmaterial = "flexinol-90"\n',
    'kind = "axial-wire"\nmaterial = "flexinol-90"\n[element.wire]\nkind = "wire"\n',
)


def test_ends_draw_the_conductivity_of_the_material() -> None:
    found = read_scenario(SCENARIO.replace("ENDS", '{ kind = "clamped" }'))
    wire: Any = found.single_system.element
    assert wire.ends == ClampedEnds(thermal_conductivity=18.0)
    assert found.origins["element.ends.thermal_conductivity"] == "datasheet, flexinol-90"
    assert read_scenario(SCENARIO.replace("ENDS", '"clamped"')).single_system.element == wire


def test_ends_can_be_written_out() -> None:
    text = '{ kind = "clamped", thermal_conductivity = "10 W/m/K", contact = "2 mW/K" }'
    wire: Any = read_scenario(SCENARIO.replace("ENDS", text)).single_system.element
    assert wire.ends == ClampedEnds(thermal_conductivity=10.0, contact=2e-3)
    plain: Any = read_scenario(SCENARIO.replace("ends = ENDS\n", "")).single_system.element
    assert plain.ends == AdiabaticEnds()


def test_axial_wire_draws_the_conductivity_of_the_material() -> None:
    found = read_scenario(AXIAL)
    cut: Any = found.single_system.element
    assert isinstance(cut, AxialWire)
    assert cut.thermal_conductivity == 18.0
    assert found.origins["element.thermal_conductivity"] == "datasheet, flexinol-90"
    assert "flexinol-90" in found.origins["element.wire.density"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SCENARIO.replace("ENDS", '"clampd"'), "Did you mean `clamped`"),
        (SCENARIO.replace("ENDS", '{ kind = "clamped", contct = "1 W/K" }'), "mean `contact`"),
        (SCENARIO.replace("ENDS", '{ kind = "clamped", contact = "0 W/K" }'), "must be above 0"),
        (AXIAL.replace('kind = "axial-wire"', 'kind = "axial-wire"\ncells = "12"'), "10"),
        (AXIAL.replace('kind = "wire"', 'kind = "wire"\nends = "clamped"'), "`adiabatic` ends"),
        (AXIAL.replace('kind = "wire"', 'kind = "coil-spring"'), "coil-spring"),
    ],
    ids=["name", "parameter", "range", "cells", "clamps twice", "spring"],
)
def test_what_cannot_be_meant_is_refused(text: str, words: str) -> None:
    with pytest.raises(Exception, match=words) as caught:
        read_scenario(text)
    assert type(caught.value).__module__ == "martensite.base.errors"
