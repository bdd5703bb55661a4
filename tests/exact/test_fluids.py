"""Properties of the fluids against their tables, release and formulas.

Sources of truth: check values of IAPWS SR6-08(2011) at 260, 298.15 and 375 K, as a public
implementation (jjgomera, iapws) tests itself by them; the rows of the printed tables; textbook
air over the whole range, by rows.
"""

import numpy as np
import pytest

import martensite as ms
from martensite.kernels import floats
from martensite.physics.fluids import air, oil
from martensite.physics.fluids.base import FLUIDS, AbstractFluid

# T, μ [1e-6 Pa s], k, c_p [kJ/(kg K)], ρ, dv/dT [1e-7 m³/(kg K)]
RELEASE = (
    (260.0, 3058.36075, 0.515628010, 4.30017472, 997.068360, -3.86550941),
    (298.15, 889.996774, 0.606502308, 4.18144618, 997.047013, 2.58054178),
    (375.0, 276.207245, 0.677913788, 4.21774697, 957.009710, 7.94706623),
)


@pytest.mark.parametrize("row", RELEASE, ids=lambda row: f"{row[0]:g}")
def test_water_is_the_release(row):
    temperature, micro, k, heat, density, slope = row
    found = ms.thermal.Water().film_properties(floats, temperature)
    assert found.conductivity == pytest.approx(k, rel=2e-9)
    assert found.viscosity == pytest.approx(1e-6 * micro / density, rel=3e-9)
    assert found.prandtl == pytest.approx(1e-6 * micro * 1e3 * heat / k, rel=5e-9)
    assert found.expansion == pytest.approx(1e-7 * slope * density, rel=5e-9)
    assert found.diffusivity == pytest.approx(k / (density * 1e3 * heat), rel=5e-9)


def deviations(rows="textbook"):
    """`air` against each row of `air-table`: k, ν, Pr, as shares."""
    table = air.ROWS[rows]
    found = [ms.thermal.Air().properties(floats, c + 273.15)[:3] for c, *_ in table]
    return np.array(found) / [(k, 1e-5 * nu, pr) for _, k, nu, pr in table] - 1.0


def test_air_deviates_from_the_table_as_it_says():
    k, nu, pr = deviations().T
    assert (k.min(), k.max()) == pytest.approx((0.0229, 0.0238), abs=2e-4)
    assert (nu.min(), nu.max()) == pytest.approx((-0.0066, -0.0037), abs=2e-4)
    assert (pr[0], pr[-1]) == pytest.approx((-0.0327, -0.0058), abs=2e-4)
    assert np.abs(deviations()).max() < 0.033


def test_the_printed_rows_agree_with_the_textbook_where_they_were_copied():
    textbook = {round(k, 5): (nu, pr) for _, k, nu, pr in air.ROWS["textbook"]}
    for _, k, nu, pr in air.ROWS["kossoski"][:4]:
        assert textbook[k] == pytest.approx((nu, pr), rel=3.1e-3)


@pytest.mark.parametrize("name", air.ROWS)
def test_the_table_of_air_is_linear_between_its_rows(name):
    rows = np.array(air.ROWS[name])
    celsius = np.linspace(rows[0, 0], rows[-1, 0], 83)
    found = np.array([ms.thermal.AirTable(rows=name).properties(floats, c + 273.15) for c in celsius.tolist()])
    for column, unit in ((1, 1.0), (2, 1e-5), (3, 1.0)):
        expected = unit * np.interp(celsius, rows[:, 0], rows[:, column])
        np.testing.assert_allclose(found[:, column - 1], expected, rtol=1e-12)
    np.testing.assert_allclose(found[:, 3], 1.0 / (celsius + 273.15), rtol=1e-12)


def test_oil_is_its_table_at_the_rows_and_logarithmic_between():
    found = np.array([ms.thermal.Oil().properties(floats, row[0]) for row in oil.ROWS])
    printed = np.array(oil.ROWS)[:, 1:] * [1.0, 1e-6, 1.0]
    np.testing.assert_allclose(found[:, :3], printed, rtol=1e-12)
    between_rows = ms.thermal.Oil().properties(floats, 285.0)
    assert between_rows.viscosity == pytest.approx(np.sqrt(2430e-6 * 1120e-6), rel=1e-12)
    assert 0.5 * (2430e-6 + 1120e-6) / between_rows.viscosity == pytest.approx(1.076, abs=1e-3)


def test_the_table_of_oil_agrees_with_itself():
    """α = ν/Pr from the rows is the α that the textbook prints [1e-7 m²/s]."""
    printed = {273.0: 0.910, 300.0: 0.859, 350.0: 0.763, 400.0: 0.695, 430.0: 0.662}
    for temperature, alpha in printed.items():
        found = ms.thermal.Oil().properties(floats, temperature).diffusivity
        assert found == pytest.approx(1e-7 * alpha, rel=0.01)


@pytest.mark.parametrize("name", FLUIDS.names())
def test_properties_are_held_beyond_the_span(name):
    fluid: AbstractFluid = FLUIDS[name]()
    low, high = fluid.span()
    assert fluid.properties(floats, 0.0) == fluid.film_properties(floats, low)
    assert fluid.properties(floats, 5e3) == fluid.film_properties(floats, high)
    for temperature in np.linspace(low, high, 40).tolist():
        assert min(fluid.properties(floats, temperature)) > 0.0
