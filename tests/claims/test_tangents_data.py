"""The tangent method on two published series of isobaric cycles.

Numbers to compare with were found by numpy on the plain text of the files, code not shared with
the method: where each branch passes half of its stroke, straight from row to row.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from martensite.characterise.tangent_fit import TangentFit, fit_tangents
from martensite.characterise.tangent_points import TangentPoints
from martensite.logs import datasets
from martensite.logs.reader import read_table

FLEXINOL = {f"flexinol-isobaric/isobaric_{mpa}MPa.txt": 1e6 * mpa for mpa in (50, 100, 172, 200)}
NITIHF = {f"nitihf-isobaric/isobaric_{mpa}MPa.txt": 1e6 * mpa for mpa in (7, 50, 100, 300, 400)}
HEATING, COOLING = (83.7, 89.7, 98.7, 102.2), (62.9, 69.9, 79.4, 82.8)
"""Temperatures of the rows nearest to half of the stroke [degC]."""
STROKES = (4.13, 4.35, 4.50, 4.56)
"""[%]"""
KELVIN = 273.15


def needs(files: dict[str, float]) -> pytest.MarkDecorator:
    name = next(iter(files)).partition("/")[0]
    here = all(map(datasets.is_here, files))
    return pytest.mark.skipif(not here, reason=f"data set {name} is not on this machine")


def fitted(files: dict[str, float]) -> TangentFit:
    return fit_tangents([read_table(f"data:{name}") for name in files])


@pytest.fixture(scope="module")
def flexinol() -> TangentFit:
    return fitted(FLEXINOL)


@pytest.fixture(scope="module")
def nitihf() -> TangentFit:
    return fitted(NITIHF)


def half_of_stroke(name: str, factor: float = 1.0) -> list[tuple[float, float, float]]:
    """Of both branches: where half of the stroke is passed, the nearest row, the rows' distance."""
    T, strain, _ = np.loadtxt(datasets.locate_file(name)).T
    strain = factor * strain
    hottest = int(T.argmax())
    middle = 0.5 * (strain.max() + strain.min())
    found: list[tuple[float, float, float]] = []
    for rows in (slice(0, hottest + 1), slice(hottest, None)):
        t, left = T[rows], strain[rows] - middle
        k = int(np.flatnonzero(left[:-1] * left[1:] <= 0.0)[0])
        at = t[k] + (t[k + 1] - t[k]) * left[k] / (left[k] - left[k + 1])
        found.append((float(at), float(t[abs(left).argmin()]), float(abs(t[k + 1] - t[k]))))
    return found


def halves(points: TangentPoints) -> tuple[float, float]:
    return points.A_half - KELVIN, points.M_half - KELVIN


# ---------------------------------------------------------------- Flexinol


@needs(FLEXINOL)
def test_half_way_temperatures_of_flexinol(flexinol: TangentFit) -> None:
    """Within 0.3 K of the crossings; the listed numbers are those of the nearest rows."""
    for k, (name, points) in enumerate(zip(FLEXINOL, flexinol.levels, strict=True)):
        rows = half_of_stroke(name)
        for found, (at, nearest, apart), listed in zip(halves(points), rows, (HEATING[k], COOLING[k]), strict=True):
            assert listed == pytest.approx(nearest, abs=0.06)
            assert found == pytest.approx(at, abs=0.3)
            assert abs(found - listed) < 0.3 + 0.5 * apart


@needs(FLEXINOL)
def test_another_half_way_would_be_noticed(flexinol: TangentFit) -> None:
    """Half of the stroke is not the same as the middle of start and finish."""
    points, (heating, _) = flexinol.levels[0], half_of_stroke(next(iter(FLEXINOL)))
    assert abs(points.A_s - KELVIN - heating[0]) > 2.0
    assert abs(points.A_f - KELVIN - heating[0]) > 2.0


@needs(FLEXINOL)
def test_slopes_and_strokes_of_flexinol(flexinol: TangentFit) -> None:
    assert flexinol.C_A == pytest.approx(8.1e6, abs=0.1e6)
    assert flexinol.C_M == pytest.approx(7.5e6, abs=0.1e6)
    for direction, slope in ((flexinol.reverse, 8.1e6), (flexinol.forward, 7.5e6)):
        half = next(line for name, line in direction.own.items() if name.endswith("half"))
        assert 1.0 / half.values[1] == pytest.approx(slope, abs=0.1e6)
        low, high = direction.slope_interval()
        assert low < slope < high and high - low < 0.3 * slope
    strokes = [100.0 * points.stroke for points in flexinol.levels]
    assert strokes == pytest.approx(STROKES, abs=0.006)
    stresses = [points.stress for points in flexinol.levels]
    assert stresses == pytest.approx(list(FLEXINOL.values()), rel=1e-3)
    assert all(2e6 < points.stress_deviation < 4e6 for points in flexinol.levels)


@needs(FLEXINOL)
def test_what_the_tangents_of_flexinol_say(flexinol: TangentFit) -> None:
    """To the digits noted: a change of the method shows here."""
    found = [[getattr(flexinol, n).value - KELVIN for n in ("A_s", "A_f", "M_s", "M_f")]]
    found += [[getattr(p, n) - KELVIN for n in ("A_s", "A_f", "M_s", "M_f")] for p in flexinol.levels]
    assert np.asarray(found) == pytest.approx(
        np.asarray(
            [
                [74.14, 80.90, 60.86, 52.74],
                [81.06, 86.62, 67.81, 58.27],
                [86.47, 92.99, 74.40, 66.59],
                [95.04, 102.50, 83.02, 76.19],
                [98.67, 106.17, 87.09, 78.78],
            ]
        ),
        abs=0.02,
    )
    assert [100.0 * p.H for p in flexinol.levels] == pytest.approx([3.35, 3.47, 3.70, 3.72], abs=0.01)
    assert all(p.H < p.stroke for p in flexinol.levels)  # round ends and slopes are outside
    assert all(abs(p.residual_strain) < 3e-4 for p in flexinol.levels)
    assert flexinol.strain.form == "constant"


# ---------------------------------------------------------------- NiTiHf


@needs(NITIHF)
def test_nitihf(nitihf: TangentFit) -> None:
    """Half-way temperatures are those of the crossings, and H that of the strokes."""
    for name, points in list(zip(NITIHF, nitihf.levels, strict=True))[1:]:
        for found, (at, _, apart) in zip(halves(points), half_of_stroke(name, 0.01), strict=True):
            assert found == pytest.approx(at, abs=0.3 * apart + 0.3)
        assert points.H == pytest.approx(points.stroke, rel=0.035)


@needs(NITIHF)
def test_what_the_tangents_of_nitihf_say(nitihf: TangentFit) -> None:
    """To the digits noted: a change of the method shows here."""
    found = [[*(getattr(p, n) - KELVIN for n in ("A_s", "A_f", "M_s", "M_f")), 1000.0 * p.H] for p in nitihf.levels]
    expected = [
        [203.9, 212.2, 179.2, 169.6, 2.02],
        [204.6, 212.9, 179.7, 173.1, 9.62],
        [207.5, 216.5, 184.6, 174.7, 15.45],
        [220.8, 235.2, 210.6, 186.6, 26.87],
        [227.6, 254.9, 225.5, 194.3, 30.42],
    ]
    assert np.asarray(found) == pytest.approx(np.asarray(expected), abs=0.1)


@needs(NITIHF)
def test_without_load_expansion_hides_the_stroke(nitihf: TangentFit) -> None:
    """At 7 MPa thermal strain over 320 K exceeds the transformation strain; tangents tell them."""
    points = nitihf.levels[0]
    assert points.alpha_A == pytest.approx(1.11e-5, abs=3e-7)
    assert points.alpha_M == pytest.approx(0.87e-5, abs=3e-7)
    assert points.H == pytest.approx(0.0020, abs=1e-4)
    assert 205.0 < points.A_half - KELVIN < 211.0


@needs(NITIHF)
def test_nitihf_over_stress(nitihf: TangentFit) -> None:
    assert nitihf.C_A == pytest.approx(11.8e6, abs=0.1e6)
    assert nitihf.C_M == pytest.approx(10.9e6, abs=0.1e6)
    assert nitihf.strain.form == "saturating" and nitihf.strain.H_k is not None
    assert nitihf.strain.H_sat.value == pytest.approx(0.0327, abs=3e-4)
    assert nitihf.strain.H_k.value == pytest.approx(6.05e-9, rel=0.02)
    assert nitihf.strain.deviation < 6e-4
    widths = [text for text in nitihf.remarks if "rise differently" in text]
    assert len(widths) == 2  # start and finish spread with stress in this alloy
    assert all(math.isfinite(value) for value in nitihf.guess().values())
