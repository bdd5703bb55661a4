"""Figures show the numbers of the result, in the unit that their labels say.

Source of truth: a path written down by hand, whose values in °C, MPa, mm and % are written
down beside it, so no conversion of the package is used to check another. No image is compared;
that texts do not cover one another is measured on the drawn figure.
"""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from builders import example, plain_law, plain_system
from drawn_texts import check_apart, visible_texts
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.text import Text

from martensite.base.errors import DataError
from martensite.base.parameters import Number, param
from martensite.base.status import Status
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.laws.mas import MullerAchenbachSeelecke
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.show.figures import overview
from martensite.show.figures.hysteresis import find_senses, find_strips
from martensite.show.figures.overview import plot_result, save_figure
from martensite.show.figures.style import write_figure
from martensite.signals.base import AbstractWaveform
from martensite.simulate.result import Result

N = 41
TIMES = np.arange(N) * 1.0
UP_DOWN = 1.0 - np.abs(TIMES / 20.0 - 1.0)  # 0 to 1 and back
CELSIUS = 20.0 + 100.0 * UP_DOWN
MEGAPASCAL = 100.0 + 40.0 * (UP_DOWN - UP_DOWN.mean())
PERCENT = 4.0 - 3.5 * UP_DOWN**2
MILLIMETRE = 8.0 * UP_DOWN**2
SHOWN = {
    "drive": ("drive signal", "$u$ [V]", 2.0 * UP_DOWN),
    "temperature": ("wire temperature", "$T$ [°C]", CELSIUS),
    "martensite_fraction": ("martensite fraction", "$ξ$ [–]", 1.0 - UP_DOWN**2),
    "strain": ("strain", "$ε$ [%]", PERCENT),
    "stress": ("axial stress", "$σ$ [MPa]", MEGAPASCAL),
    "position": ("position of the mechanism", "$x$ [mm]", MILLIMETRE),
    "resistance": ("electrical resistance", "$R$ [Ω]", 2.0 + 0.25 * UP_DOWN),
}
SI = {
    "drive": 2.0 * UP_DOWN,
    "temperature": CELSIUS + 273.15,
    "martensite_fraction": 1.0 - UP_DOWN**2,
    "strain": PERCENT / 100.0,
    "stress": MEGAPASCAL * 1e6,
    "position": MILLIMETRE / 1e3,
    "resistance": 2.0 + 0.25 * UP_DOWN,
}
LOOPS = (("temperature", "martensite_fraction"), ("temperature", "strain"), ("strain", "stress"))
PEAK = 20

OUTPUTS = plain_system().outputs()


class Still(AbstractWaveform):
    def value(self, time: float) -> float:
        return 0.0


class Critical(LiangRogers):
    """A law whose forward strip does not simply shift with stress."""

    sigma_s: Number = param("Pa", "critical stress", default=1e8)


@dataclass
class Measured:
    name: str
    columns: dict[str, list[float]]
    units: dict[str, str]


def make_result(law: AbstractLaw | None = None, source: AbstractSource | None = None, **columns: Any) -> Result:
    system = plain_system(law, source)
    others = {name: np.full(N, 0.5) for name in OUTPUTS}
    lists = {n: np.asarray(c).tolist() for n, c in {**others, **SI, **columns}.items()}
    return Result(system, Still(), TIMES.tolist(), lists, Status.OK, 0.0, 400, 0.1, 2e-5, [])


def make_record(name: str = "bench", every: int = 1, **columns: Any) -> Measured:
    lists = {n: np.asarray(c)[::every].tolist() for n, c in {"time": TIMES, **columns}.items()}
    units = {n: "s" if n == "time" else OUTPUTS[n][0] for n in lists}
    return Measured(name, lists, {**units, **({"drive": "V"} if "drive" in units else {})})


@cache
def plain() -> Figure:
    """The figure of the plain result; not to be changed."""
    return plot_result(make_result())


def panels(figure: Figure) -> dict[str, Any]:
    """The axes over time by their titles."""
    return {axes.get_title("left"): axes for axes in figure.axes if axes.get_title("left")}


def loops(figure: Figure) -> list[Any]:
    return [axes for axes in figure.axes if not axes.get_title("left")]


def legend_texts(axes: Any) -> list[str]:
    legend = axes.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend else []


def lines_named(axes: Any, label: str) -> list[Any]:
    return [line for line in axes.lines if line.get_label() == label]


def all_texts(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text)]


# ------------------------------------------------------------------ time series


def test_one_panel_per_quantity_and_three_loops() -> None:
    figure = plain()
    assert list(panels(figure)) == [title for title, _, _ in SHOWN.values()]
    assert len(figure.axes) == len(SHOWN) + len(LOOPS)


@pytest.mark.parametrize("name", SHOWN)
def test_a_panel_shows_the_column_in_the_unit_of_its_label(name: str) -> None:
    title, label, values = SHOWN[name]
    axes = panels(plain())[title]
    assert axes.get_ylabel() == label
    (line,) = axes.lines
    np.testing.assert_allclose(line.get_xdata(), TIMES, rtol=1e-14)
    np.testing.assert_allclose(line.get_ydata(), values, rtol=1e-12, atol=1e-12)
    low, high = axes.get_ylim()
    assert low < values.min() and values.max() < high


def test_only_the_lowest_panel_names_the_time() -> None:
    over_time = list(panels(plain()).values())
    assert [axes.get_xlabel() for axes in over_time] == [""] * 6 + ["$t$ [s]"]
    assert {axes.get_xlim() for axes in over_time} == {(0.0, 40.0)}


def test_a_prescribed_temperature_is_shown_once() -> None:
    figure = plot_result(make_result(source=PrescribedTemperature()))
    assert "drive signal" not in panels(figure)
    assert len(figure.axes) == len(SHOWN) - 1 + len(LOOPS)


def test_a_constant_looks_constant() -> None:
    noisy = 1e8 * (1.0 + 1e-13 * np.sin(TIMES))
    low, high = panels(plot_result(make_result(stress=noisy)))["axial stress"].get_ylim()
    assert (low, high) == pytest.approx((90.0, 110.0))


# ------------------------------------------------------------------ loops


@pytest.mark.parametrize("place", range(3))
def test_a_loop_is_split_into_heating_and_cooling(place: int) -> None:
    x, y = LOOPS[place]
    axes = loops(plain())[place]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (SHOWN[x][1], SHOWN[y][1])
    for label, part in (("heating", slice(0, PEAK + 1)), ("cooling", slice(PEAK, N))):
        (line,) = lines_named(axes, label)
        drawn = np.stack(line.get_data())[:, :-1]  # the last point is the gap
        np.testing.assert_allclose(drawn, [SHOWN[x][2][part], SHOWN[y][2][part]], rtol=1e-12)
    assert len({line.get_color() for line in axes.lines}) == 3  # heating, cooling, start


@pytest.mark.parametrize("place", range(3))
def test_arrows_point_along_the_path(place: int) -> None:
    x, y = LOOPS[place]
    axes = loops(plain())[place]
    arrows = {a.arrow_patch.get_facecolor(): a for a in axes.texts if a.arrow_patch is not None}
    assert len(arrows) == 2
    for label, start, end in (("heating", 0, PEAK), ("cooling", PEAK, N - 1)):
        (line,) = lines_named(axes, label)
        arrow = arrows[to_rgba(line.get_color())]
        for i, name in enumerate((x, y)):
            way = SHOWN[name][2][end] - SHOWN[name][2][start]
            assert (arrow.xy[i] - arrow.xyann[i]) * way > 0.0


def test_an_isothermal_path_has_neither_heating_nor_cooling() -> None:
    axes = loops(plot_result(make_result(temperature=np.full(N, 350.0))))[2]
    assert not lines_named(axes, "heating") + lines_named(axes, "cooling")
    (line,) = lines_named(axes, "isothermal")
    np.testing.assert_allclose(line.get_ydata()[:-1], MEGAPASCAL)


def test_ripple_is_no_turn_but_a_minor_loop_is() -> None:
    ripple = CELSIUS + np.where(np.arange(N) % 2, 0.0, 1.5)  # of 100 K
    slow = np.interp(np.arange(801), np.linspace(0, 800, N), CELSIUS)
    slow = slow + np.where(np.arange(801) % 2, 0.0, 3.0)
    found = find_senses(slow.tolist())
    assert np.flatnonzero(np.diff(found)).size == 1
    assert abs(int(np.flatnonzero(np.diff(found))[0]) - 400) <= 10
    assert find_senses(ripple.tolist()).tolist()[:PEAK] == [1] * PEAK
    minor = [300.0, 350.0, 340.0, 400.0]
    assert find_senses(minor).tolist() == [1, -1, 1]
    assert find_senses([300.0, 300.0, 340.0, 320.0, 320.0]).tolist() == [1, 1, -1, -1]
    assert find_senses([300.0, 300.0, 300.0]).tolist() == [0, 0]


def test_strips_lie_at_the_mean_stress() -> None:
    reverse, forward = find_strips(make_result())  # mean stress 100 MPa
    assert (reverse.low, reverse.high) == pytest.approx((78.0, 88.0))
    assert (forward.low, forward.high) == pytest.approx((54.5, 64.5))
    first, second, third = loops(plain())
    for axes in (first, second):
        edges = sorted(patch.get_x() for patch in axes.patches)
        assert edges == pytest.approx([54.5, 78.0])
    assert not third.patches
    names = [text.get_text() for text in first.texts]
    assert {"$A_{s}$", "$A_{f}$", "$M_{s}$", "$M_{f}$"} <= set(names)
    assert any("mean stress of 100 MPa" in name for name in names)


@pytest.mark.parametrize("law", [plain_law(Critical), example(MullerAchenbachSeelecke)])
def test_no_strips_for_laws_that_do_not_shift_them(law: AbstractLaw) -> None:
    figure = plot_result(make_result(law))
    assert not any(axes.patches for axes in loops(figure))
    assert "$A_{s}$" not in all_texts(figure)


# ------------------------------------------------------------------ measured records


def test_a_record_is_drawn_with_its_rms_in_the_unit_of_the_axis() -> None:
    apart = np.where(np.arange(N) % 2, 0.5e-3, -0.5e-3)
    record = make_record(position=SI["position"] + apart, temperature=SI["temperature"] + 2.0)
    over_time = panels(plot_result(make_result(), [record]))
    axes = over_time["position of the mechanism"]
    simulated, measured = axes.lines
    np.testing.assert_allclose(simulated.get_ydata(), MILLIMETRE, atol=1e-12)
    np.testing.assert_allclose(measured.get_ydata(), MILLIMETRE + apart * 1e3, atol=1e-12)
    assert measured.get_color() != simulated.get_color()
    assert legend_texts(axes) == ["RMS 0.5 mm"]
    assert legend_texts(over_time["wire temperature"]) == ["RMS 2 K"]
    assert len(over_time["axial stress"].lines) == 1
    assert legend_texts(over_time["axial stress"]) == []


def test_the_key_names_the_records() -> None:
    record = make_record("run 7", position=SI["position"])
    assert {"simulated", "run 7"} <= set(all_texts(plot_result(make_result(), [record])))
    assert "simulated" not in all_texts(plain())


def test_short_records_are_dots_and_long_ones_lines() -> None:
    fine = np.linspace(0.0, 40.0, 801)
    columns = {"time": fine.tolist(), "position": [0.0] * 801}
    long = Measured("long", columns, {"time": "s", "position": "m"})
    short = make_record("short", position=SI["position"])
    axes = panels(plot_result(make_result(), [short, long]))["position of the mechanism"]
    _, dots, line = axes.lines
    assert (dots.get_marker(), dots.get_linestyle()) == ("o", "None")
    assert (line.get_marker(), line.get_linestyle()) == ("None", "-")


def test_the_rms_interpolates_skips_gaps_and_what_was_not_simulated() -> None:
    measured = Measured(
        "coarse",
        {"time": [-1.0, 0.5, 10.5, 30.0, 99.0], "drive": [9.0, 1.05, 2.05, float("nan"), 9.0]},
        {"time": "s", "drive": "V"},
    )
    axes = panels(plot_result(make_result(drive=TIMES * 0.1), [measured]))["drive signal"]
    assert legend_texts(axes) == ["RMS 1 V"]  # 1.05 - 0.05 and 2.05 - 1.05


def test_many_records_share_one_rms() -> None:
    records = [make_record(f"r{k}", position=SI["position"] + k * 1e-3) for k in (1, 2, 2)]
    axes = panels(plot_result(make_result(), records))["position of the mechanism"]
    assert len(axes.lines) == 4
    assert legend_texts(axes) == ["RMS 1.73 mm (3 records)"]  # √((1 + 4 + 4)/3)


def test_another_measured_quantity_gets_a_panel() -> None:
    figure = plot_result(make_result(), [make_record(current=np.full(N, 0.75))])
    axes = panels(figure)["current"]
    assert axes.get_ylabel() == "$I$ [A]"
    np.testing.assert_allclose(axes.lines[1].get_ydata(), 0.75)
    assert legend_texts(axes) == ["RMS 0.25 A"]
    assert len(figure.axes) == len(SHOWN) + 1 + len(LOOPS)


def test_records_appear_in_loops_where_they_have_both_quantities() -> None:
    record = make_record(temperature=SI["temperature"] + 5.0, strain=SI["strain"])
    first, second, third = loops(plot_result(make_result(), [record]))
    (measured,) = lines_named(second, "_measured")
    np.testing.assert_allclose(measured.get_data(), [CELSIUS + 5.0, PERCENT])
    assert not lines_named(first, "_measured") + lines_named(third, "_measured")


@pytest.mark.parametrize(
    ("columns", "units", "sentence"),
    [
        ({"position": [0.0]}, {"position": "m"}, "no column `time`"),
        ({"time": [0.0], "angle": [0.0]}, {"time": "s", "angle": "rad"}, "no column to compare"),
        ({"time": [0.0], "drive": [0.0]}, {"time": "s", "drive": "A"}, "no column to compare"),
        ({"time": [50.0], "position": [0.0]}, {"time": "s", "position": "m"}, "between 0 and 40 s"),
    ],
)
def test_a_record_that_cannot_be_compared_is_refused(
    columns: dict[str, list[float]], units: dict[str, str], sentence: str
) -> None:
    with pytest.raises(DataError, match=f"`odd`.*{sentence}"):
        plot_result(make_result(), [Measured("odd", columns, units)])


# ------------------------------------------------------------------ the whole figure


def test_title_summary_and_warnings_are_on_the_figure() -> None:
    result = replace(make_result(), notes=["Warning: hot."], status=Status.LONG_STEP)
    texts = all_texts(plot_result(result))
    assert "Wire (liang-rogers) on dead-weight, driven by voltage" in texts
    assert "Warning: hot." in texts
    assert any("stroke 8 mm" in t and "2.0e-05" in t and "long step" in t for t in texts)
    assert "Mine, for 5 $ and 6 $" in all_texts(plot_result(result, title="Mine, for 5 $ and 6 $"))


CASES = {
    "plain": (make_result(), []),
    "close strips": (make_result(plain_law(M_s=340.15, M_f=338.15)), []),
    "constant": (make_result(temperature=np.full(N, 350.0), position=np.zeros(N)), []),
    "small": (make_result(position=SI["position"] * 1e-4, resistance=SI["position"] + 1e4), []),
    "records": (
        replace(make_result(), notes=["Warning: " + "long " * 60, "Short."]),
        [
            make_record("a rather long name of a measured record $x$", position=SI["position"]),
            make_record("_b", position=SI["position"], strain=SI["strain"], drive=SI["drive"]),
            make_record("third", position=SI["position"], temperature=SI["temperature"]),
        ],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_no_text_covers_another_and_legends_stand_outside_the_data(case: str) -> None:
    figure = plot_result(*CASES[case])
    figure.draw_without_rendering()
    texts = visible_texts(figure)
    assert len(texts) > 40
    check_apart(figure, texts)
    legends = [legend for axes in figure.axes if (legend := axes.get_legend())]
    assert legends
    for legend in [*legends, *figure.legends]:
        for axes in figure.axes:
            assert not legend.get_window_extent().overlaps(axes.get_window_extent())


# ------------------------------------------------------------------ files


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".SVG", b"<?xml"), (".pdf", b"%PDF")])
def test_a_figure_is_saved_in_the_format_of_its_suffix_and_nothing_global_changes(
    tmp_path: Path, suffix: str, start: bytes
) -> None:
    target = tmp_path / f"figure{suffix}"
    with matplotlib.rc_context({"font.size": 7.25, "axes.grid": False}):
        before = dict(matplotlib.rcParams)
        save_figure(make_result(), target) if suffix == ".png" else write_figure(plain(), target)
        assert dict(matplotlib.rcParams) == before
    assert target.read_bytes().startswith(start)
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["figure.jpg", "figure", "figure.png.bak"])
def test_another_suffix_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(DataError, match=r"`\.png`, `\.svg`, `\.pdf`"):
        save_figure(make_result(), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_failed_replacement_leaves_the_old_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "figure.png"
    target.write_bytes(b"old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(DataError, match="No space left"):
        write_figure(Figure(), target)
    assert target.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [target]


def test_pyplot_is_not_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    """No module names it, and a figure is drawn while it cannot be imported."""
    files = Path(overview.__file__).parents[1].rglob("*.py")
    assert [
        path.name for path in files if re.search(r"^\s*(from|import) .*\bpyplot\b", path.read_text("utf-8"), re.M)
    ] == []
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.delattr(matplotlib, "pyplot", raising=False)
    plot_result(make_result())
