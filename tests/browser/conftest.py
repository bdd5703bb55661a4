"""A bench and one tab of a headless Chromium, which every test gets empty.

A new browser context costs about 2 CPU seconds, a page loaded again in the same tab 0.8. Every page is watched: at the
end of a test there must be no error on its console, and no request may have left this machine.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from urllib.parse import urlsplit

import pytest
from app_server import Bench, running
from playwright.sync_api import Browser, BrowserContext, Page, ViewportSize, expect, sync_playwright

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
OPENED = f"bench?scenario={pack_text(list_standalone()['constant_power'])}"
PATIENCE = 90_000
"""For processes that start and compile on a busy machine [ms]."""
LOCAL = ("127.0.0.1", "")
"""Hosts that may be asked; addresses of kinds `data` and `blob` have none."""


FLAT = """(() => {
  if (!localStorage.getItem("flat")) return;
  const known = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...how) {
    return kind.startsWith("webgl") ? null : known.call(this, kind, ...how);
  };
})()"""
"""Without the picture in space, whose drawing takes half of the time of a page."""
EMPTY = """async flat => {
  sessionStorage.clear();
  localStorage.clear();
  if (flat) localStorage.setItem("flat", "yes");
  await new Promise(done => {
    const request = indexedDB.deleteDatabase("martensite");
    request.onsuccess = request.onerror = request.onblocked = done;
  });
}"""
"""Forget all that the page keeps in the browser."""
SCREEN: ViewportSize = {"width": 1280, "height": 800}


@pytest.fixture(scope="package")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with running(tmp_path_factory.mktemp("bench")) as made:
        yield made


@pytest.fixture(scope="package")  # its event loop would stop tests of other folders that start one
def chromium() -> Iterator[Browser]:
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS))
        yield browser
        browser.close()


@dataclass
class Tab:
    """A tab that keeps its process and its compiled scripts, and forgets everything else from test to test."""

    context: BrowserContext
    page: Page
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def watch(self) -> None:
        """Note what the page writes to its console, and its requests."""
        self.page.on("console", lambda m: self.said.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.set_default_timeout(PATIENCE)

    def empty(self, origin: str, flat: bool = True) -> None:
        """Forget what a test left behind."""
        for other in self.context.pages:
            if other is not self.page:
                other.close()
        self.page.goto(f"{origin}/icon.svg")
        self.page.evaluate(EMPTY, flat)
        self.page.set_viewport_size(SCREEN)
        self.page.emulate_media(color_scheme="light", reduced_motion="reduce")
        self.page.mouse.move(0, 0)
        self.context.clear_permissions()
        self.said.clear()
        self.asked.clear()

    def check(self) -> None:
        """Check that nothing was written to the console and nobody outside was asked."""
        assert [text for text in self.said if DRAWN_BY_PROCESSOR not in text] == []
        assert [url for url in self.asked if (urlsplit(url).hostname or "") not in LOCAL] == []


@pytest.fixture(scope="package")
def tab(chromium: Browser) -> Iterator[Tab]:
    context = chromium.new_context(viewport=SCREEN, accept_downloads=True, reduced_motion="reduce")
    context.add_init_script(FLAT)
    made = Tab(context, context.new_page())
    made.watch()
    yield made
    context.close()


@pytest.fixture
def flat() -> bool:
    """Whether the mechanism is drawn from the side; files about the picture in space override it."""
    return True


@pytest.fixture
def place() -> str:
    """Place in the page that a test begins at; files about another place override it."""
    return OPENED


@pytest.fixture
def page(tab: Tab, bench: Bench, flat: bool, place: str) -> Iterator[Page]:
    """A page that holds the token, in an empty browser, on a screen of 1280 by 800."""
    tab.empty(bench.origin, flat)
    tab.page.goto(f"{bench.address}#/{place}")
    yield tab.page
    tab.check()


@pytest.fixture
def clicks(page: Page) -> Callable[[], int]:
    """The page with the questions; returns the number of clicks since then."""
    page.goto(f"{page.url.partition('#')[0]}#/start")
    expect(page.get_by_role("main").get_by_role("listitem")).to_have_count(6)
    page.evaluate("window.clicks = 0; addEventListener('click', () => (window.clicks += 1), true)")
    return lambda: page.evaluate("window.clicks")
