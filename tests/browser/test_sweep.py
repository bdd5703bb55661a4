"""Sweeps in a browser: begun, seen while they come, cancelled, gone on with, looked at."""

import base64
import json
import re
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from playwright.sync_api import Browser, Page, expect

from martensite.cli.commands.web_bench import pack_text
from martensite.scenario.scenario import read_scenario

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
SHORT = TEXT.replace('duration = "10 s"', 'duration = "2 s"\nsamples = 41')


SHORT_PLACE = f"bench?scenario={pack_text(SHORT)}"


@pytest.fixture
def place() -> str:
    return SHORT_PLACE


def unpack_link(letters: str) -> str:
    """The scenario in the letters of an address."""
    data = zlib.decompress(base64.urlsafe_b64decode(letters + "=" * (-len(letters) % 4)))
    return json.loads(data)["text"]


STORED: dict[str, Any] = {
    "text": SHORT.replace("Constant power", "Ready power"),
    "sample": "grid",
    "runtime": "floats",
    "over": ["A_s=60..90 degC:6", "high=0.3..0.6 W:5"],
    "measures": ["stroke", "max(temperature)"],
    "step": "50 ms",
}


@pytest.fixture(scope="module")
def ready(bench: Bench) -> str:
    """Key of a sweep that is there, in which some runs are refused."""
    with bench.client("tab-of-others") as client:
        job = client.post("/api/jobs", json={"call": "sweep", "request": STORED}).json()
        for _ in range(600):
            (now,) = [one for one in client.get("/api/jobs").json() if one["id"] == job["id"]]
            if now["state"] != "running":
                break
            time.sleep(0.05)
    assert now["state"] == "done", now
    return now["last"]["key"]


@pytest.fixture
def other(chromium: Browser, bench: Bench) -> Iterator[Page]:
    """A second tab, of another window."""
    context = chromium.new_context()
    made = context.new_page()
    made.goto(bench.address)
    yield made
    context.close()


def ask(page: Page, bench: Bench, levels: tuple[str, str]) -> None:
    """Fill the form for two axes of a short scenario, which it takes from the bench."""
    if "scenario=" not in page.url:
        page.goto(f"{bench.address}#/{SHORT_PLACE}")
    expect(page.get_by_text("41 samples")).to_be_attached()
    page.goto(f"{bench.origin}/#/sweep")
    for words, name in (("diam", "element.diameter"), ("high", "drive.waveform.high")):
        page.get_by_label("Add a parameter to vary").fill(words)
        page.get_by_role("listbox", name="Parameters of the scenario").get_by_role("option", name=name).first.click()
    for axis, count in zip(("element.diameter", "drive.waveform.high"), levels, strict=True):
        page.get_by_role("group", name=axis).get_by_label("Levels").fill(count)
    page.get_by_text("How it is run").click()
    page.get_by_label("Runtime").select_option("floats")
    page.get_by_label("Processes").fill("1")
    page.get_by_label("Longest step").fill("50 ms")


def start(page: Page) -> None:
    button = page.get_by_role("button", name="Start", exact=True)
    expect(button).to_be_enabled()
    button.click()


def filled(page: Page) -> float:
    """Share of the picture's frame that is filled."""
    return page.evaluate(
        """() => {
          const canvas = document.querySelector(".sweep-canvas canvas");
          const over = document.querySelector(".sweep-canvas .chart-over");
          const size = [canvas.width, canvas.height];
          const pen = new OffscreenCanvas(...size).getContext("2d", { willReadFrequently: true });
          pen.drawImage(canvas, 0, 0);
          const [left, top, w, h] = ["left", "top", "width", "height"]
            .map(side => parseFloat(over.style[side]) * devicePixelRatio);
          const data = pen.getImageData(left + 1, top + 1, w - 2, h - 2).data;
          let filled = 0;
          for (let k = 0; k < data.length; k += 4) filled += data[k + 3] > 0 ? 1 : 0;
          return (4 * filled) / data.length;
        }"""
    )


def test_a_map_is_made_and_a_run_opens_in_the_bench(page: Page, bench: Bench) -> None:
    ask(page, bench, ("6", "5"))
    expect(page.get_by_text("30 runs", exact=True)).to_be_visible()
    start(page)
    expect(page.get_by_text(re.compile("^30 runs are there"))).to_be_visible()
    picture = page.get_by_role("application", name=re.compile("Map of stroke"))
    expect(picture).to_be_visible()
    assert filled(page) > 0.95
    picture.focus()
    for key in ("ArrowRight", "ArrowRight", "ArrowRight", "ArrowUp"):
        picture.press(key)
    expect(page.get_by_label("Run 11")).to_contain_text("0.096 mmhigh0.405 W")
    picture.press("Enter")
    expect(page).to_have_url(re.compile(r"#/bench\?scenario="))
    page.wait_for_function("() => location.hash.length > 100")
    expect(page.locator(".measures")).to_be_visible()
    letters = re.search(r"scenario=([\w-]+)", page.url)
    scenario = read_scenario(unpack_link(letters[1] if letters else ""))
    spread = (0.08 + 0.04 * 2 / 5) * 1e-3
    assert scenario.single_system.value_of("element.diameter") == pytest.approx(spread, rel=1e-12)
    assert scenario.single_waveform.value_of("high") == pytest.approx(0.405, rel=1e-12)


@pytest.mark.slow  # jobs are cancelled and found again in tests/app, reloads are walked in test_session
def test_reload_cancel_resume_delete(page: Page, bench: Bench) -> None:
    ask(page, bench, ("100", "60"))
    start(page)
    done = page.get_by_text(re.compile(r"^[1-9][\d,]* of 6,000 runs"))
    expect(done).to_be_visible()
    page.reload()
    expect(done).to_be_visible()
    expect(page.get_by_role("application")).to_be_visible()
    expect(page.get_by_label("Longest step")).to_have_value("50 ms")
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_text(re.compile("They are kept|What was made is kept"))).to_be_visible()
    assert 0.0 < filled(page) < 0.9
    row = page.get_by_role("row", name=re.compile("mm:100"))
    expect(row).to_contain_text("stopped")
    row.get_by_role("button", name="Resume").click()
    expect(page.get_by_role("button", name="Cancel")).to_be_visible()
    expect(done).to_be_visible()
    page.get_by_role("button", name="Cancel").click()
    row.get_by_role("button", name="Delete").click()
    row.get_by_role("button", name="Delete", exact=True).click()
    expect(row).to_have_count(0)


@pytest.mark.slow  # sessions of tabs are kept apart in test_session
def test_two_tabs_do_not_disturb_each_other(page: Page, other: Page, bench: Bench) -> None:
    ask(page, bench, ("4", "5"))
    ask(other, bench, ("3", "4"))
    start(page)
    start(other)
    for tab, count, axes in ((page, 20, "mm:4; "), (other, 12, "mm:3; ")):
        expect(tab.get_by_text(re.compile(f"^{count} runs are there"))).to_be_visible()
        shown = tab.get_by_role("heading", level=1).locator("xpath=following-sibling::p")
        expect(shown).to_contain_text(axes)


@pytest.mark.slow
def test_what_is_wrong_stands_beside_its_field(page: Page, bench: Bench) -> None:
    ask(page, bench, ("6", "5"))
    axis = page.get_by_role("group", name="element.diameter")
    axis.get_by_label("From").fill("0.2")
    expect(axis.get_by_role("alert")).to_contain_text("must rise")
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_disabled()
    axis.get_by_label("From").fill("0.1")
    expect(axis.get_by_role("alert")).to_have_count(0)
    axis.get_by_label("Tolerance").check()
    expect(axis.get_by_role("alert")).to_contain_text("no levels")
    page.get_by_role("combobox", name="Sample").select_option("sobol")
    page.get_by_label("Number", exact=True).fill("32")
    expect(page.get_by_text("32 runs", exact=True)).to_be_visible()


@pytest.mark.slow
def test_a_kept_sweep_is_looked_at(page: Page, bench: Bench, ready: str) -> None:
    page.goto(f"{bench.origin}/#/sweep")
    page.get_by_role("button", name=re.compile("Open Ready power")).click()
    expect(page.get_by_text("hatched: failed")).to_be_visible()
    page.get_by_role("button", name="Curve").click()
    expect(page.get_by_role("application", name=re.compile("Curve of stroke"))).to_be_visible()
    page.get_by_role("button", name="Pareto front").click()
    expect(page.get_by_role("region", name=re.compile(r"Front: \d+ of \d+ runs"))).to_be_visible()
    page.get_by_text("Take away").click()
    expect(page.get_by_text(re.compile("^martensite sweep ready-power"))).to_be_visible()
    with page.expect_download() as taken:
        page.get_by_role("button", name="Table").click()
    lines = taken.value.path().read_text("utf-8").splitlines()
    assert len(lines) == 31 and "refused" in "".join(lines)
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Ready power")


@pytest.mark.slow
@pytest.mark.parametrize(("design", "number", "count"), [("latin-hypercube", "24", 24), ("saltelli", "16", 64)])
def test_a_sample_is_run_and_looked_at(page: Page, bench: Bench, design: str, number: str, count: int) -> None:
    ask(page, bench, ("6", "5"))
    page.get_by_role("combobox", name="Sample").select_option(design)
    page.get_by_label("Number", exact=True).fill(number)
    expect(page.get_by_text(f"{count} runs", exact=True)).to_be_visible()
    start(page)
    expect(page.get_by_text(re.compile(f"^{count} runs are there"))).to_be_visible()
    expect(page.get_by_role("application", name=re.compile("stroke over diameter"))).to_be_visible()
    page.get_by_role("button", name="Sensitivity").click()
    expect(page.get_by_role("button", name="Compute the indices")).to_be_visible()
