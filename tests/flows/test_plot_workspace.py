"""The figure of reachable angles shows the set, in degrees and millimetres.

Source of truth: the workspace, and lengths of the platform at angles read off the figure.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from drawn_texts import check_apart
from matplotlib.figure import Figure
from platform_cases import GEOMETRIES, PLATES

from martensite.actuators.mechanics.platform_kinematics import Plates, platform_lengths
from martensite.base.errors import InputError
from martensite.studies.platform.workspace import Workspace, reachable_angles
from martensite.studies.platform.workspace_figure import plot_workspace

CASES = {
    "platform": (PLATES, 0.030, 0.090),
    "low joint": (GEOMETRIES[1], 0.030, 0.090),
    "narrow": (PLATES, 0.050, 0.066),
    "wide": (PLATES, 0.020, 0.200),
    "tall": (Plates(0.01, 1.0, 1.0), 0.999, 1.001),
}


@cache
def workspace(case: str) -> Workspace:
    return reachable_angles(*CASES[case], math.radians(1.0))


@cache
def drawn(case: str) -> Figure:
    """The figure of a case; not to be changed."""
    return plot_workspace(workspace(case))


def labels(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def lines(figure: Figure, style: str, width: float) -> list[Any]:
    return [
        line
        for line in figure.axes[0].lines
        if line.get_linewidth() == width and line.get_linestyle() == style and np.size(line.get_xdata())
    ]


def lengths_at(case: str, line: Any) -> Any:
    """Lengths of all legs [m] at the points of a line: (points, 3)."""
    points = np.radians(np.transpose(line.get_data()))
    return np.array([platform_lengths(CASES[case][0], *point) for point in points.tolist()])


@pytest.mark.parametrize("case", ["platform", "low joint", "narrow", "tall"])
def test_the_edge_is_where_a_leg_meets_its_limit(case: str) -> None:
    """Solid at the shortest, dashed at the longest; to what a straight piece of it is off."""
    _, shortest, longest = CASES[case]
    near = 0.01 * (longest - shortest)
    solid, dashed = (lines(drawn(case), style, 1.2) for style in ("-", "--"))
    assert len(solid) >= 3 and len(dashed) >= 3
    for line in solid:
        assert lengths_at(case, line).min(axis=1) == pytest.approx(shortest, abs=near)
    for line in dashed:
        assert lengths_at(case, line).max(axis=1) == pytest.approx(longest, abs=near)


def test_the_edge_goes_round_the_reached_points() -> None:
    from matplotlib.path import Path

    runs = [line for style in ("-", "--") for line in lines(drawn("platform"), style, 1.2)]
    points = np.concatenate([np.transpose(line.get_data()) for line in runs])
    points = points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]
    inside = Path(np.vstack([points, points[:1]])).contains_points(
        np.degrees(workspace("platform").points()), radius=1e-6
    )
    assert inside.mean() > 0.995
    low, high = points.min(axis=0), points.max(axis=0)
    for k, (least, most) in enumerate(workspace("platform").bounds):
        assert low[k] == pytest.approx(math.degrees(least), abs=1.0)
        assert high[k] == pytest.approx(math.degrees(most), abs=1.0)


@pytest.mark.parametrize("case", CASES)
def test_numbers_on_contour_lines_are_lengths_of_leg_0(case: str) -> None:
    texts = [text for text in drawn(case).axes[0].texts if not text.get_text().startswith("leg")]
    assert len(texts) >= 5
    for text in texts:
        place = [math.radians(x) for x in text.get_position()]
        length = 1e3 * platform_lengths(CASES[case][0], *place)[0]
        apart = 1e3 * (CASES[case][2] - CASES[case][1])
        assert float(text.get_text()) == pytest.approx(length, abs=2e-3 * apart)


@pytest.mark.parametrize("case", CASES)
def test_rays_are_drawn_with_their_legs(case: str) -> None:
    for line, ray in zip(lines(drawn(case), "-", 1.6), workspace(case).rays, strict=True):
        np.testing.assert_allclose(np.transpose(line.get_data()), np.degrees(ray), rtol=1e-12)
    names = [t.get_text() for t in drawn(case).axes[0].texts if t.get_text().startswith("leg")]
    assert names == ["leg 0", "leg 1", "leg 2"]


def test_only_limits_that_are_met_are_named() -> None:
    assert labels(drawn("platform")) == [
        "a leg at its shortest, 30 mm",
        "a leg at its longest, 90 mm",
        "length of leg 0 [mm]",
        "one leg alone, against the other two",
    ]
    assert labels(drawn("wide"))[0] == "90°"
    assert not any("shortest" in name or "longest" in name for name in labels(drawn("wide")))


def test_axes_have_one_scale_and_say_their_angle() -> None:
    (axes,) = drawn("platform").axes
    assert axes.get_aspect() == 1.0
    assert axes.get_xlabel() == "rotation about X, $α$ [°]"
    assert axes.get_ylabel() == "rotation about Y, $β$ [°]"
    titles = [text.get_text() for text in plot_workspace(workspace("narrow"), "Mine").texts]
    assert titles == ["Mine"]


@pytest.mark.parametrize("case", CASES)
def test_no_text_covers_another_or_leaves_the_page(case: str) -> None:
    figure = plot_workspace(workspace(case))
    figure.draw_without_rendering()
    texts = [*figure.texts, *figure.axes[0].texts, *figure.legends[0].get_texts()]
    axes = figure.axes[0]
    texts += [axes.xaxis.label, axes.yaxis.label]
    check_apart(figure, texts)


def test_a_set_of_one_posture_is_refused() -> None:
    with pytest.raises(InputError, match="Nothing but the home posture"):
        plot_workspace(reachable_angles(PLATES, 0.060, 0.090))
