"""Film coefficients in their limits: no buoyancy, no difference, colder wires, other fluids.

Sources of truth: the terms that are left in each limit, the law of Stefan and Boltzmann, and what
any heat loss must do: grow with temperature, with finite slopes.
"""

import math

import numpy as np
import pytest

import martensite as ms
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.physics.fluids.base import FLUIDS
from martensite.physics.thermal.base import Cylinder

ZERO = 273.15
FREE = {"lefevre-ede": ms.thermal.LeFevreEde, "churchill-chu": ms.thermal.ChurchillChu, "morgan": ms.thermal.Morgan}
RISING = (*FREE, "churchill-bernstein")


def film(model, celsius, ambient, diameter):
    """h [W/(m² K)] at temperatures in °C."""
    return model.film(floats, celsius + ZERO, ambient + ZERO, Cylinder(diameter, 0.273))


def model(name, **changes):
    return ms.thermal.ChurchillBernstein(speed=1.5, **changes) if name not in FREE else FREE[name](**changes)


@pytest.mark.parametrize("fluid", FLUIDS.names())
def test_without_buoyancy_a_vertical_wire_only_conducts(fluid):
    around = FLUIDS[fluid]()
    k, _, pr, _ = around.properties(floats, 300.0)
    conducted = 4 * (272 + 315 * pr) / (35 * (64 + 63 * pr)) * k / 0.2e-3
    weightless = ms.thermal.LeFevreEde(fluid=around, gravity=0.0)
    for t in (290.0, 300.0, 310.0):
        found = weightless.film(floats, t, 600.0 - t, Cylinder(0.2e-3, 0.2))
        assert found == pytest.approx(conducted, rel=1e-12)


def test_at_equal_temperatures_a_vertical_wire_in_air_nearly_only_conducts():
    """Nearly: |T - T_a| is held at 0.01 K."""
    shape = Cylinder(0.2e-3, 0.2)
    films = [ms.thermal.LeFevreEde(gravity=g).film(floats, 300.0, 300.0, shape) for g in (0.0, 9.81)]
    assert 1.0 < films[1] / films[0] < 1.02


def test_a_horizontal_wire_without_buoyancy_keeps_the_constant_of_churchill_and_chu():
    found = ms.thermal.ChurchillChu(gravity=0.0).film(floats, 320.0, 300.0, Cylinder(1e-3, 0.2))
    assert found == pytest.approx(0.36 * ms.thermal.Air().properties(floats, 310.0).conductivity / 1e-3, rel=1e-12)


def test_radiation_is_the_law_of_stefan_and_boltzmann():
    wire = ms.thermal.Radiation(emissivity=0.3)
    for t, ambient in ((400.0, 300.0), (250.0, 320.0)):
        flow = film(wire, t - ZERO, ambient - ZERO, 1e-3) * (t - ambient)
        assert flow == pytest.approx(0.3 * 5.670374419e-8 * (t**4 - ambient**4), rel=1e-13)
    same = film(wire, 25.0, 25.0, 1e-3)
    assert same == pytest.approx(4 * 0.3 * 5.670374419e-8 * 298.15**3, rel=1e-13)


@pytest.mark.parametrize("name", FREE)
@pytest.mark.parametrize("fluid", FLUIDS.names())
def test_a_colder_wire_takes_up_what_a_warmer_one_gives(name, fluid):
    wire, shape = FREE[name](fluid=FLUIDS[fluid]()), Cylinder(0.2e-3, 0.2)
    assert wire.film(floats, 330.0, 310.0, shape) == wire.film(floats, 310.0, 330.0, shape)


@pytest.mark.parametrize("name", RISING)
@pytest.mark.parametrize("fluid", FLUIDS.names())
def test_heat_loss_grows_with_temperature_in_every_fluid(name, fluid):
    wire, shape = model(name, fluid=FLUIDS[fluid]()), Cylinder(0.2e-3, 0.2)
    temperatures = np.linspace(260.0, 450.0, 191)
    films = [wire.film(floats, t, 295.0, shape) for t in temperatures.tolist()]
    assert (np.diff(films * (temperatures - 295.0)) > 0.0).all()


@pytest.mark.parametrize("name", RISING)
def test_slopes_stay_finite_at_the_ambient_temperature(name):
    wire, shape = model(name), Cylinder(0.2e-3, 0.2)

    def flow(xp, t):
        return wire.film(xp, t, 295.0, shape) * (t - 295.0)

    for t in (295.0 - 1e-9, 295.0, 295.0 + 1e-9, 295.009, 295.011):
        value, slope = value_and_slope(floats, flow, t)
        h = wire.film(floats, t, 295.0, shape)
        assert math.isfinite(value)
        assert 0.99 * h < slope < 1.3 * h


def test_more_pressure_or_speed_cools_more():
    dense = ms.thermal.ChurchillChu(fluid=ms.thermal.Air(pressure=3e5))
    assert film(dense, 60.0, 20.0, 1e-3) > 1.2 * film(ms.thermal.ChurchillChu(), 60.0, 20.0, 1e-3)
    slow, fast = (film(ms.thermal.ChurchillBernstein(speed=u), 60.0, 20.0, 1e-3) for u in (1.0, 4.0))
    assert slow < fast < 2.0 * slow
