"""The charts of the bench in a browser: drawn, in step with the time cursor, compared, exported."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from martensite.cli.commands.web_bench import pack_text

EXAMPLES = Path(__file__).parents[2] / "examples"
TEXT = (EXAMPLES / "constant_power.toml").read_text("utf-8")
INKED = """canvas => {
  const pen = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
  pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, canvas.width, canvas.height).data;
  const seen = new Set();
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 200)
    seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
  return seen.size;
}"""
PICTURE = "canvas => canvas.toDataURL()"


def opened(page: Page, text: str = TEXT, title: str = "Constant power") -> None:
    """Put a scenario on the bench by its address, and wait for its charts."""
    page.evaluate("hash => location.hash = hash", f"#/bench?scenario={pack_text(text)}")
    expect(page.get_by_role("heading", level=1)).to_contain_text(title)
    expect(page.locator(".time-panel").first).to_be_visible()


def changed(watt: str) -> str:
    return TEXT.replace("0.45 W", watt)


def panel(page: Page, title: str) -> Locator:
    figure = page.locator(".charts figure").filter(has=page.locator("figcaption", has_text=title))
    return figure.first


def picture(figure: Locator) -> str:
    return figure.locator("canvas").evaluate(PICTURE)


def until(page: Page, right: Callable[[], bool]) -> None:
    """Wait for what no locator can see."""
    for _ in range(200):
        if right():
            return
        page.wait_for_timeout(50)
    raise AssertionError("it did not come about")


def time_of(page: Page) -> str:
    """Where the time line stands."""
    return page.locator(".time-line").first.get_attribute("style") or ""


def test_every_chart_is_drawn_and_follows_the_document(page: Page) -> None:
    opened(page)
    drawn = page.locator(".charts canvas, .planes canvas")
    expect(drawn).to_have_count(12)
    charts = drawn.all()
    until(page, lambda: all(chart.evaluate(INKED) > 3 for chart in charts))
    loop = panel(page, "Strain – wire temperature")
    expect(loop).to_have_count(1)
    before, count = picture(loop), page.locator(".charts *").count()
    opened(page, changed("0.55 W"))
    until(page, lambda: picture(loop) != before)
    assert page.locator(".charts *").count() == count
    page.get_by_text("Curves", exact=True).click()
    page.get_by_label("electrical resistance").check()
    expect(drawn).to_have_count(13)
    light = picture(loop)
    page.get_by_role("button", name="Switch to dark").click()
    until(page, lambda: picture(loop) != light)


def test_the_time_cursor_moves_by_click_key_and_zoom(page: Page) -> None:
    opened(page)
    figure = panel(page, "Wire temperature")
    over, readout = figure.locator(".chart-over"), figure.locator(".readout")
    expect(readout).to_contain_text("T = 22 °C")
    box = over.bounding_box()
    assert box
    over.click(position={"x": 0.49 * box["width"], "y": 20})
    expect(readout).not_to_contain_text("22 °C")
    dot = page.locator(".loop .dot").first
    clicked, place = time_of(page), dot.get_attribute("style")
    page.locator(".traces").focus()
    page.keyboard.press("Shift+ArrowRight")
    expect(dot).not_to_have_attribute("style", place or "")
    assert time_of(page) != clicked
    page.keyboard.press("Home")
    expect(readout).to_contain_text("T = 22 °C")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box
    whole = picture(figure)
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 30, steps=3)
    page.mouse.up()
    expect(page.get_by_role("button", name="Show all of the time")).to_be_visible()
    until(page, lambda: picture(figure) != whole)
    over.dblclick(position={"x": 0.5 * box["width"], "y": 20})
    expect(page.get_by_role("button", name="Show all of the time")).to_have_count(0)


@pytest.mark.slow
def test_runs_are_pinned_compared_and_opened_again(page: Page) -> None:
    opened(page)
    page.get_by_role("button", name="Pin this run").click()
    name = page.get_by_label("Name of pinned run 1")
    name.fill("weak")
    name.press("Enter")
    opened(page, changed("0.6 W"))
    page.get_by_text("What differs").click()
    documents = page.get_by_role("region", name="Documents")
    expect(documents).to_contain_text("drive.waveform.high")
    expect(documents).to_contain_text("0.6 W")
    expect(documents).to_contain_text("0.45 W")
    expect(documents.get_by_role("columnheader").last).to_have_text("weak")
    results = page.get_by_role("region", name="Results")
    hottest = results.locator("tr", has_text="peak temperature").locator("td")
    expect(hottest).to_have_count(3)
    assert hottest.nth(1).text_content() != hottest.nth(2).text_content()
    figure = panel(page, "Wire temperature")
    page.wait_for_timeout(600)  # charts out of sight follow after a rest
    both = picture(figure)
    page.get_by_role("button", name="Hide weak").click()
    until(page, lambda: picture(figure) != both)
    page.get_by_role("button", name="Show weak").click()
    until(page, lambda: picture(figure) == both)
    page.get_by_role("button", name="Open weak").click()
    expect(page.get_by_text("The documents are the same.")).to_be_visible()
    page.get_by_role("button", name="Unpin weak").click()
    expect(name).to_have_count(0)


@pytest.mark.slow
def test_warnings_lead_to_their_time(page: Page) -> None:
    opened(page)
    expect(page.locator(".alarm")).to_have_count(0)
    calm = picture(panel(page, "Wire temperature"))
    opened(page, TEXT.replace("[drive]", '[element.limits]\ntemperature_limit = "90 degC"\n[drive]'))
    alarm = page.locator(".alarm")
    expect(alarm).to_contain_text("Too hot")
    expect(alarm).to_contain_text("against 90 °C")
    until(page, lambda: picture(panel(page, "Wire temperature")) != calm)
    alarm.get_by_role("button", name=re.compile("worst at")).click()
    hot = panel(page, "Wire temperature").locator(".readout")
    expect(hot).to_have_text(re.compile(r"T = 1\d\d(\.\d+)? °C"))


def test_exports_are_downloads(page: Page) -> None:
    opened(page)
    page.get_by_text("Export", exact=True).click()
    with page.expect_download() as taken:
        page.get_by_role("button", name="Data, CSV").click()
    assert taken.value.suggested_filename.endswith(".csv")
    assert taken.value.path().read_text("utf-8").startswith("time [s],drive [W],")
    with page.expect_download() as taken:
        page.get_by_role("button", name="Scenario, TOML").click()
    assert 'title = "Constant power' in taken.value.path().read_text("utf-8")


@pytest.mark.slow
def test_actuators_are_chosen(page: Page) -> None:
    text = (EXAMPLES / "closed_loop_platform.toml").read_text("utf-8")
    opened(page, text, "latform")
    readout = panel(page, "Axial stress").locator(".readout > span")
    expect(readout).to_have_count(3)
    page.get_by_label("Actuator", exact=True).select_option("second")
    expect(readout).to_have_count(1)
    expect(page.locator(".loop .dot")).to_have_count(4)
