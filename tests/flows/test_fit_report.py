"""The report of a fit says what the fit says, marks what was held out, and stands alone.

Source of truth: the fit itself, errors recomputed here from measured and modelled rows, the bytes
of the records. The page is read with the parser of the standard library. No image is compared;
lines and numbers are read off the figures, and texts must not cover one another.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn_texts import check_apart, visible_texts
from finished_fits import FREE, Sample, poor_sample, sample
from matplotlib.figure import Figure

from martensite.base.errors import InputError
from martensite.fit.fit import HELD_OUT, TRAINING, Fit, compute_rms, find_covered_range, list_compared
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.search.profile import Profile, ProfileEnd, ProfilePoint
from martensite.show import html, pages
from martensite.show.figures.fit import HELD, SEEN, plot_fit, plot_fit_loops, plot_fit_residuals
from martensite.show.figures.fit_knowledge import plot_correlation, plot_likelihood, plot_search, plot_singular_values
from martensite.show.figures.style import SIMULATED
from martensite.show.pages import list_page_files, render_markdown, write_report
from martensite.show.summaries.fit import summarise_fit

VOID = {"meta", "img", "br", "hr", "link"}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    """A good fit."""
    return sample(tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def poor(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    """A fit with much to warn of."""
    return poor_sample(tmp_path_factory.mktemp("poor"))


def profiles(fit: Fit) -> list[Profile]:
    """Profiles of a kind that a model linear in its parameters would give, one of them open."""
    found: list[Profile] = []
    for name, open_side in (("A_s", False), ("C_A", True)):
        best, error = fit[name], fit.uncertainty.errors[fit.problem.names.index(name)]
        steps = np.linspace(-2.2, 2.2 if not open_side else 1.0, 9)
        points = tuple(ProfilePoint(best + k * error, float(k * k), ()) for k in steps)
        high = ProfileEnd(best + error, "bound") if open_side else ProfileEnd(best + 2 * error, "limit")
        ends = ProfileEnd(best - 2 * error, "limit"), high
        unit = "K" if name == "A_s" else "Pa/K"
        found.append(Profile(name, unit, best, 0.95, 4.0, points, *ends, None))
    return found


# ---------------------------------------------------------------- reading a page


@dataclass
class Page(HTMLParser):
    """Tables, texts and figures of a page in their order; tags must be closed in order."""

    text: str
    open: list[str] = field(default_factory=list)
    tables: list[list[tuple[str, list[str]]]] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)
    sources: list[str] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = {key: value or "" for key, value in attrs}
        if tag not in VOID:
            self.open.append(tag)
        if "id" in known:
            self.ids.append(known["id"])
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append((known.get("class", ""), []))
        elif tag in ("td", "th"):
            self.tables[-1][-1][1].append("")
        elif tag == "img":
            self.sources.append(known["src"])
        if tag in ("table", "h2", "figure") or "notice" in known.get("class", ""):
            self.parts.append(known.get("class") or tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and {"td", "th"} & set(self.open):
            self.tables[-1][-1][1][-1] += data

    def table(self, heading: str) -> list[tuple[str, dict[str, str]]]:
        """Rows of the table that has a heading: class and cells by heading."""
        (found,) = [one for one in self.tables if heading in one[0][1]]
        head, *rows = found
        return [(kind, dict(zip(head[1], cells, strict=True))) for kind, cells in rows]


PAGES: dict[Path, Page] = {}


def page(one: Sample) -> Page:
    """The report of a sample; written once."""
    if one.folder not in PAGES:
        with pytest.MonkeyPatch.context() as patch:
            if one.fit.identifiability.determined:
                how: dict[str, Any] = {"profiles": profiles(one.fit)}
            else:  # its figures are drawn below
                how = {}
                patch.setattr(html, "format_svg", lambda _: "<svg/>")
            PAGES[one.folder] = fresh(one, **how)
    return PAGES[one.folder]


def fresh(one: Sample, name: str = "report.html", **how: Any) -> Page:
    """A report that is written anew."""
    arguments: dict[str, Any] = {"scenario": one.scenario} | how
    (path,) = write_report(one.fit, one.folder / name, **arguments)
    return Page(path.read_text(encoding="utf-8"))


# ---------------------------------------------------------------- numbers


def wrong_numbers(fit: Fit, read: Page) -> list[str]:
    """Parameters whose number in full is not that of the fit."""
    rows = [cells for _, cells in read.table("standard error")]
    assert [row["parameter"] for row in rows] == list(fit.problem.names)
    return [row["parameter"] for row in rows if float(row["value"]) != fit[row["parameter"]]]


def test_all_digits_are_those_of_the_fit(plain: Sample, poor: Sample) -> None:
    for one in (plain, poor):
        assert wrong_numbers(one.fit, page(one)) == []


def test_a_changed_digit_is_noticed(plain: Sample) -> None:
    number = repr(plain.fit["C_A"])
    assert wrong_numbers(plain.fit, Page(page(plain).text.replace(number, "1" + number))) == ["C_A"]


def test_the_table_of_parameters_shows_value_and_intervals(plain: Sample) -> None:
    rows = {cells["parameter"]: cells for _, cells in page(plain).table("95 % interval")}
    assert list(rows) == list(plain.fit.problem.names)
    for name, factor, zero in (("A_s", 1.0, 273.15), ("C_A", 1e6, 0.0), ("eps_L", 1.0, 0.0)):
        row = rows[name]
        digit = 10.0 ** -len(row["value"].partition(".")[2])
        found = plain.fit.uncertainty
        columns = {
            "value": (plain.fit[name],),
            "95 % interval": found.widen_interval(name),
            "if samples were independent": found.interval(name),
        }
        for column, numbers in columns.items():
            shown = [float(text) for text in row[column].split(" to ")]
            exact = [(number - zero) / factor for number in numbers]
            assert shown == pytest.approx(exact, abs=0.5001 * digit), (name, column)
        low, high = (float(text) for text in row["bounds"].split(" to "))
        free = plain.fit.problem.free[FREE.index(name)]
        assert (low, high) == pytest.approx(((free.low - zero) / factor, (free.high - zero) / factor), rel=1e-3)
    assert [rows[name]["unit"] for name in FREE] == ["°C", "MPa/K", ""]


def test_bounds_and_what_is_not_determined_are_in_the_table(poor: Sample) -> None:
    rows = {cells["parameter"]: cells for _, cells in page(poor).table("95 % interval")}
    assert rows["A_s"]["remark"] == "at a bound" and "at" not in rows["C_A"]["remark"]
    assert rows["heat_capacity"]["95 % interval"] == "not determined"


def test_errors_are_those_of_the_rows(plain: Sample) -> None:
    rows = page(plain).table("rms error")
    expected: list[tuple[str, str, float]] = []
    for one, fitted, used in zip(
        plain.fit.problem.experiments, plain.fit.evaluation.fitted_records, plain.fit.problem.training_rows, strict=True
    ):
        error = (fitted.model - one.measured)[:, 0]
        for kind, part in (("", used[:, 0]), ("held", np.isfinite(error) & ~used[:, 0])):
            if part.any():
                expected.append((one.name, kind, float(np.sqrt(np.mean(error[part] ** 2)))))
    (kept,) = plain.fit.held_out_records
    error = (kept.model - kept.experiment.measured)[:, 0]
    expected.append(("kept", "held", float(np.sqrt(np.mean(error**2)))))
    assert len(rows) == len(expected) == 5
    for (kind, cells), (name, expected_kind, size) in zip(rows, expected, strict=True):
        assert kind == expected_kind
        assert cells["record"] == name + ("held out" if kind else "")
        assert float(cells["rms error"].removesuffix(" %")) == pytest.approx(100 * size, rel=5e-3)


def test_records_have_their_hash_and_their_rows(plain: Sample) -> None:
    rows = {cells["record"]: (kind, cells) for kind, cells in page(plain).table("data")}
    for name, path in plain.files.items():
        cells = rows[name + ("held out" if name == "kept" else "")][1]
        assert hashlib.sha256(path.read_bytes()).hexdigest() in cells["data"]
        assert path.name in cells["data"]
    counts = {
        name: tuple(int(cells[key]) for key in ("rows", "fitted", "held out", "missing"))
        for name, (_, cells) in rows.items()
    }
    assert counts == {
        "light": (81, 81, 0, 0),
        "middle": (81, 70, 11, 0),
        "heavy": (81, 77, 0, 4),
        "keptheld out": (81, 0, 81, 0),
    }
    assert [name for name, (kind, _) in rows.items() if kind == "held"] == ["keptheld out"]
    assert "columns" in rows["heavy"][1]["data"]


# ---------------------------------------------------------------- what must be read first


def test_the_head_counts_the_warnings(poor: Sample) -> None:
    read = page(poor)
    assert "notice warning" in read.parts and re.search(r"[1-9] warnings? below", read.text)
    words = re.sub(r"<[^>]+>", "", read.text)
    assert "A_s ended on its upper bound, 59.85 °C" in words
    assert "heat_capacity is not determined" in words
    assert "offset.strain" in words and "E_A@" in words  # hardly told apart
    assert "in the held-out rows" in words


def test_a_good_fit_has_no_warning(plain: Sample) -> None:
    assert list_fit_warnings(plain.fit) == []
    read = page(plain)
    assert read.parts[0] == "notice"
    assert "No warnings." in read.text


def test_predictions_compare_what_was_seen_with_what_was_not(plain: Sample) -> None:
    rows = list_compared(plain.fit)
    seen, kept = compute_rms(rows, TRAINING), compute_rms(rows, HELD_OUT)
    errors = np.concatenate([one.residuals[one.training_rows] for one in rows])
    assert seen == pytest.approx(float(np.sqrt(np.mean(errors**2))), rel=1e-12)
    first, naive, own = describe_predictions(plain.fit)
    assert f"{100 * seen:.3g} % in the fitted rows" in first
    assert f"{100 * kept:.3g} % in the held-out rows" in first
    assert "without a model" in naive
    assert "% (mean of training)" in naive
    assert "`offset.strain`" in own
    assert math.isnan(compute_rms([rows[0]], HELD_OUT))


def warned(fit: Fit) -> str:
    return " ".join(list_fit_warnings(fit))


def test_what_was_not_kept_back_or_is_predicted_badly_is_said(plain: Sample) -> None:
    fit = plain.fit
    seen = tuple(replace(one, held_out_intervals=()) for one in fit.problem.experiments)
    problem = replace(fit.problem, experiments=seen)
    found = problem.evaluate(fit.values, slopes=True)
    assert found is not None
    nothing = replace(fit, held_out_records=(), problem=problem, evaluation=found)
    assert "No data were held out" in warned(nothing)
    (kept,) = fit.held_out_records
    off = replace(fit, held_out_records=(replace(kept, model=kept.model + 2e-3),))
    assert "`strain` is predicted worse than it is fitted" in warned(off)
    assert "kept (" not in warned(off)
    lost = replace(fit, held_out_records=(replace(kept, model=0.0 * kept.model),))
    assert "less than half of the variation: `strain` of kept (" in warned(lost)
    assert "did not converge: cap" in warned(replace(fit, reason="cap"))


def test_coloured_residuals_are_named(plain: Sample) -> None:
    fit = plain.fit
    first, *others = fit.evaluation.fitted_records
    wave = 1e-3 * np.sin(0.3 * np.arange(81))[:, None]
    coloured = replace(first, model=first.model + wave, residuals=first.residuals + wave / 0.04)
    evaluation = replace(fit.evaluation, fitted_records=(coloured, *others))
    assert "autocorrelated (`strain` of light)" in warned(replace(fit, evaluation=evaluation))


def test_covered_is_what_the_elements_went_through(plain: Sample) -> None:
    section = math.pi / 4 * 0.381e-3**2
    found = find_covered_range(plain.fit)
    assert found["stress"] == pytest.approx((0.6 * 9.80665 / section, 1.6 * 9.80665 / section))
    assert found["temperature"] == pytest.approx((293.15, 413.15), abs=0.5)


# ---------------------------------------------------------------- the page itself


def test_the_page_stands_alone(plain: Sample) -> None:
    read = page(plain)
    assert len(read.sources) == 7
    assert all(source.startswith("data:image/svg+xml;base64,") for source in read.sources)
    assert not re.search(r"""(src|href)=["'](?!data:|#)|@import|url\(""", read.text)
    assert set(re.findall(r'href="#([^"]+)"', read.text)) == set(read.ids)
    assert str(plain.folder) not in read.text


@pytest.mark.slow
def test_the_same_fit_gives_the_same_page(plain: Sample) -> None:
    assert page(plain).text == fresh(plain, "b.html", profiles=profiles(plain.fit)).text


def test_names_cannot_break_the_page(plain: Sample, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor a figure, of which one is drawn."""
    monkeypatch.setattr(html, "format_svg", lambda _: "<svg/>")
    first, *others = plain.fit.problem.experiments
    odd = replace(first, name="<b>$x_1$ & | 'y'")
    problem = replace(plain.fit.problem, experiments=(odd, *others))
    one = replace(plain, fit=replace(plain.fit, problem=problem))
    plot_fit(one.fit).draw_without_rendering()
    read = fresh(one, "odd.html", title="A <i>title</i>")
    assert "<b>" not in read.text and "<i>" not in read.text
    assert any(cells["record"] == odd.name for _, cells in read.table("data"))
    text = render_markdown(summarise_fit(one.fit), "by", "figures")
    assert r"'y'" in text and "& \\| 'y'" in text


def test_markdown_has_its_figures_beside_it(plain: Sample, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The figures are those of the page; here each is an empty file."""
    monkeypatch.setattr(pages, "write_figure", lambda _, place: place.touch())
    path, given = tmp_path / "my report.md", profiles(plain.fit)
    written = write_report(plain.fit, path, scenario=plain.scenario, profiles=given)
    assert written == list_page_files(summarise_fit(plain.fit, None, given), path)
    assert sorted(p for p in tmp_path.rglob("*") if p.is_file()) == sorted(written)
    text = path.read_text(encoding="utf-8")
    places = re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)
    assert [tmp_path / place.replace("%20", " ") for place in places] == written[1:]
    assert repr(plain.fit["A_s"]) in text and "kept **(held out)**" in text
    tables = [
        [line.replace("\\|", "").count("|") for line in block.splitlines()]
        for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    ]
    assert len(tables) == 5 and all(len(set(widths)) == 1 for widths in tables)


def test_no_report_is_left_where_none_can_be_written(plain: Sample, tmp_path: Path) -> None:
    for name, words in (("r.pdf", r"ends in \.html or \.md"), ("no/r.html", "does not exist")):
        with pytest.raises(InputError, match=words):
            write_report(plain.fit, tmp_path / name)
    (tmp_path / "r_figures").write_text("in the way", encoding="utf-8")
    with pytest.raises(InputError, match="Cannot make the folder"):
        write_report(plain.fit, tmp_path / "r.md")
    assert [path.name for path in tmp_path.iterdir()] == ["r_figures"]


# ---------------------------------------------------------------- figures


def panel(figure: Figure, title: str) -> Any:
    (found,) = [axes for axes in figure.axes if axes.get_title("left") == title]
    return found


def drawn(axes: Any, colour: str) -> Any:
    """Values of the line of a colour."""
    (line,) = [one for one in axes.lines if one.get_color() == colour and len(one.get_xdata()) > 2]
    return line.get_ydata()


def test_panels_show_measured_and_modelled_percent(plain: Sample) -> None:
    figure = plot_fit(plain.fit)
    rows = {one.record: one for one in list_compared(plain.fit)}
    for name, one in rows.items():
        axes = panel(figure, name)
        np.testing.assert_allclose(drawn(axes, SEEN), 100.0 * one.measured, rtol=1e-12)
    np.testing.assert_allclose(drawn(panel(figure, "light"), SIMULATED), 100 * rows["light"].model)
    np.testing.assert_allclose(drawn(panel(figure, "kept"), HELD), 100 * rows["kept"].model)


def test_what_was_held_out_is_drawn_apart(plain: Sample) -> None:
    figure = plot_fit(plain.fit)
    middle, times = panel(figure, "middle"), list_compared(plain.fit)[1].times
    assert np.isfinite(drawn(middle, HELD)).tolist() == (times >= 69.0).tolist()  # they meet
    assert np.isfinite(drawn(middle, SIMULATED)).tolist() == (times < 70.0).tolist()
    errors = {name: panel(figure, name).texts[0].get_text() for name in ("light", "kept")}
    assert "held out" in errors["kept"] and "held out" not in errors["light"]
    assert panel(figure, "kept").get_facecolor() != panel(figure, "light").get_facecolor()


def test_loops_run_over_the_measured_temperature(plain: Sample) -> None:
    axes = panel(plot_fit_loops(plain.fit), "light")
    (line,) = [one for one in axes.lines if one.get_color() == SIMULATED]
    record = plain.fit.problem.experiments[0].record
    np.testing.assert_allclose(line.get_xdata(), np.asarray(record["temperature"]) - 273.15)
    without = replace(record, columns={k: record[k] for k in ("time", "strain")}, units={"time": "s", "strain": "1"})
    first = replace(plain.fit.problem.experiments[0], record=without)
    problem = replace(plain.fit.problem, experiments=(first,))
    alone = replace(
        plain.fit,
        problem=problem,
        held_out_records=(),
        evaluation=replace(plain.fit.evaluation, fitted_records=plain.fit.evaluation.fitted_records[:1]),
    )
    with pytest.raises(InputError, match="no loop to draw"):
        plot_fit_loops(alone)


def test_residuals_and_their_memory_are_those_of_the_fit(plain: Sample) -> None:
    figure = plot_fit_residuals(plain.fit)
    one = list_compared(plain.fit)[2]
    np.testing.assert_allclose(drawn(panel(figure, "heavy"), SIMULATED), 100 * one.residuals)
    everything: list[Any] = list(figure.axes)
    tests = [axes for axes in everything if axes.get_ylabel() == "autocorrelation"]
    for axes, test in zip(tests, plain.fit.whiteness, strict=True):
        (stems,) = [c for c in axes.collections if len(c.get_paths()) == len(test.autocorrelation)]
        tops = [path.vertices[1, 1] for path in stems.get_paths()]
        np.testing.assert_allclose(tops, test.autocorrelation)


def test_correlations_are_printed_once_each(plain: Sample) -> None:
    axes = plot_correlation(plain.fit).axes[0]
    printed = {(round(t.get_position()[0]), round(t.get_position()[1])): float(t.get_text()) for t in axes.texts}
    matrix = plain.fit.uncertainty.correlation
    count = len(matrix)
    assert len(printed) == count * (count - 1) // 2
    for (column, row), value in printed.items():
        assert column < row and value == pytest.approx(matrix[row][column], abs=0.0051)


def test_singular_values_and_the_weakest_direction(plain: Sample, poor: Sample) -> None:
    axes: list[Any] = plot_singular_values(plain.fit).axes
    left, right = axes
    (line,) = [one for one in left.lines if len(one.get_xdata()) == len(plain.fit.values)]
    expected = [1.0 / u for u in plain.fit.identifiability.uncertainties]
    np.testing.assert_allclose(line.get_ydata(), expected)
    vector = np.linalg.svd(plain.fit.evaluation.jacobian, full_matrices=False)[2][-1]
    bars = [abs(bar.get_width()) for bar in right.patches]
    np.testing.assert_allclose(bars, sorted(np.abs(vector), reverse=True)[: len(bars)])
    _, right = plot_singular_values(poor.fit).axes
    assert [label.get_text() for label in right.get_yticklabels()] == ["heat_capacity"]
    assert "not determined" in right.get_title("left")


def test_the_search_and_the_profiles_are_drawn_as_they_were(plain: Sample) -> None:
    axes: Any = plot_search(plain.fit).axes[0]
    marks = next(line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_allclose(np.transpose(marks.get_data()), plain.fit.history)
    figure = plot_likelihood(profiles(plain.fit), plain.fit)
    panels: list[Any] = figure.axes
    first, second = panels[:2]
    marks = next(line for line in first.lines if line.get_marker() == "o")
    steps = np.linspace(-2.2, 2.2, 9)
    np.testing.assert_allclose(marks.get_ydata(), steps**2 / 4.0)
    error = plain.fit.uncertainty.errors[0]
    np.testing.assert_allclose(marks.get_xdata(), plain.fit["A_s"] + steps * error - 273.15)
    assert second.get_title("right") == "open above"
    (curve,) = [line for line in first.lines if line.get_label() == "from the Jacobian"]
    x, y = curve.get_data()
    cost = ((x + 273.15 - plain.fit["A_s"]) / error * plain.fit.uncertainty.noise) ** 2
    seen = np.isfinite(y)
    assert seen.any()
    np.testing.assert_allclose(y[seen], cost[seen] / 4.0, rtol=1e-9, atol=1e-12)
    with pytest.raises(InputError, match="no profile likelihood"):
        plot_likelihood([])


DRAWN: dict[str, Callable[[Fit], Figure]] = {
    "measured": plot_fit,
    "loops": plot_fit_loops,
    "residuals": plot_fit_residuals,
    "correlations": plot_correlation,
    "directions": plot_singular_values,
    "search": plot_search,
    "likelihoods": lambda fit: plot_likelihood(profiles(fit), fit),
}


def long_names(fit: Fit) -> Fit:
    """The same fit to records of long names."""
    names = {
        one.name: f"measurement_of_the_wire_{one.name}_on_the_third_of_May"
        for one in [*fit.problem.experiments, *(kept.experiment for kept in fit.held_out_records)]
    }
    seen = tuple(replace(one, name=names[one.name]) for one in fit.problem.experiments)
    free = tuple(
        replace(one, record=names[one.record], name=f"{one.path}@{names[one.record]}") if one.record else one
        for one in fit.problem.free
    )
    kept = tuple(
        replace(one, experiment=replace(one.experiment, name=names[one.experiment.name]))
        for one in fit.held_out_records
    )
    problem = replace(fit.problem, experiments=seen, free=free)
    return replace(fit, problem=problem, held_out_records=kept)


@pytest.mark.parametrize("name", DRAWN)
def test_no_text_covers_another_or_leaves_the_page(name: str, plain: Sample, poor: Sample) -> None:
    for fit in (poor.fit, long_names(plain.fit)):
        figure = DRAWN[name](fit)
        figure.draw_without_rendering()
        check_apart(figure, visible_texts(figure))


def test_a_text_over_another_is_noticed(plain: Sample) -> None:
    figure = plot_fit(plain.fit)
    text = panel(figure, "light").texts[0]
    text.set_text(text.get_text() + 40 * " wide")
    figure.draw_without_rendering()
    with pytest.raises(AssertionError):
        check_apart(figure, visible_texts(figure))
