"""How soon a page of static files is there, and how soon its picture follows a hand.

    python -m benchmarks.static_page FOLDER [--repeats 5] [--seconds 4] [--profile]

What: FOLDER, as `martensite app --static` writes it, is handed out by a file server of its own and opened
in a headless Chromium without a graphics processor. Told are the median, 95 % and the best of all repeats:

    first paint, first curve     from the navigation to the frame that shows it, nothing kept from before
    drag                         a slider is moved in every frame; from each event to the frame with its run, or
                                 a newer one
    move                         the slider is moved once the run of the last move is there
    live                         the model runs by hand under heat: from one picture to the next

with the frames that came, how many runs a picture was behind the newest that was begun, and CPU time of
the page, its worker, and what draws; `wait` is for how long page and worker waited for a processor that was
at something else, which is in the times above and would not be on a quiet machine. With `flat` there is no
WebGL, and the mechanism is drawn from the side: the difference is WebGL by a processor. `--profile` lists
where the page spends its time. Needs Playwright, a Chromium and `/proc`.
"""

from __future__ import annotations

import argparse
import functools
import http.server
import os
import statistics
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from shutil import which
from typing import Any

from benchmarks.app import FLAGS

SIZE = {"width": 1440, "height": 900}
PATIENCE = 60_000
"""[ms]"""
WATCH = """(() => {
  const found = (window.watched = { curve: 0, asked: [], answered: [], drawn: [], frames: 0 });
  const clear = CanvasRenderingContext2D.prototype.clearRect;
  let dirty = false, newest = -1, begun = -1;
  const painted = (time) => {
    found.frames += 1;
    if (dirty) {
      dirty = false;
      setTimeout((...which) => found.drawn.push([performance.now(), ...which]), 0, newest, begun);
      if (!found.curve) setTimeout(() => (found.curve = performance.now()));
    }
    requestAnimationFrame(painted);
  };
  CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    if (this.canvas.isConnected) dirty = true;
    return clear.apply(this, box);
  };
  requestAnimationFrame(painted);
  const Own = window.Worker;
  window.Worker = class extends Own {
    constructor(...how) {
      super(...how);
      this.addEventListener("message", ({ data }) => {
        newest = data.id ?? newest + 1;
        found.answered.push([performance.now(), newest]);
      });
    }
    postMessage(...what) {
      if (what[0].id) found.asked.push([performance.now(), (begun = what[0].id)]);
      super.postMessage(...what);
    }
  };
})()"""
"""Notes when runs are asked for and answered, and the frames after charts were drawn. A page's rAF is called in
the order of asking, so that a chart that is drawn in one is in the same frame as the watcher, or in the next."""
CLEARED = "() => Object.assign(window.watched, { asked: [], answered: [], drawn: [], frames: 0 })"
RENDERED = "Number(document.querySelector('.scene-view')?.dataset.rendered ?? 0)"
PAINTED = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
DRAG = """async ([seconds, waits]) => {
  const slider = document.querySelector(".top-controls input[type=range]");
  const [low, high, first] = [slider.min, slider.max, slider.value].map(Number);
  const width = Math.min(0.1 * (high - low), first - low, high - first) || 0.05 * (high - low);
  slider.dispatchEvent(new PointerEvent("pointerdown", { bubbles: true }));
  const events = [], begun = performance.now();
  const move = () => {
    const now = performance.now();
    slider.value = String(Math.round(first + width * Math.sin((now - begun) / 400)));
    events.push(now);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  while (performance.now() - begun < 1000 * seconds) {
    const count = window.watched.drawn.length;
    move();
    const late = () => performance.now() - events.at(-1) > 2000;
    do await frame(); while (waits && window.watched.drawn.length === count && !late());
  }
  const over = performance.now();
  await new Promise((done) => setTimeout(done, 300));
  return { events, seconds: (over - begun) / 1000 };
}"""
FINGER = """async () => {
  const { scenarios } = await (await fetch("runs/manifest.json")).json();
  const { text } = scenarios.find((one) => one.name === "finger");
  const packed = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const letters = btoa(String.fromCharCode(...new Uint8Array(await new Response(packed).arrayBuffer())));
  return letters.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}"""
"""The letters of a link to the scenario of the package."""
FLAT = "--disable-3d-apis"
"""Draws the mechanism from the side, as where there is no WebGL."""
KINDS = {"renderer": "page", "GPU": "drawing"}
WORKER = "DedicatedWorker"
"""Beginning of the name of its threads; those of a page that have another name collect garbage, compile and paint."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """A file server."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: Any) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


class Processor:
    """CPU time of a browser, by what it is spent on [ms]."""

    def __init__(self, browser: Any) -> None:
        self.session = browser.new_browser_cdp_session()
        self.before = self.read()

    def read(self) -> Counter[str]:
        """Since the start of each thread; those that ended do not count."""
        found = Counter[str]()
        for process in self.session.send("SystemInfo.getProcessInfo")["processInfo"]:
            kind = process["type"]
            for task in Path(f"/proc/{process['id']}/task").glob("*"):
                part = KINDS.get(kind, "browser")
                if kind == "renderer" and task.name != str(process["id"]):
                    part = "worker" if (task / "comm").read_text().startswith(WORKER) else "helpers"
                ran, waited, _ = (int(word) / 1e6 for word in (task / "schedstat").read_text().split())
                found[part] += ran
                if part in ("page", "worker"):
                    found["wait"] += waited
        return found

    def spent(self) -> dict[str, float]:
        """Since the last time."""
        now = self.read()
        found = {key: now[key] - self.before[key] for key in now}
        self.before = now
        return found


def open_page(browser: Any, address: str, script: str = WATCH) -> Any:
    """A page of a browser that knows nothing."""
    page = browser.new_context(viewport=SIZE).new_page()
    page.set_default_timeout(PATIENCE)
    page.add_init_script(script)
    page.goto(address, wait_until="commit")
    page.wait_for_function("window.watched.curve > 0")
    return page


def measure_start(browser: Any, address: str) -> dict[str, float]:
    """First paint and first curve [ms]; CPU time until then, or a little more [ms]."""
    processor = Processor(browser)
    page = open_page(browser, f"{address}#/bench")
    spent = processor.spent()
    row = {"first paint": page.evaluate(PAINTED), "first curve": page.evaluate("window.watched.curve")}
    row |= {f"CPU {key}": value for key, value in spent.items()}
    page.context.close()
    return row


def compare_drag(moved: dict[str, Any], watched: dict[str, Any], spent: dict[str, float]) -> dict[str, Any]:
    """From events to pictures."""
    events, asked, drawn = moved["events"], watched["asked"], watched["drawn"]
    # a run that is asked for has the newest event before it
    of_run = {run: max((k for k, at in enumerate(events) if at <= time), default=-1) for time, run in asked}
    pictures = [(time, of_run.get(run, -1)) for time, run, _ in drawn]
    late = list[float]()
    for k, at in enumerate(events):
        shown = next((time for time, has in pictures if has >= k), None)
        if shown is not None:
            late.append(shown - at)
    behind = [begun - seen for _, seen, begun in drawn]
    return {
        "late": late,
        "unseen": len(events) - len(late),
        "behind": max(behind, default=0),
        "moves": len(events),
        "pictures": len({run for _, run, _ in drawn}),
        "seconds": moved["seconds"],
        **{f"CPU {key}": value / max(len(events), 1) for key, value in spent.items()},
    }


def measure_drag(page: Any, browser: Any, seconds: float, waits: bool) -> dict[str, Any]:
    """A slider in motion."""
    page.evaluate(CLEARED)
    processor = Processor(browser)
    moved = page.evaluate(DRAG, [seconds, waits])
    spent = processor.spent()
    return compare_drag(moved, page.evaluate("window.watched"), spent)


def measure_live(page: Any, browser: Any, seconds: float) -> dict[str, Any]:
    """A model that runs by hand: from one picture to the next."""
    page.get_by_role("button", name="Live").click()
    page.locator(".live-heat").first.wait_for()
    page.wait_for_timeout(1000)
    page.evaluate(CLEARED)
    rendered = page.evaluate(RENDERED)
    processor = Processor(browser)
    for _ in range(round(seconds)):  # so that it moves all the time
        page.keyboard.down("h")
        page.wait_for_timeout(400)
        page.keyboard.up("h")
        page.wait_for_timeout(600)
    spent = processor.spent()
    watched = page.evaluate("window.watched")
    rendered = page.evaluate(RENDERED) - rendered
    page.get_by_role("button", name="Pause").click()
    times = [time for time, *_ in watched["drawn"]]
    count = max(len(times), 1)
    return {
        "late": [b - a for a, b in pairwise(times)],
        "frames": watched["frames"],
        "pictures": count,
        "in space": rendered,
        "seconds": seconds,
        **{f"CPU {key}": value / count for key, value in spent.items()},
    }


def write_times(name: str, rows: Sequence[dict[str, Any]]) -> None:
    """Print what was measured, a line each."""
    ends = [(statistics.median(row["late"]), sorted(row["late"])[int(0.95 * (len(row["late"]) - 1))]) for row in rows]
    for k, words in enumerate(("median", "95 %")):
        of = [end[k] for end in ends]
        print(f"{name}: {words} {statistics.median(of):.0f} ms, best {min(of):.0f} ms")
    told = [key for key in rows[0] if key != "late"]
    print("   ", ", ".join(f"{key} {statistics.median(row[key] for row in rows):.1f}" for key in told))


def write_profile(page: Any, act: Any) -> None:
    """Print where the page spends its time."""
    session = page.context.new_cdp_session(page)
    session.send("Profiler.enable")
    session.send("Profiler.setSamplingInterval", {"interval": 200})
    session.send("Profiler.start")
    act()
    found = session.send("Profiler.stop")["profile"]
    nodes, own = {one["id"]: one["callFrame"] for one in found["nodes"]}, Counter[str]()
    for node, took in zip(found["samples"], found["timeDeltas"], strict=True):
        frame = nodes[node]
        place = f"{frame['url'].rsplit('/')[-1]}:{frame['lineNumber']}:{frame['columnNumber']}"
        own[f"{frame['functionName']} {place}"] += took
    for name, took in own.most_common(40):
        print(f"    {took / 1e3:8.1f} ms  {100 * took / sum(own.values()):5.1f} %  {name}")


def main() -> None:
    """Measure and print."""
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--profile", action="store_true")
    parser.add_argument("--only", choices=("start", "drag", "live"))
    options = parser.parse_args()
    wanted = {options.only} if options.only else {"start", "drag", "live"}
    found = os.environ.get("CHROMIUM") or next(filter(None, map(which, ("chromium", "chromium-browser"))), None)
    with sync_playwright() as playwright, served(options.folder) as address:
        browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        if "start" in wanted:
            rows = [measure_start(browser, address) for _ in range(options.repeats)]
            for key in rows[0]:
                of = [row[key] for row in rows]
                print(f"{key}: median {statistics.median(of):.0f} ms, best {min(of):.0f} ms")
        if "live" in wanted:
            page = open_page(browser, f"{address}#/bench")
            page.wait_for_timeout(3000)
            rows = [measure_live(page, browser, options.seconds) for _ in range(options.repeats)]
            write_times("live, wire", rows)
            page.context.close()
            page = open_page(browser, f"{address}#/bench")
            text = page.evaluate(FINGER)
            page.goto("about:blank")
            page.goto(f"{address}#/bench?scenario={text}")
            page.wait_for_function("window.watched?.curve > 0")
            page.wait_for_timeout(3000)
            rows = [measure_live(page, browser, options.seconds) for _ in range(options.repeats)]
            write_times("live, finger", rows)
            if options.profile:
                write_profile(page, lambda: measure_live(page, browser, options.seconds))
        if "drag" in wanted:
            for flat in (False, True):
                if flat:
                    browser.close()
                    browser = playwright.chromium.launch(executable_path=found, args=[*FLAGS, FLAT])
                page = open_page(browser, f"{address}#/bench")
                page.wait_for_timeout(4000)
                for waits in (False, True):
                    rows = [measure_drag(page, browser, options.seconds, waits) for _ in range(options.repeats)]
                    write_times(f"{'move' if waits else 'drag'}{', flat' if flat else ''}", rows)
                if options.profile:
                    write_profile(page, lambda page=page: page.evaluate(DRAG, [options.seconds, False]))
                page.context.close()
        browser.close()


if __name__ == "__main__":
    main()
