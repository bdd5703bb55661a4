"""`martensite fit h`: what is read, printed and written, and one sentence on bad input.

Source of truth: the options and columns as documented, the fits of `martensite.identify` (which
are tested against other code), and the simulator, which must take the model that is written.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest
from command import Command

from martensite.actuators.assembly import System
from martensite.characterise.film_coefficient import FORMS, FilmPoints
from martensite.characterise.film_report import judge_film
from martensite.scenario.scenario import read_scenario
from martensite.show.figures.laboratory import plot_film

EXAMPLES = Path(__file__).parents[2] / "examples"
MIGAONE = str(EXAMPLES / "migaone_table2.csv")
KOSSOSKI = str(EXAMPLES / "kossoski_table2.csv")
WIRE = ("--diameter", "0.375 mm", "--length", "100 mm", "--ambient", "22 degC")
AMBIENT = ("--ambient", "38.5 degC")
FIT = Command("fit", "h")
fine, report, refused = FIT.fine, FIT.report, FIT.refused


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(text: str) -> str:
    Path("table.csv").write_text(text, encoding="utf-8")
    return "table.csv"


# ---------------------------------------------------------------- the two papers


def test_migaone() -> None:
    text = fine(MIGAONE, *AMBIENT)
    for number in ("42.657 ± 5.3", "0.0028836 ± 0.00086", "0.98812", "28.263 ± 12", "0.982"):
        assert number in text
    assert "65.8, 61.1, 61.9, 68.1" in text
    assert "Curvature is not supported" in text
    assert "rests on the ambient temperature" in text
    assert "do not determine the ambient" in text


def test_the_example_is_the_studys_table() -> None:
    from martensite.studies.tables import printed_numbers

    found, steps = report(MIGAONE, *AMBIENT)["points"], printed_numbers("migaone").steps
    assert found["temperatures_degC"] == pytest.approx(steps.column("temperature"))
    assert found["h"] == pytest.approx(steps.column("film"))
    found = report(KOSSOSKI, *WIRE, "--resistance", "1 ohm")["points"]
    rows, surface = printed_numbers("wire_heating").rows, math.pi * 375e-6 * 0.1
    assert found["temperatures_degC"] == pytest.approx(rows.column("temperature"))
    expected = [row.voltage**2 / surface / (row.temperature - 22.0) for row in rows]
    assert found["h"] == pytest.approx(expected)


def test_kossoski() -> None:
    text = fine(KOSSOSKI, *WIRE, "--resistance", "1.304 ohm")
    assert "column `voltage` and 1.304 ohm" in text
    assert "Curvature is not supported" in text
    assert "A slope of h is not supported" in text
    assert "do not determine the ambient" in text


# ---------------------------------------------------------------- columns


@pytest.mark.parametrize(
    ("heading", "rows", "options"),
    [
        ("temperature [degC],power [mW]", ("50,100", "60,200", "80,500"), ()),
        ("temperature [K],voltage [V],current [A]", ("323.15,0.2,0.5", "333.15,0.4,0.5", "353.15,0.5,1"), ()),
        ("temperature [degC],voltage [V],resistance [ohm]", ("50,1,10", "60,2,20", "80,3,18"), ()),
        ("temperature [degC],voltage [V]", ("50,1", "60,1.41421356", "80,2.23606798"), ("--resistance", "10 ohm")),
    ],
)
def test_every_kind_of_column_gives_the_same_points(
    heading: str, rows: tuple[str, ...], options: tuple[str, ...]
) -> None:
    path = table("\n".join([heading, *rows]))
    wire = ("--diameter", "1 mm", "--length", "10 cm", "--ambient", "20 degC")
    found = report(path, *wire, *options)
    surface = math.pi * 1e-3 * 0.1
    expected = [0.1 / surface / 30.0, 0.2 / surface / 40.0, 0.5 / surface / 60.0]
    assert found["points"]["h"] == pytest.approx(expected, rel=1e-7)


def test_h_without_an_ambient() -> None:
    text = fine(MIGAONE)
    assert "ambient temperature behind h is not given" in text
    assert report(MIGAONE)["ambient"] is None


# ---------------------------------------------------------------- what is written


@pytest.mark.parametrize("form", FORMS)
def test_the_model_written_is_the_fit_and_can_be_simulated_with(form: str) -> None:
    text = fine(MIGAONE, *AMBIENT, "--form", form, "--out", "cooling.toml")
    assert "wrote cooling.toml" in text
    written = Path("cooling.toml").read_text(encoding="utf-8")
    assert "4 points of migaone_table2.csv" in written
    assert "rests on the ambient" in written.replace("\n# ", " ")
    assert max(map(len, written.splitlines()[:-2])) <= 100
    cooling = tomllib.loads(written)["environment"]["cooling"]
    assert cooling["kind"] == ("constant" if form == "constant" else "polynomial")
    scenario = (
        'title = "t"\n[element]\nkind = "wire"\nmaterial = "migaone-15"\n'
        'law = { kind = "liang-rogers", modulus = "mixture" }\n'
        'diameter = "0.381 mm"\nlength = "273 mm"\n'
        + written
        + '[mechanism]\nkind = "dead-weight"\nmass = "400 g"\n[drive]\nkind = "power"\n'
        'waveform = { kind = "constant", level = "1 W" }\n[run]\nduration = "10 s"\n'
    )
    system = read_scenario(scenario).system
    assert isinstance(system, System)
    fit = judge_film(FilmPoints((47.65, 57.5, 72.0, 87.0), (47.83, 53.07, 57.28, 64.55), 38.5)).fits[form]
    leaves = {leaf.path.rpartition(".")[2]: leaf.value for leaf in system.leaves()}
    names = ("h",) if form == "constant" else ("h0", "h1", "h2")
    for name, value in zip(names, fit.coefficients, strict=False):
        assert leaves[name] == pytest.approx(value, rel=1e-6)


def test_figure_and_json(folder: Path) -> None:
    found = report(MIGAONE, *AMBIENT, "--figure", "fit.png", "--form", "linear")
    assert found["files"] == ["fit.png"]
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    assert found["fits"]["linear"]["r_squared"] == pytest.approx(0.98812, abs=6e-6)
    assert found["fits"]["linear"]["intervals"]["1"] == pytest.approx([0.2621, 0.5665], abs=1e-3)
    assert [verdict["supported"] for verdict in found["verdicts"]] == [False] * 3
    assert found["fits"]["linear"]["aicc"] is None  # too few points for it
    assert "replace it" in refused(MIGAONE, "--figure", "fit.png")
    assert "wrote fit.png" in fine(MIGAONE, "--figure", "fit.png", "--force")


def test_what_the_figure_shows() -> None:
    points = FilmPoints((47.65, 57.5, 72.0, 87.0), (47.83, 53.07, 57.28, 64.55), 38.5)
    left, right = plot_film(judge_film(points)).axes
    legend = left.get_legend()
    assert legend is not None
    names = [text.get_text() for text in legend.get_texts()]
    assert [name.partition(":")[0] for name in names] == [*FORMS, "points"]
    assert len(left.collections) == 2  # bands of the line and of the parabola
    shown = {line.get_label(): line.get_ydata() for line in right.lines}
    assert shown["41 °C (+2.5 K)"] == pytest.approx([65.8, 61.1, 61.9, 68.1], abs=0.05)
    (alone,) = plot_film(judge_film(FilmPoints((40.0, 50.0, 60.0), (5.0, 6.0, 6.5))), ["linear"]).axes
    assert len(alone.collections) == 1


# ---------------------------------------------------------------- bad input


def test_bad_options() -> None:
    assert "give --form" in refused(MIGAONE, "--out", "c.toml")
    assert "No form of h(T) named `cubic`" in refused(MIGAONE, "--form", "cubic")
    assert "`--resistance` has no effect" in refused(MIGAONE, "--resistance", "2.7 ohm")
    assert "`--diameter` has no effect" in refused(MIGAONE, "--diameter", "0.381 mm")
    assert "`--resistance` is needed" in refused(KOSSOSKI, *WIRE)
    assert "`--ambient` is needed" in refused(KOSSOSKI, *WIRE[:4], "--resistance", "1 ohm")
    assert "below the coldest point" in refused(MIGAONE, "--ambient", "50 degC")
    assert "has no unit" in refused(MIGAONE, "--ambient", "38.5")
    assert "must end in .toml" in refused(MIGAONE, "--form", "linear", "--out", "c.csv")
    assert "There is no file `absent.csv`" in refused("absent.csv")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("power [W]\n1\n2\n", "no column `temperature`"),
        ("temperature [degC],force [N]\n50,1\n60,2\n", "needs a column `h`, `power` or `voltage`"),
        ("temperature [degC],h [W]\n50,1\n60,2\n", "must be in W/(m² K)"),
        ("temperature [degC],h [W/m^2/K]\n50,50\n", "at least 2 points"),
        ("temperature [degC],h [W/m^2/K]\n50,50\n60,-1\n", "above 0"),
    ],
)
def test_bad_tables(text: str, sentence: str) -> None:
    assert sentence in refused(table(text))


def test_too_few_points_for_a_form() -> None:
    path = table("temperature [degC],h [W/m^2/K]\n50,50\n60,51\n")
    assert "do not determine the form `quadratic`" in refused(path, "--form", "quadratic")


def test_a_fit_that_the_model_does_not_allow_is_not_written() -> None:
    path = table("temperature [degC],h [W/m^2/K]\n50,10\n60,30\n70,50\n")
    assert "h0" in refused(path, "--form", "linear", "--out", "c.toml")
    assert not Path("c.toml").exists()
