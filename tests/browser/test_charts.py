"""Charts as they are seen: curves where they were, values under the pointer, zoom, files; and a page in Firefox."""

import json
import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from playwright.sync_api import Page, expect
from websockets.sync.client import ClientConnection, connect

from martensite.cli.commands.web_bench import pack_text

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")
COURSE = """figure => {
  const canvas = figure.querySelector("canvas"), over = figure.querySelector(".chart-over");
  const side = name => parseFloat(over.style[name]) * devicePixelRatio;
  const [left, top, width, height] = ["left", "top", "width", "height"].map(side);
  const probe = document.createElement("span");
  document.body.append(probe);
  const colours = [0, 1].map(k => {
    probe.style.color = `var(--curve-${k})`;
    return getComputedStyle(probe).color.match(/[0-9.]+/g).slice(0, 3).map(Number);
  });
  probe.remove();
  const pen = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
  pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(left, top, width, height).data;
  const wide = Math.floor(width), found = [];
  for (let k = 0; k < 24; k++) {
    const x = Math.floor((k + 0.5) * width / 24), rows = [];
    for (let y = 0; y < Math.floor(height); y++) {
      const at = 4 * (y * wide + x);
      const near = c => c.every((v, i) => Math.abs(v - data[at + i]) < 40);
      if (data[at + 3] > 200 && colours.some(near)) rows.push(y / height);
    }
    found.push(rows.length ? [rows[0], rows.at(-1)].map(y => Math.round(100 * (1 - y))) : []);
  }
  return found;
}"""
"""Highest and lowest place of the curves in 24 columns, in per cent of the height."""
NEAR = 6
"""Per cent by which a curve may be elsewhere: lines are some pixels thick, and charts not equally high."""
KEPT: dict[str, list[list[int]]] = {
    "Martensite fraction – wire temperature": [
        *[
            [],
            *[[94, 94]] * 7,
            [94, 70],
            [94, 39],
            [94, 9],
            *[[94, 7]] * 3,
            [90, 7],
            [61, 7],
            [23, 7],
            *[[7, 7]] * 6,
            [],
        ]
    ],
    "Wire temperature": [
        *([6, 6], [21, 19], [51, 50], [63, 63], [68, 68], [72, 72], [82, 82], [87, 87], [91, 91], [92, 92], [94, 94]),
        *([95, 95], [76, 74], [50, 49], [41, 41], [37, 37], [33, 33], [26, 24], [19, 18], [15, 14], [12, 12], [10, 10]),
        *([9, 9], [9, 9]),
    ],
    "Axial stress": [*[*[[6, 6]] * 3, [28, 26], [67, 65], *[[95, 95]] * 9, [71, 69], [38, 37], [10, 9], *[[6, 6]] * 7]],
}
"""What is seen of the default wire; looked at when it was kept."""
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")


def opened(page: Page, text: str = TEXT) -> None:
    page.evaluate("hash => location.hash = hash", f"#/bench?scenario={pack_text(text)}")
    expect(page.get_by_role("heading", level=1)).to_contain_text("Constant power")
    expect(page.locator(".time-panel").first).to_be_visible()


def courses(page: Page) -> dict[str, list[list[int]]]:
    """Courses of some charts, by the heading."""
    expect(page.locator(".busy")).to_be_empty()
    figures = page.locator("figure:has(.chart)").all()
    titles = [(one.locator("figcaption .panel-title").inner_text(), one) for one in figures]
    return {title: one.evaluate(COURSE) for title, one in titles if title in KEPT}


def differing(found: dict[str, list[list[int]]]) -> list[str]:
    """Charts whose curves are not where they were."""

    def same(a: list[int], b: list[int]) -> bool:
        return len(a) == len(b) and all(abs(x - y) <= NEAR for x, y in zip(a, b, strict=True))

    return [
        title
        for title, course in KEPT.items()
        if sum(not same(a, b) for a, b in zip(found[title], course, strict=True)) > 2
    ]


@pytest.mark.slow
def test_curves_are_where_they_were(page: Page) -> None:
    opened(page)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        for _ in range(40):
            if not (left := differing(courses(page))):
                break
            page.wait_for_timeout(100)
        assert left == [], (scheme, courses(page))
    opened(page, TEXT.replace("0.45 W", "0.3 W"))  # it sees what has changed
    for _ in range(100):
        if differing(courses(page)):
            return
        page.wait_for_timeout(100)
    raise AssertionError("other curves look the same")


def test_a_chart_tells_values_zooms_and_is_saved(page: Page) -> None:
    opened(page)
    chart = page.locator("figure.loop", has_text="Strain – wire temperature").locator(".chart")
    over, tip = chart.locator(".chart-over"), chart.locator(".chart-tip")
    chart.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.06 * box["width"], box["y"] + 0.06 * box["height"])
    expect(tip).to_have_text(re.compile(r"^T = 2\d(\.\d+)? °Cε = 4\.\d+ %$"))
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    expect(tip).to_be_hidden()
    place = page.locator(".time-line").first
    before = place.get_attribute("style")
    over.press("End")
    expect(place).not_to_have_attribute("style", before or "")
    page.keyboard.down("Control")
    page.mouse.wheel(0, -200)
    page.keyboard.up("Control")
    whole = chart.get_by_role("button", name="Show all")
    expect(whole).to_be_visible()
    over.dblclick(position={"x": 0.5 * box["width"], "y": 0.5 * box["height"]})
    expect(whole).to_have_count(0)
    files: dict[str, bytes] = {}
    for name in ("Picture, PNG", "Picture, SVG", "Data, CSV"):
        chart.hover()
        chart.get_by_label("Save this chart").click()
        with page.expect_download() as taken:
            chart.get_by_role("button", name=name).click()
        files[taken.value.suggested_filename.rpartition(".")[2]] = taken.value.path().read_bytes()
        page.keyboard.press("Escape")
    assert files["png"].startswith(b"\x89PNG")
    assert files["svg"].startswith(b"<svg") and "ε [%]".encode() in files["svg"]
    rows = files["csv"].decode().splitlines()
    assert rows[0].startswith("T [°C],ε [%]") and len(rows) > 100


@dataclass
class Firefox:
    """Firefox without a window, spoken to in WebDriver BiDi."""

    socket: ClientConnection
    context: str = ""
    count: int = 0

    def ask(self, method: str, **params: Any) -> Any:
        self.count += 1
        self.socket.send(json.dumps({"id": self.count, "method": method, "params": params}))
        while (answer := json.loads(self.socket.recv(60))).get("id") != self.count:
            pass
        assert answer["type"] == "success", answer
        return answer["result"]

    def evaluate(self, words: str) -> Any:
        target = {"context": self.context}
        found = self.ask("script.evaluate", expression=words, target=target, awaitPromise=True)
        return found["result"].get("value")

    def until(self, words: str) -> None:
        end = time.monotonic() + 60
        while not self.evaluate(words):
            assert time.monotonic() < end, words
            time.sleep(0.1)


@contextmanager
def firefox(folder: Path) -> Iterator[Firefox]:
    command = [str(FIREFOX), "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
    settings = {**os.environ, "HOME": str(folder), "MOZ_DISABLE_CONTENT_SANDBOX": "1"}
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=settings
    ) as process:
        try:
            matches = (re.search(r"BiDi listening on (ws://\S+)", line) for line in process.stderr or ())
            found = next(filter(None, matches), None)
            if found is None:
                pytest.skip("this Firefox does not speak WebDriver BiDi")
            with connect(f"{found[1]}/session", max_size=2**24) as socket:
                fox = Firefox(socket)
                fox.ask("session.new", capabilities={})
                fox.context = fox.ask("browsingContext.getTree")["contexts"][0]["context"]
                yield fox
        finally:
            process.kill()


DRAWN = "document.querySelectorAll('.time-panel canvas').length >= 5 && !document.querySelector('.busy button')"
PIXELS = "document.querySelector('.loop canvas').toDataURL()"
SLIDE = """(() => {
  const field = document.querySelector("input[type=range]");
  field.value = String(0.8 * Number(field.value));
  field.dispatchEvent(new Event("input", { bubbles: true }));
})()"""


@pytest.mark.slow
@pytest.mark.skipif(FIREFOX is None, reason="no Firefox on this machine (Debian: apt-get install firefox-esr)")
def test_firefox_shows_the_bench_and_follows_a_number(bench: Bench, tmp_path: Path) -> None:
    with firefox(tmp_path) as fox:
        fox.ask("browsingContext.navigate", context=fox.context, url=f"{bench.address}#/bench", wait="complete")
        fox.until(DRAWN)
        fox.until("document.querySelector('.loop canvas').width > 100")
        before = fox.evaluate(PIXELS)
        assert len(before) > 3000
        fox.evaluate(SLIDE)
        fox.until(f"{PIXELS} !== {json.dumps(before)}")
        assert fox.evaluate("document.querySelectorAll('[role=alert]').length") == 0
