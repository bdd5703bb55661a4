"""The session of the page: nothing is lost by a reload, another page, a cut link or the end of the server."""

import json
import re
from pathlib import Path

import pytest
from app_server import Bench
from playwright.sync_api import Browser, Page, expect
from session_walk import walking

LOG = "time (s),power (W),temperature (degC)\n" + "".join(f"{k},{k % 2},{20 + k}\n" for k in range(20))
LARGEST_REPORT = 300_000


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "mine.csv"
    path.write_text(LOG)
    return path


def set_length(page: Page, value: str) -> None:
    field = page.get_by_label("Length", exact=True)
    expect(field).to_have_value(re.compile(r"\d"))
    field.fill(value)
    field.press("Enter")
    expect(page.get_by_role("button", name="Undo")).to_be_enabled()


def test_nothing_is_lost_on_a_walk_with_a_dying_server(chromium: Browser, tmp_path: Path, log: Path) -> None:
    with walking(chromium, tmp_path, log, seed=1) as walk:
        walk.walk(20, restarts=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_nothing_is_lost_on_a_long_walk(chromium: Browser, tmp_path: Path, log: Path, seed: int) -> None:
    with walking(chromium, tmp_path, log, seed) as walk:
        walk.walk(200, restarts=4)


def test_tabs_do_not_go_over_each_other(page: Page) -> None:
    """A new tab begins with the last one; then each has its own, a copied one too."""
    set_length(page, "150")
    page.wait_for_timeout(500)
    other = page.context.new_page()
    other.goto(page.url.partition("#")[0])
    expect(other.get_by_label("Length", exact=True)).to_have_value("150")
    set_length(other, "170")
    page.evaluate("open(location.href)")  # the browser copies what the tab remembers
    page.wait_for_timeout(500)
    copied = page.context.pages[-1]
    expect(copied.get_by_label("Length", exact=True)).to_have_value("150")
    set_length(copied, "190")
    for tab, length in ((page, "150"), (other, "170"), (copied, "190")):
        tab.wait_for_timeout(400)
        tab.reload()
        expect(tab.get_by_label("Length", exact=True)).to_have_value(length)


def test_a_project_is_one_file_that_opens_when_it_is_dropped(page: Page, tmp_path: Path, log: Path) -> None:
    set_length(page, "150")
    page.get_by_role("button", name="Pin this run").click()
    page.locator(".project summary").click()
    page.get_by_label("Notes").fill("as measured in May")
    page.keyboard.press("Escape")
    page.goto(page.url.partition("#")[0] + "#/identify")
    page.get_by_label(re.compile("^Drop (a log|logs) here")).set_input_files(str(log))
    expect(page.get_by_role("heading", level=2)).to_contain_text(log.name)
    page.locator(".project summary").click()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save as a file").click()
    assert saved.value.suggested_filename == "Constant power by PWM_ 0.1 mm wire.martensite"
    text = saved.value.path().read_text("utf-8")
    page.get_by_title("The present session stays in the list of earlier sessions").click()
    expect(page.get_by_label("Length", exact=True)).to_have_value("250")
    drop(page, "mine.martensite", text)
    expect(page.get_by_role("heading", level=2)).to_contain_text(log.name)
    page.get_by_role("link", name="Bench").click()
    expect(page.get_by_label("Length", exact=True)).to_have_value("150")
    expect(page.get_by_label("Name of pinned run 1")).to_be_visible()
    page.locator(".project summary").click()
    expect(page.get_by_label("Notes")).to_have_value("as measured in May")
    for name, content, said in (
        ("cut.martensite", text[:-9], "“cut.martensite” is cut or damaged"),
        ("none.martensite", "[element]", "“none.martensite” is no project of martensite."),
        ("mine.csv", LOG, "“mine.csv” is no project (.martensite)"),
        ("new.martensite", json.dumps({**json.loads(text), "version": 9}), "newer version"),
    ):
        drop(page, name, content)
        expect(page.locator(".project-fault")).to_contain_text(said)
    expect(page.get_by_label("Length", exact=True)).to_have_value("150")


def drop(page: Page, name: str, content: str) -> None:
    """Let a file fall onto the page."""
    page.evaluate(
        """([name, content]) => {
            const data = new DataTransfer();
            data.items.add(new File([content], name));
            const how = { dataTransfer: data, bubbles: true, cancelable: true };
            document.querySelector("header").dispatchEvent(new DragEvent("drop", how));
        }""",
        [name, content],
    )


def test_a_report_is_one_file_that_answers_and_asks_nobody(page: Page, bench: Bench, tmp_path: Path) -> None:
    page.get_by_role("button", name="Pin this run").click()
    set_length(page, "150")
    page.locator("summary", has_text="Export").click()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Live report, HTML").click()
    path = tmp_path / "report.html"
    saved.value.save_as(path)
    assert path.stat().st_size < LARGEST_REPORT
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    expect(page.get_by_role("heading", level=1)).to_have_text("Constant power by PWM, 0.1 mm wire")
    expect(page.locator(".report-results")).to_contain_text("peak temperature")
    expect(page.locator(".report-insight")).to_contain_text("of the cycle")
    expect(page.get_by_role("region", name="What differs")).to_contain_text("element.length")
    readout = page.get_by_role("figure", name="wire temperature", exact=True).locator(".readout")
    before = readout.inner_text()
    page.locator(".chart .chart-over").first.hover(position={"x": 200, "y": 40})
    expect(readout).not_to_have_text(before)
    assert 'length = "150 mm"' in page.locator(".report-text").inner_text()
    page.locator("summary", has_text="Material and element").click()
    expect(page.get_by_role("region", name="Material and element")).to_contain_text("datasheet")
    assert asked == [path.as_uri()]
