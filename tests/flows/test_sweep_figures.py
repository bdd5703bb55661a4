"""Figures of sweeps: what is drawn, and that texts do not cover one another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from drawn_texts import check_apart, visible_texts
from sweep_tables import ANGLES, ishigami, table, with_status, with_value

from martensite.base.errors import UnknownNameError
from martensite.design.sweep.axes import parse_axis
from martensite.design.sweep.indices import compute_sensitivity
from martensite.design.sweep.pareto import find_pareto_front
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.show.figures.sweep import plot_sweep
from martensite.show.figures.sweep_analysis import plot_pareto, plot_sensitivity

GRID = [replace(one, count=7) for one in ANGLES]
LOG = parse_axis("h=10..1000 W/m^2/K log", {"h": replace(ANGLES[0].target, name="h", unit="W/m^2/K")})


def cosine(x: np.ndarray) -> np.ndarray:
    return np.cos(x[:, 0])


def square(x: np.ndarray) -> np.ndarray:
    return x[:, 0] ** 2


def drawn(figure: Any) -> list[Any]:
    """All panels of a figure that was drawn, its texts apart."""
    figure.draw_without_rendering()
    check_apart(figure, visible_texts(figure))
    return figure.axes


def test_one_number_is_drawn_as_lines_with_failed_runs_marked() -> None:
    found = table("grid", GRID[:1], y=cosine, z=square)
    found = with_value(with_status(found, s2=[1]), "z", 3, np.inf)
    panels = drawn(plot_sweep(found))
    assert [p.get_ylabel() for p in panels] == ["y [mm]", "z [mm]"]
    line, failed = panels[0].lines
    assert len(line.get_xdata()) == 6
    assert failed.get_xdata() == pytest.approx([GRID[0].levels()[1]])
    assert [one.get_label() for one in panels[1].lines[1:]] == ["failed", "never"]


def test_two_numbers_are_drawn_as_a_map() -> None:
    found = table("grid", GRID[:2], y=lambda x: x[:, 0] + 10.0 * x[:, 1])
    panel, _ = drawn(plot_sweep(found))
    mesh = panel.collections[0]
    truth = 1e3 * (GRID[0].levels()[None, :] + 10.0 * GRID[1].levels()[:, None])
    assert np.asarray(mesh.get_array()).reshape(7, 7) == pytest.approx(truth)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x1 [–]", "x2 [–]")


def test_more_numbers_are_drawn_as_scatter() -> None:
    found = table("sobol:64", [*ANGLES[:2], LOG], y=lambda x: x[:, 0] + x[:, 1])
    panels = drawn(plot_sweep(with_status(found, s3=[4])))
    shown = [p for p in panels if p.axison and p.collections]
    below = [p for p in shown if p.get_xlabel()]
    assert [p.get_xlabel() for p in below] == ["x1 [–]", "x2 [–]", "h [W/m²/K]"]
    assert below[2].get_xscale() == "log"
    points = np.asarray(below[2].collections[0].get_offsets())
    usable = np.arange(64) != 4
    assert points[:, 0] == pytest.approx(found.varied["h"].values[usable])
    assert points[:, 1] == pytest.approx(1e3 * found.measures["y"].values[usable])


def test_of_many_numbers_the_leading_ones_are_drawn() -> None:
    (target,) = ANGLES[0].targets
    many = [replace(ANGLES[0], name=f"a{k}", targets=(replace(target, name=f"a{k}"),)) for k in range(8)]
    found = table("sobol:128", many, y=lambda x: x @ np.array([9, 8, 7, 0, 6, 5, 0, 4.0]))
    names = [p.get_xlabel().split()[0] for p in plot_sweep(found).axes if p.get_xlabel()]
    assert names == ["a0", "a1", "a2", "a4", "a5", "a7"]


@pytest.mark.parametrize("sample", ["saltelli:64", "sobol:128"])
def test_bars_are_as_long_as_the_indices(sample: str) -> None:
    found = compute_sensitivity(table(sample, y=ishigami, z=lambda x: x[:, 2], same=lambda x: 0 * x[:, 0]))
    panels = drawn(plot_sensitivity(found, "Functions"))
    assert [p.get_title("left") for p in panels] == ["y", "z", "same (always the same)"]
    one, panel = found[0], panels[0]
    bars = {c.get_label(): c for c in panel.containers if len(c) == 3 and c.get_label() in one.indices}
    for kind, container in bars.items():
        lengths = [bar.get_width() for bar in container]
        assert lengths == pytest.approx(one.indices[kind].values[one.order])
    assert next(t.get_text() for t in panel.get_yticklabels()) == "x1"


@pytest.mark.parametrize("width", [2, 3])
def test_a_front_is_drawn_with_its_designs(width: int) -> None:
    found = table("sobol:256", y=lambda x: x[:, 0] ** 2, z=lambda x: x[:, 0] + x[:, 1] / 9)
    goals = ["y", "x3"][: width - 1]
    front = find_pareto_front(found, goals, ["z"])
    figure = plot_pareto(found, front)
    figure.draw_without_rendering()
    panels = [p for p in figure.axes if p.get_xlabel()]
    assert len(panels) == width * (width - 1) // 2
    line = next(one for one in panels[0].lines if "front" in str(one.get_label()))
    assert line.get_xdata() == pytest.approx(1e3 * found.measures["y"].values[front.runs])
    (told,) = figure.axes[-1].tables
    letters = {t.get_text() for t in panels[0].texts}
    assert letters == set("ABCDEF")
    assert told[1, 0].get_text().get_text().split() == ["A", str(front.runs[0])]


def test_units_are_those_that_people_read() -> None:
    def words(name: str, unit: str, value: float) -> str:
        return SweepColumn(name, unit, np.zeros(1)).words(value)

    assert words("max(temperature)", "K", 373.15) == "100 degC"
    assert words("stroke(temperature)", "K", 80.0) == "80 K"
    assert words("rise-time", "s", np.inf) == "never"
    assert SweepColumn("max(temperature)", "K", np.zeros(1)).apart(12.0) == "12 K"
    assert SweepColumn("max(stress)", "Pa", np.zeros(1)).apart(2e6) == "2 MPa"


def test_an_unknown_measure_is_refused() -> None:
    found: SweepTable = table("grid", GRID[:1], y=cosine, z=square)
    with pytest.raises(UnknownNameError, match="measure in this sweep"):
        plot_sweep(found, ["x"])
