"""A bench and a headless Chromium that looks at it.

Every page is watched: at the end of a test there must be no error on its console, and no request
may have left this machine.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from app_server import Bench, running
from playwright.sync_api import Browser, Page, expect, sync_playwright

from martensite.app.documents import list_standalone
from martensite.cli.commands.web_bench import pack_text

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # as where there is none
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--no-first-run",
    "--disable-sync",
    "--disable-background-networking",
    "--disable-component-update",
)
NAMES = ("chromium", "chromium-browser", "google-chrome")
DRAWN_BY_PROCESSOR = "GPU stall due to ReadPixels"
"""What Chromium notes where it draws without a graphics processor; nothing that a page can do."""
OPENED = pack_text(list_standalone()["constant_power"])
"""Scenario on the bench of each test."""
PATIENCE = 30_000
"""For processes that start on a busy machine [ms]."""
LOCAL = ("127.0.0.1", "")
"""Hosts that may be asked; addresses of kinds `data` and `blob` have none."""


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with running(tmp_path_factory.mktemp("bench")) as made:
        yield made


@pytest.fixture(scope="module")  # its event loop would stop tests of other folders that start one
def chromium() -> Iterator[Browser]:
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Browser, bench: Bench, tmp_path: Path) -> Iterator[Page]:
    """A page of a fresh browser that holds the token, on the bench; on a screen of 1280 by 800."""
    context = chromium.new_context(
        viewport={"width": 1280, "height": 800}, accept_downloads=True, reduced_motion="reduce"
    )
    made = context.new_page()
    said: list[str] = []
    asked: list[str] = []
    made.on("console", lambda m: said.append(m.text) if m.type in ("error", "warning") else None)
    made.on("pageerror", lambda error: said.append(str(error)))
    made.on("request", lambda request: asked.append(request.url))
    made.set_default_timeout(PATIENCE)
    made.goto(f"{bench.address}#/bench?scenario={OPENED}")
    yield made
    context.close()
    assert [text for text in said if DRAWN_BY_PROCESSOR not in text] == []
    assert [url for url in asked if (urlsplit(url).hostname or "") not in LOCAL] == []


@pytest.fixture
def clicks(page: Page) -> Callable[[], int]:
    """The page with the questions; returns the number of clicks since then."""
    page.goto(f"{page.url.partition('#')[0]}#/start")
    expect(page.get_by_role("main").get_by_role("listitem")).to_have_count(6)
    page.evaluate("window.clicks = 0; addEventListener('click', () => (window.clicks += 1), true)")
    return lambda: page.evaluate("window.clicks")
