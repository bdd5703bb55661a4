"""The page Identify in a browser: from a file to a fitted material."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from fit_cases import HEATED, TRUTH, cycle, heated, measured, read_rows, repeated, write_log, write_rows
from playwright.sync_api import Page, expect

SCENARIO = (Path(__file__).parents[2] / "examples/isobaric_log.toml").read_text("utf-8")
HEADINGS = ["Time_s", "T (C)", "sigma [MPa]", "Strain %", "<img src=x onerror=alert(1)>"]
SLOW = ["h", "A_s", "A_f", "M_s", "M_f", "C_A", "C_M"]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """An isobaric cycle with headings of somebody else, and a formula in it."""
    path = tmp_path / "cycle.csv"
    write_log(measured(cycle(), SCENARIO, ["strain"], TRUTH, 0.01), path)
    rows = read_rows(str(path))[1:]
    write_rows(path, [HEADINGS, *([*row, "=cmd()"] for row in rows)])
    return path


@pytest.fixture
def place() -> str:
    return "identify"


def choose(page: Page, path: Path) -> None:
    page.get_by_label(re.compile("^Drop (a log|logs) here")).set_input_files(str(path))


def step(page: Page, name: str) -> None:
    page.get_by_role("button", name=f"Next: {name}").click()


def free(page: Page, *names: str) -> None:
    for name in names:
        page.get_by_role("checkbox", name=name, exact=True).check()


def test_a_log_becomes_a_material(page: Page, log: Path) -> None:
    choose(page, log)
    for heading, name, unit in zip(
        HEADINGS, ("time", "temperature", "stress", "strain"), ("s", "degC", "MPa", "%"), strict=False
    ):
        expect(page.get_by_label(f"Meaning of {heading}")).to_have_value(name)
        expect(page.get_by_label(f"Unit of {heading}")).to_have_value(unit)
    step(page, "records")
    expect(page.get_by_label("temperature over time, with the records shaded")).to_be_visible()
    step(page, "scenario")
    page.get_by_label("Scenario").first.select_option("isobaric_log")
    free(page, "A_s", "A_f")
    page.get_by_role("button", name="Fit 2 parameters").click()
    told = page.get_by_role("region", name="Parameters, with intervals of 95 %")
    expect(told).to_contain_text("A_s")
    expect(page.get_by_text("All free parameters are determined")).to_be_visible()
    values = re.findall(r"([\d.]+) °C", told.inner_text())
    assert [float(x) for x in values] == pytest.approx([72.0, 84.0], abs=0.5)
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the material").click()
    assert saved.value.suggested_filename == "cycle.toml"
    material = tomllib.loads(saved.value.path().read_text("utf-8"))
    assert material["values"]["A_s"]["kind"] == "fitted"
    assert material["fit"]["records"][0]["file"] == "cycle.csv"


def test_a_sample_becomes_a_material_in_three_clicks(page: Page, clicks: Callable[[], int]) -> None:
    """A door, the four loops, fit; what is drawn and said on the way."""
    page.get_by_role("link", name="I have a log").click()
    page.get_by_role("button", name="Use four measured loops").click()
    expect(page.get_by_label("strain of all records over temperature")).to_be_visible()
    expect(page.get_by_role("status").filter(has_text="needs none: a slow loop")).to_be_visible()
    page.get_by_role("button", name="Fit a model to these 4 logs").click()
    verdict = page.get_by_role("region", name="Verdict")
    expect(verdict).to_contain_text("for the naive baseline (neighbouring loads)")
    expect(verdict).to_contain_text("A loop at 150 MPa, in the widest gap")
    assert clicks() <= 3
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the material").click()
    assert len(tomllib.loads(saved.value.path().read_text("utf-8"))["fit"]["records"]) == 4


def test_a_step_is_drawn_said_and_undone(page: Page) -> None:
    page.get_by_role("button", name="Use one").click()
    step(page, "records")
    page.get_by_label("Column of the step").select_option("stress")
    page.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("median of 5 rows; at most")).to_be_visible()
    page.get_by_role("button", name="Undo step 1").click()
    expect(page.get_by_text("Preparation of the log: none")).to_be_visible()
    page.get_by_role("combobox", name="Step", exact=True).select_option("cut")
    page.get_by_label("kept to [s]").fill("99")
    page.get_by_label("kept to [s]").press("Tab")
    page.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("Rows from 0 s to 99 s: 100 of 499")).to_be_visible()


def test_files_are_shown_as_text_or_refused(page: Page, log: Path, tmp_path: Path) -> None:
    choose(page, log)
    page.get_by_text("First 20 rows").click()
    shown = page.get_by_role("region", name="First rows of the file")
    expect(shown.get_by_role("columnheader").last).to_have_text(HEADINGS[-1])
    expect(shown.get_by_role("cell", name="=cmd()", exact=True).first).to_be_visible()
    assert shown.locator("img").count() == 0
    page.get_by_label("Unit of T (C)").fill("bar")
    page.get_by_label("Unit of T (C)").press("Tab")
    step(page, "records")
    expect(page.get_by_role("alert")).to_contain_text("unit bar cannot be converted to K")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)) * 8)
    choose(page, binary)
    expect(page.get_by_role("alert")).to_contain_text("not a text file")


@pytest.mark.slow
def test_records_are_cut_with_the_keyboard(page: Page, log: Path) -> None:
    choose(page, log)
    step(page, "records")
    handle = page.get_by_label("cycle: to", exact=True)
    handle.focus()
    handle.press("Home")
    expect(page.get_by_label("to [s]")).to_have_value("0.12")
    expect(page.get_by_role("status").filter(has_text="has 1 rows")).to_be_visible()
    expect(page.get_by_role("button", name="Next: scenario")).to_be_disabled()
    page.get_by_label("to [s]").fill("60")
    page.get_by_label("to [s]").press("Tab")
    expect(page.get_by_text("61 rows")).to_be_visible()
    page.get_by_role("button", name="Add a record").click()
    expect(page.get_by_label("from [s]").last).to_have_value("60")
    expect(page.get_by_text("61 rows").last).to_be_visible()


def test_a_fit_goes_on_over_a_reload_and_is_stopped_and_kept(page: Page, tmp_path: Path) -> None:
    log, scenario = tmp_path / "pulse.csv", tmp_path / "heated.toml"
    write_log(repeated(heated(), 8), log)
    scenario.write_text(HEATED, encoding="utf-8")
    choose(page, log)
    step(page, "records")
    step(page, "scenario")
    page.get_by_label("or a file (TOML)").set_input_files(str(scenario))
    free(page, *SLOW)
    page.get_by_label("Method").select_option("coordinate")
    page.get_by_role("button", name=f"Fit {len(SLOW)} parameters").click()
    working = page.get_by_role("status").filter(has_text="coordinate search")
    expect(working).to_be_visible()
    page.reload()
    expect(working).to_be_visible()
    expect(page.get_by_label(re.compile("of pulse, measured and modelled")).first).to_be_visible()
    page.get_by_role("button", name="Stop and keep the best").click()
    open_sets = page.get_by_role("region", name="Parameters that the data do not determine")
    expect(open_sets).to_be_visible()
    expect(page.get_by_text("The search did not converge: interrupted.").first).to_be_visible()
    expect(page.get_by_role("button", name="Continue the search")).to_be_visible()
