"""The bench as files: it opens from a plain file server, runs by itself, and asks nobody else."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect
from static_wire import ROW, TABLE, TEXT, write_wire

from martensite.app.documents import build_packaged
from martensite.studies.base import load_study


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
def page(tab: Any, address: str) -> Iterator[Page]:
    tab.empty(address.rstrip("/"))
    tab.page.goto(f"{address}#/bench")
    yield tab.page
    tab.check()
    assert {urlsplit(url).netloc for url in tab.asked if url.startswith("http")} == {urlsplit(address).netloc}


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
        "title", "This control needs the server. Install the Python package and start “martensite app” for this."
    )


def test_every_tab_door_and_download_works_here(page: Page) -> None:
    """What has no place on a page without a server is absent; an address of it gets one sentence."""
    tabs = page.get_by_role("navigation", name="Pages").get_by_role("link")
    expect(tabs).to_have_text(["Bench", "Studies"])
    page.get_by_role("button", name="Pin").first.click()
    page.get_by_text("What differs").click()
    for name in ("CSV", "netCDF", "PNG"):
        expect(page.get_by_role("button", name=name)).to_have_count(0)
    page.goto(f"{page.url.split('#')[0]}#/start")
    doors = page.locator("a.door")
    expect(doors).to_have_count(4)
    for k in range(4):
        assert (doors.nth(k).get_attribute("href") or "").partition("?")[0] in ("#/bench", "#/studies")
    tabs.last.click()
    page.locator(".cards a").first.click()
    expect(page.locator(".study-head")).to_be_visible()
    assert page.get_by_role("alert").all_inner_texts() == []
    for name in ("sweep", "identify"):
        page.goto(f"{page.url.split('#')[0]}#/{name}")
        expect(page.get_by_text(f"The page “{name}” needs a server.")).to_be_visible()


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
    expect(page.get_by_text("it was lost when the page closed")).to_be_visible()


def test_a_study_shows_the_results_that_it_ships(page: Page) -> None:
    """The claims are those of the library; nothing offers to compute them."""
    study = load_study("migaone")
    answer = study.load_shipped_answer()
    assert answer is not None
    page.goto(f"{page.url.split('#')[0]}#/studies")
    page.get_by_role("link", name=study.title).click()
    computation = page.get_by_role("region", name="Computation")
    expect(computation).to_contain_text("martensite study migaone")
    expect(computation.get_by_role("button")).to_have_count(0)
    for claim in answer.claims:
        expect(page.get_by_text(claim.statement, exact=True).first).to_be_attached()
    assert Axe().run(page).response["violations"] == []


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
