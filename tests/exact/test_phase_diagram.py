"""Phase diagrams: lines that are found by driving a law lie where its parameters put them.

Source of truth: the parameters of the law. No image is compared.
"""

from __future__ import annotations

import math
from typing import Any

import builders
import numpy as np
import pytest
from matplotlib.figure import Figure

from martensite.base.errors import InputError, ParameterError
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.show.figures.law_paths import plot_point
from martensite.show.figures.phase_diagram import Band, Line, find_bands, find_driven_bands
from martensite.simulate.path_layout import TWINNED, Choices
from martensite.simulate.paths import build_paths
from martensite.simulate.point import PointResult
from martensite.simulate.transformation_points import find_isobar, find_loaded

NAMES = ("A_s", "A_f", "M_s", "M_f")
STRESSES = [0.0, 100e6, 250e6, 400e6]


def example(name: str) -> Any:
    return builders.example(builders.REGISTRIES["law"][name])


def lines(found: list[Band]) -> dict[str, Line]:
    return {line.name: line for band in found for line in (band.start, band.finish)}


def followed(name: str, path: str, **choices: Any) -> list[PointResult]:
    law = example(name)
    courses = build_paths(path, law, Choices(**choices))
    return [course.follow(law, steps=40, tolerance=None) for course in courses]


# ---------------------------------------------------------------- lines


@pytest.mark.parametrize("name", ["liang-rogers", "elahinia"])
def test_driven_lines_agree_with_the_parameters(name: str) -> None:
    law = example(name)
    found = lines(find_driven_bands(law, STRESSES, 250.0))
    for line in NAMES:
        slope = law.C_A if line.startswith("A") else law.C_M
        expected = [getattr(law, line) + stress / slope for stress in STRESSES]
        assert found[line].stress == tuple(STRESSES)
        assert np.max(np.abs(np.subtract(found[line].temperature, expected))) < 0.1


def test_lines_from_parameters_are_taken_only_if_the_law_keeps_them() -> None:
    class Shifted(LiangRogers):
        """Transforms 20 K above its parameters."""

        def strips(self) -> Any:
            return tuple(s._replace(finish=s.finish + 20.0) for s in super().strips())

    values = {leaf.path: leaf.value for leaf in example("liang-rogers").leaves()}
    plain, shifted = (lines(find_bands(cls(**values), 200e6, 250.0)) for cls in (LiangRogers, Shifted))
    for name in NAMES:
        assert plain[name].temperature[0] == values[name]
        assert shifted[name].temperature[0] == pytest.approx(values[name] + 20.0, abs=0.1)


def test_brinson_has_bands_of_detwinning_and_of_cooling() -> None:
    law = example("brinson")
    found = {band.process: band for band in find_bands(law, 300e6, 260.0)}
    assert set(found) == {"loading", "cooling", "reverse"}
    loading = found["loading"]
    assert loading.start.stress[:2] == (law.sigma_s, law.sigma_s)
    assert loading.start.temperature[:2] == (260.0, law.M_s)
    (_, t0, t1), (_, s0, s1) = loading.finish.temperature, loading.finish.stress
    assert (s1 - s0) / (t1 - t0) == pytest.approx(law.C_M)
    onset = find_loaded(law, 270.0, TWINNED, 1e-5)
    assert onset is not None
    assert onset.stress == pytest.approx(law.sigma_s, rel=2e-3)


def test_cold_martensite_of_layers_turns_at_the_width_of_the_hysteresis() -> None:
    law = example("mas-hybrid")
    found = {band.process: band for band in find_bands(law, 300e6, 280.0)}
    assert set(found) == {"forward", "reverse", "orientation"}
    assert found["orientation"].finish.stress[0] == pytest.approx(law.Delta_sigma, rel=0.02)
    rest = law.T_L - law.sigma_L / law.dsigma_dT
    assert found["forward"].start.temperature[0] == pytest.approx(rest, abs=0.5)
    end = found["reverse"].finish
    assert end.temperature[0] == pytest.approx(rest + law.Delta_sigma / law.dsigma_dT, abs=0.5)
    # thermal activation moves the thresholds by about 1 MPa
    slope = (end.stress[-1] - end.stress[0]) / (end.temperature[-1] - end.temperature[0])
    assert slope == pytest.approx(law.dsigma_dT, rel=1e-3)


@pytest.mark.parametrize("name", builders.REGISTRIES["law"].names())
def test_every_law_has_a_forward_and_a_reverse_band_in_the_right_order(name: str) -> None:
    law = example(name)
    found = lines(find_bands(law, 200e6, 250.0))
    assert set(NAMES) <= set(found)
    marks = find_isobar(law)
    assert marks.M_f < marks.M_s
    assert marks.A_s < marks.A_f
    assert marks.M_s < marks.A_f


def test_a_law_that_never_transforms_has_no_bands_and_no_default_paths() -> None:
    class Inert(LiangRogers):
        def follow(self, xp: Any, move: Any, *rest: Any) -> Any:
            return super().follow(xp, move, *rest)._replace(martensite=0.0, oriented=0.0)

    law = Inert(**{leaf.path: leaf.value for leaf in example("liang-rogers").leaves()})
    assert all(math.isnan(value) for value in find_isobar(law))
    assert find_driven_bands(law, STRESSES, 250.0) == []
    with pytest.raises(ParameterError, match="does not transform fully"):
        build_paths("superelastic", law)


# ---------------------------------------------------------------- figures


def texts(figure: Figure) -> set[str]:
    return {text.get_text() for axes in figure.axes for text in axes.texts}


@pytest.mark.parametrize("path", ["superelastic", "shape-memory"])
def test_figure_of_one_law_has_four_panels_with_what_was_computed(path: str) -> None:
    results = followed("brinson", path)
    figure = plot_point(results)
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
    assert labels[0] == ("$ε$ [%]", "$σ$ [MPa]")
    assert labels[1] == ("$T$ [°C]", "$σ$ [MPa]")
    assert labels[2] == ("$T$ [°C]", "$ε$ [%]")
    assert len(figure.axes) == 4
    drawn = [line for line in figure.axes[0].lines if np.size(line.get_xdata()) > 1]
    highest = max(float(np.max(line.get_ydata())) for line in drawn)
    assert highest == pytest.approx(max(max(r.stress) for r in results) / 1e6)
    widest = max(float(np.max(line.get_xdata())) for line in drawn)
    assert widest == pytest.approx(100.0 * max(max(r.strain) for r in results))
    assert len(figure.axes[1].patches) == 3
    assert "$A_{s}$" in texts(figure)
    figure.canvas.draw()


def test_a_single_path_is_coloured_by_its_legs_several_by_path() -> None:
    one = plot_point(followed("brinson", "shape-memory"))
    several = plot_point(followed("brinson", "superelastic"))
    keys = [[t.get_text() for t in figure.legends[0].get_texts()] for figure in (one, several)]
    assert keys[0] == ["loading", "unloading", "heating", "cooling"]
    assert len(keys[1]) == 3
    assert all(key.endswith("°C") for key in keys[1])


def test_laws_stand_side_by_side_on_shared_axes() -> None:
    at = {"temperatures": (340.0,)}
    results = [r for n in ("liang-rogers", "brinson", "tanaka") for r in followed(n, "superelastic", **at)]
    figure = plot_point(results, plane=("strain", "stress"))
    assert len(figure.axes) == 9
    assert [axes.get_title("left") for axes in figure.axes[:3]] == ["liang-rogers", "brinson", "tanaka"]
    for row in range(3):
        limits = {(a.get_xlim(), a.get_ylim()) for a in figure.axes[3 * row : 3 * row + 3]}
        assert len(limits) == 1


def test_nothing_to_draw() -> None:
    with pytest.raises(InputError, match="at least one result"):
        plot_point([])
