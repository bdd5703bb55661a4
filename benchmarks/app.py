"""The web bench in a headless Chromium: what it weighs, how soon it is there, how soon it follows.

What: a server is started as users start it; a browser opens the address and moves a slider. Times
are taken in the page, from the event of the slider to the frame that shows the result. Needs
Playwright and a Chromium on this machine.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, section

MOVES, MANY = 60, 500
"""Moves of a slider that are timed, and those after which the memory is looked at."""
SCENARIOS = ("constant_power", "finger")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # as where there is none
    "--disable-dev-shm-usage",
    "--enable-precise-memory-info",
    "--js-flags=--expose-gc",
)
SHOWN = "main h1:not(:empty)"
FOLLOWED = """async ([value]) => {
  const slider = document.querySelector("input[type=range]");
  const box = document.querySelector("[aria-busy]");
  const begin = performance.now();
  const painted = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const over = new Promise((done) => {
    const watcher = new MutationObserver(() => {
      if (box.getAttribute("aria-busy") === "false") watcher.disconnect(), done(true);
    });
    watcher.observe(box, { attributes: true, attributeFilter: ["aria-busy"] });
    setTimeout(done, 5000, false);
  });
  slider.value = String(value);
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  if (!(await over)) return null;
  await painted();
  return performance.now() - begin;
}"""


@contextmanager
def served() -> Iterator[tuple[str, float, int]]:
    """A bench: its address, when it was started, and its process."""
    command = [sys.executable, "-m", "martensite", "app", "--no-browser", "--json"]
    begun = time.perf_counter()
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment) as process:
        text = ""
        for line in process.stdout or ():
            text += line
            if line.startswith("}"):
                break
        try:
            yield json.loads(text)["address"], begun, process.pid
        finally:
            process.terminate()


def resident(pid: int) -> float:
    """Memory of a process and of all that it has started [MB]."""
    import psutil

    parent = psutil.Process(pid)
    every = [parent, *parent.children(recursive=True)]
    return sum(one.memory_info().rss for one in every) / 1e6


def heap(page: Any) -> float:
    """What the scripts of a page hold after a collection [MB]."""
    page.evaluate("gc()")
    return page.evaluate("performance.memory.usedJSHeapSize") / 1e6


def moved(page: Any, count: int) -> list[float]:
    """Times from the event of a slider to the frame with its result [ms].

    All moves are one drag: where a slider is let go, its range is laid around its new value.
    """
    low, high, at = page.evaluate(
        "() => { const s = document.querySelector('input[type=range]');"
        " return [Number(s.min), Number(s.max), Number(s.value)] }"
    )
    width = 0.2 * min(at - low, high - at) or 0.1 * (high - low)
    places = [at + width * ((k % 20) - 9.5) / 10 for k in range(count)]
    found = [page.evaluate(FOLLOWED, [place]) for place in (*places, at)]
    return [one for one in found[:count] if one is not None]


def opened(browser: Any, address: str) -> Any:
    """A page with the bench in it."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(address)
    page.wait_for_selector(SHOWN)
    return page


WEIGHED = """() => {
  const sum = (ones) => ones.reduce((total, one) => total + one.transferSize, 0) / 1000;
  const all = [...performance.getEntriesByType("resource"),
    ...performance.getEntriesByType("navigation")];
  const answers = all.filter((one) => one.name.includes("/api/"));
  return [sum(all) - sum(answers), sum(answers)];
}"""
"""Bytes over the wire [kB]: of the page with its scripts, and of the answers to its calls."""


@section
def app(options: Options) -> list[Table]:
    """The web bench: first page, weight, slider to picture, memory."""
    from playwright.sync_api import sync_playwright

    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    first: list[dict[str, Any]] = []
    followed: list[dict[str, Any]] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        for _ in range(max(1, options.repeats)):
            with served() as (address, begun, _):
                page = opened(browser, address)
                painted = page.evaluate("performance.timeOrigin + performance.getEntriesByType('paint')[0].startTime")
                took = painted - 1e3 * (time.time() - time.perf_counter() + begun)
                page.wait_for_load_state("networkidle")
                weight, answers = page.evaluate(WEIGHED)
                row = {"first page [ms]": took, "page [kB]": weight, "answers [kB]": answers}
                first.append(row)
                page.close()
        for name in SCENARIOS:
            followed.append(slides(browser, name))
        browser.close()
    middle = {key: statistics.median(row[key] for row in first) for key in first[0]}
    return [
        Table("Web bench, from the start of the server to the first page, and its bytes", [middle]),
        Table("Web bench, from the slider to the picture, and memory", followed),
    ]


def slides(browser: Any, name: str) -> dict[str, Any]:
    """One scenario: quick moves on floats and in C, then 500 of them, and what is held."""
    from martensite.app.documents import list_standalone
    from martensite.cli.commands.web_bench import pack_text

    with served() as (address, _, pid):
        page = opened(browser, f"{address}#/bench?scenario={pack_text(list_standalone()[name])}")
        page.wait_for_selector("input[type=range]")
        page.wait_for_selector("[aria-busy=false]")
        row: dict[str, Any] = {"scenario": name}
        early = moved(page, 5)
        row["first moves [ms]"] = statistics.median(early)
        page.wait_for_timeout(8_000)  # until it is compiled
        late = sorted(moved(page, MOVES))
        row["median [ms]"] = statistics.median(late)
        row["95 % [ms]"] = late[int(0.95 * (len(late) - 1))]
        heap_before, held_before = heap(page), resident(pid)
        moved(page, MANY)
        row["page before [MB]"], row["page after [MB]"] = heap_before, heap(page)
        row["server before [MB]"], row["server after [MB]"] = held_before, resident(pid)
        page.close()
    return row
