"""Draws the devices of the first page, the bench and the film of the README: `python docs/_ext/device_pictures.py`.

With `--film` it makes only the film. The real page runs each scenario of the directive `devices` in a headless
Chromium, and its scene is photographed where the actuator has moved most. The film is the animation that the page
saves. It needs Chromium and the extra `test`; pictures are kept with the pages, since builds have no browser.
"""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from martensite.app.documents import build_packaged, list_standalone
from martensite.cli.commands.web_bench import build_address

DOCS = Path(__file__).resolve().parents[1]
FOLDER = DOCS / "_static" / "devices"
FLAGS = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage")
WIDTH = 640
"""Of a picture [px]."""
MOST = 60_000
"""Bytes of a picture."""
BENCH, SCREEN = "finger", 1440
"""What the whole page shows, and how wide it is [px]."""
FILMED, SPEED, FILM_MOST = "dead_weight", "2", 1_500_000
"""Scenario of the film, its speed (20 s in 10 s), and bytes of the film."""
MOVE = """(range, share) => {
  range.value = Number(range.min) + share * (range.max - range.min);
  range.dispatchEvent(new Event("input", { bubbles: true }));
}"""
"""Moves the time of the page."""
PATIENCE = 90_000
"""For a run on a busy machine [ms]."""


def list_devices() -> list[str]:
    """The scenarios that the first page shows."""
    (lines,) = re.findall(r"```\{devices\}\n(.*?)```", (DOCS / "index.md").read_text("utf-8"), re.DOTALL)
    return [line.partition("|")[0].strip() for line in lines.splitlines()]


@contextmanager
def serve_bench() -> Iterator[str]:
    """The address of a bench that ends with it."""
    command = [sys.executable, "-m", "martensite", "app", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as bench:
        announced = ""
        while not announced.endswith("}\n"):
            announced += bench.stdout.readline() if bench.stdout else ""
        yield json.loads(announced)["address"]
        bench.terminate()


def find_share(text: str) -> float:
    """Where in the run the actuator has moved most, as a share of its time."""
    result = build_packaged(text).run()
    column = result[result.coordinate]
    moved = max(range(len(column)), key=lambda k: abs(column[k] - column[0]))
    return float(result.times[moved] / result.times[-1])


def open_scenario(page: Page, address: str, text: str) -> None:
    """Show a scenario where its actuator has moved most."""
    page.goto("about:blank")
    page.goto(build_address(address, text))
    page.locator(".scene-view canvas").wait_for(timeout=PATIENCE)
    page.locator(".bench[aria-busy=false]").wait_for(timeout=PATIENCE)
    cursor = page.locator(".player-scrub input")
    cursor.evaluate(MOVE, find_share(text))
    page.wait_for_timeout(1500)  # the camera comes to rest


def take_picture(page: Page, address: str, text: str) -> bytes:
    """The scene of a scenario, PNG."""
    open_scenario(page, address, text)
    page.add_style_tag(content=".scene-view > :not(canvas) { visibility: hidden }")
    return page.locator(".scene-view").screenshot()


def take_page(page: Page, address: str, text: str) -> bytes:
    """The whole page with a scenario, and what would help it, PNG."""
    open_scenario(page, address, text)
    page.locator(".insight-promise:not(:empty)").wait_for(timeout=PATIENCE)
    return page.screenshot()


def take_film(page: Page, address: str, text: str) -> bytes:
    """The animation that the page saves, GIF."""
    page.goto("about:blank")
    page.goto(build_address(address, text))
    page.locator(".scene-view canvas").wait_for(timeout=PATIENCE)
    page.locator(".bench[aria-busy=false]").wait_for(timeout=PATIENCE)
    page.locator(".player-speed select").select_option(SPEED)
    page.locator(".scene summary", has_text="Save").click()
    with page.expect_download(timeout=10 * PATIENCE) as saved:
        page.get_by_role("button", name="GIF").click()
    return saved.value.path().read_bytes()


def draw_film(page: Page, address: str) -> None:
    """Make the film of the README."""
    film = take_film(page, address, list_standalone()[FILMED])
    if len(film) > FILM_MOST:
        sys.exit(f"the film has {len(film)} bytes, more than {FILM_MOST}")
    (FOLDER.parent / "film.gif").write_bytes(film)
    print(f"the film: {len(film) / 1e3:.0f} kB")


def write_picture(shot: bytes, path: Path, width: int = WIDTH, most: int = MOST) -> int:
    """Keep a picture, as good as it may be heavy; its bytes."""
    image = Image.open(io.BytesIO(shot)).convert("RGB")
    image.thumbnail((width, width))
    for quality in range(90, 20, -10):
        image.save(path, quality=quality, method=6)
        if path.stat().st_size < most:
            break
    return path.stat().st_size


def draw_all(film_only: bool) -> None:
    """Draw all of them, or make only the film."""
    FOLDER.mkdir(exist_ok=True)
    found = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with serve_bench() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1440, "height": 1000}, reduced_motion="reduce", color_scheme="light")
        draw_film(page, address)
        for name in () if film_only else list_devices():
            size = write_picture(take_picture(page, address, list_standalone()[name]), FOLDER / f"{name}.webp")
            print(f"{name}: {size / 1e3:.0f} kB")
        if not film_only:
            page.set_viewport_size({"width": SCREEN, "height": 900})
            shot = take_page(page, address, list_standalone()[BENCH])
            size = write_picture(shot, FOLDER.parent / "bench.webp", SCREEN, 2 * MOST)
            print(f"the bench: {size / 1e3:.0f} kB")
        browser.close()


if __name__ == "__main__":
    draw_all("--film" in sys.argv)
