"""The bench as files: it opens from a plain file server, runs by itself, and asks nobody else."""

from __future__ import annotations

import math
import random
import re
import shlex
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from command import Command
from playwright.sync_api import Page, expect
from static_wire import ROW, TABLE, TEXT, write_wire

from martensite.app.documents import build_packaged


class Quiet(SimpleHTTPRequestHandler):
    """A server that says nothing of what it serves."""

    def log_message(self, format: str, *args: Any) -> None:
        pass


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("static-page")
    write_wire(folder, page=True, table=True)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def page(chromium: Any, address: str) -> Iterator[Page]:
    made, asked, said = chromium.new_page(viewport={"width": 1280, "height": 800}), list[str](), list[str]()
    made.on("request", lambda request: asked.append(request.url))
    made.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    made.on("pageerror", lambda error: said.append(str(error)))
    made.goto(f"{address}#/bench")
    yield made
    made.close()
    assert said == []
    assert {urlsplit(url).netloc for url in asked if url.startswith("http")} == {urlsplit(address).netloc}


def title_of(text: str = TEXT, **changes: Any) -> str:
    """What the page says of a run."""
    result = build_packaged(text, {path.replace("__", "."): value for path, value in changes.items()}).run()
    return f"{len(result.times)} samples, {result.steps} steps"


def test_a_field_runs_the_wire_without_a_server(page: Page) -> None:
    about = page.locator(".bench-title")
    expect(about).to_contain_text(title_of())
    field = page.locator("#form-element-diameter")
    field.fill("0.12")
    field.press("Enter")
    expect(about).to_contain_text(title_of(element__diameter="0.12 mm"))
    page.reload()
    expect(about).to_contain_text(title_of(element__diameter="0.12 mm"))


def test_the_power_of_a_table_is_drawn_up_as_a_whole(page: Page) -> None:
    """By the slider on top; it is still there after a reload, and undone by a click."""
    about = page.locator(".bench-title")
    expect(about).to_contain_text(title_of())
    page.get_by_role("combobox").first.select_option(label="Power of a table")
    expect(about).to_contain_text(title_of(TABLE))
    power = page.get_by_role("slider", name="heating power")
    expect(power).to_be_enabled()
    power.focus()
    power.press("Home")  # a tenth of it
    expect(about).to_contain_text(title_of(TABLE, **{ROW: ["0 W", "0.05 W", "0.05 W", "0 W"]}))
    page.reload()
    expect(about).to_contain_text(title_of(TABLE, **{ROW: ["0 W", "0.05 W", "0.05 W", "0 W"]}))
    expect(page.locator(".top-controls output").first).to_have_text("0.05")
    page.get_by_role("button", name="Undo").click()
    expect(about).to_contain_text(title_of(TABLE))


def test_what_needs_the_server_is_grey_and_says_so(page: Page) -> None:
    page.get_by_role("button", name="All parameters").click()
    length = page.locator("#form-element-length")
    expect(length).to_be_disabled()
    expect(page.locator("fieldset.fixed", has=length)).to_have_attribute(
        "title",
        "This control needs the server. "
        "Install martensite on this machine to change it: pip install 'martensite[app]', then martensite app.",
    )
    page.goto(f"{page.url.split('#')[0]}#/sweep")
    expect(page.get_by_text("This page has no server").first).to_be_visible()


def wait_for(page: Page, what: str, condition: str) -> None:
    """Wait until what stands below the picture in space meets a condition on x: `ξ x`, or `x °C`."""
    pattern = {"fraction": r"/ξ ([\d.]+)/", "celsius": r"/([\d.]+) °C/"}[what]
    shown = f"Number(document.querySelector('.scene-values').innerText.match({pattern})[1])"
    page.wait_for_function(f"() => (x => {condition})({shown})")


def test_heat_is_held_and_the_load_dragged_and_what_came_of_it_is_kept(page: Page) -> None:
    live = page.get_by_role("button", name="Live")
    live.click()
    expect(page.get_by_role("region", name="Running by hand")).to_be_visible()
    page.keyboard.down("h")
    wait_for(page, "fraction", "x < 0.6")
    page.keyboard.up("h")
    wait_for(page, "fraction", "x > 0.75")
    wait_for(page, "celsius", "x < 28")  # the point stands nearly still

    # the point of the phase diagram follows the pointer, and takes the load along
    slider = page.get_by_role("slider", name="Preload of the spring")
    before = float(slider.input_value())
    box = page.locator(".drawn .dot").bounding_box()
    assert box
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y - 40)
    expect(page.get_by_role("button", name="Heat", exact=True)).to_have_attribute("aria-pressed", "true")
    page.wait_for_function(f"() => Number(document.querySelector('.live-load input').value) > {before} + 0.1")
    page.mouse.up()
    expect(page.get_by_role("button", name="Heat", exact=True)).to_have_attribute("aria-pressed", "false")

    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("by hand")
    page.get_by_role("button", name="Pin this run").click()
    field = page.locator("#form-element-diameter")
    field.fill("0.12")
    field.press("Enter")
    expect(page.get_by_role("heading", level=1)).not_to_contain_text("by hand")
    page.reload()
    expect(page.get_by_text("it was lost with the page")).to_be_visible()


TRUTH = {"A_s": 337.15, "A_f": 353.15, "preload": 0.6}
"""What a log was made with, in SI."""
POWER = {
    "kind": "table",
    "times": ["0 s", "2 s", "5 s", "7 s", "10 s"],
    "values": ["0 W", "0.5 W", "0.3 W", "0 W", "0 W"],
}
FIT = Command("fit")
REACTION = """async () => {
  const begun = performance.now();
  [...document.querySelectorAll("button")].find((one) => one.innerText.startsWith("Stop and keep")).click();
  while (!document.querySelector(".identify-headline") && performance.now() < begun + 5000) {
    await new Promise((next) => setTimeout(next, 5));
  }
  return performance.now() - begun;
}"""


def write_log(path: Path, rows: int) -> Path:
    """A run of the wire with other numbers as a device of this country writes it: semicolons, decimal commas, noise."""
    truth = {
        "element.law.A_s": "337.15 K",
        "element.law.A_f": "353.15 K",
        "mechanism.preload": "0.6 N",
        "run.samples": rows,
        "drive.waveform": POWER,
    }
    result, draw = build_packaged(TEXT, truth).run(), random.Random(5)
    spread = {name: max(result.columns[name]) - min(result.columns[name]) for name in ("position", "resistance")}
    lines = ["Zeit;P [W];position (mm);R [ohm]", "s;W;mm;ohm"]
    for k, time in enumerate(result.times):
        x, r = (result.columns[name][k] + 0.005 * spread[name] * draw.gauss(0.0, 1.0) for name in spread)
        lines.append(f"{time:.6g};{result.columns['drive'][k]:.9g};{1e3 * x:.7g};{r:.7g}".replace(".", ","))
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def choose_log(page: Page, path: Path) -> None:
    page.goto(f"{page.url.split('#')[0]}#/identify")
    page.get_by_label("Drop a log here").set_input_files(str(path))


def test_a_log_is_fitted_without_a_server_as_martensite_fit_does(page: Page, tmp_path: Path) -> None:
    choose_log(page, write_log(tmp_path / "device.csv", 201))
    expect(page.locator(".identify-said")).to_contain_text("semicolons and decimal commas: time in s, power in W")
    page.get_by_role("button", name="Next: records").click()
    page.get_by_role("button", name="Next: scenario").click()
    page.get_by_role("button", name="Constant power by PWM, 0.1 mm wire, 2 numbers (simplest)").click()
    page.get_by_role("checkbox", name="preload", exact=True).check()
    page.get_by_role("button", name="Fit 3 parameters").click()
    expect(page.locator(".identify-headline")).to_contain_text("Good: it predicts what it was not fitted to")
    assert Axe().run(page).response["violations"] == []

    page.get_by_text("The same on the command line").click()
    words = shlex.split(page.locator(".identify-command").inner_text())
    assert words[:2] == ["martensite", "fit"]
    for name in ("Save the scenario", "Save the log as it was fitted"):
        with page.expect_download() as saved:
            page.get_by_role("button", name=name).click()
        saved.value.save_as(tmp_path / "again" / saved.value.suggested_filename)
    files = [str(tmp_path / "again" / word) if word in ("device.csv", "scenario.toml") else word for word in words[2:]]
    again = FIT.report(*files)["parameters"]
    table = page.get_by_role("region", name="Parameters, with intervals of 95 %").locator("tbody tr")
    offsets = {"A_s": 273.15, "A_f": 273.15, "preload": 0.0}
    for row in table.all():
        name, value, interval = row.locator("th, td").all_inner_texts()[:3]
        found = float(value.split()[0]) + offsets[name]
        low, high = (float(end) + offsets[name] for end in interval.split(" to "))
        assert low <= TRUTH[name] <= high, name
        assert math.isclose(found, again[name]["value"], rel_tol=1e-3), name
        assert math.isclose(high - low, again[name]["high"] - again[name]["low"], rel_tol=0.1), name

    page.reload()  # nothing is lost
    expect(page.locator(".identify-headline")).to_contain_text("Good")
    page.get_by_role("button", name="Open on the bench").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Constant power")
    expect(page.locator("#form-mechanism-preload")).to_have_value(re.compile(r"^0\.(59|60)"))


def test_a_fit_that_is_stopped_ends_soon_and_keeps_its_best(page: Page, tmp_path: Path) -> None:
    choose_log(page, write_log(tmp_path / "long.csv", 12001))
    page.get_by_role("button", name="Fit a model to it").click()
    expect(page.get_by_role("table", name="Best so far")).to_be_visible()
    expect(page.get_by_text("The search has not told of a run yet")).to_have_count(0)
    assert page.evaluate(REACTION) < 3000.0  # 0.2 s to 0.4 s where nothing else runs
    expect(page.locator(".identify-headline")).to_contain_text(
        "Usable with care. The search did not converge: interrupted"
    )
    expect(page.get_by_role("button", name="Go on with the search")).to_be_visible()


def test_a_file_that_is_no_text_is_left_to_the_server(page: Page, tmp_path: Path) -> None:
    (tmp_path / "log.xlsx").write_bytes(b"PK\x03\x04")
    choose_log(page, tmp_path / "log.xlsx")
    expect(page.get_by_role("alert")).to_contain_text("This page reads tables as text")


MOVES = """async (count) => {
  const slider = document.querySelector(".top-controls input[type=range]");
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const frame = () => new Promise(requestAnimationFrame);
  for (let k = 0; k < count; k++) {
    if (k % 25 === 0) slider.dispatchEvent(new PointerEvent("pointerdown", {bubbles: true}));
    set.call(slider, 350 + ((37 * k) % 300));
    slider.dispatchEvent(new Event("input", {bubbles: true}));
    await frame();
    await frame();
  }
}"""
"""A slider taken by the hand 25 places long, again and again."""


def measure_heap(page: Page) -> tuple[float, int, int]:
    """What the page holds after its garbage was collected: [MB], nodes of the document, listeners."""
    page.wait_for_timeout(1500)  # the session is kept, the trial is through
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    for _ in range(2):
        session.send("HeapProfiler.collectGarbage")
    used = session.send("Runtime.getHeapUsage")["usedSize"]
    counted = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
    session.detach()
    return used / 1e6, int(counted["Nodes"]), int(counted["JSEventListeners"])


@pytest.mark.slow
def test_memory_is_flat_after_a_thousand_moves(page: Page) -> None:
    expect(page.locator(".bench-title")).to_contain_text(title_of())
    page.set_viewport_size({"width": 1101, "height": 400})  # a small picture is drawn soon
    page.evaluate(MOVES, 400)  # what is made once, code too, is there
    heap, nodes, listeners = measure_heap(page)
    page.evaluate(MOVES, 1000)
    after = measure_heap(page)
    assert after[0] <= heap + 1.0, f"{heap:.2f} MB before, {after[0]:.2f} MB after"
    assert after[1] <= 1.1 * nodes and after[2] <= 1.1 * listeners, (nodes, listeners, after)
