"""The page in Firefox: its pages open without an error, and a slider moves the numbers of the run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from app_server import Bench
from firefox_browser import Firefox, find_firefox, run_firefox

from martensite.app.documents import list_standalone
from martensite.cli.commands.web_bench import pack_text

TEXT = list_standalone()["constant_power"]
PAGES = ("start", "studies", "studies/migaone", "identify", "size", "sweep", "board", "bench")
STROKE = "document.querySelector('.measure strong')?.innerText"
SLIDE = """(() => {
  const range = document.querySelector(".top-controls input[type=range]");
  range.value = range.min;
  range.dispatchEvent(new Event("input", { bubbles: true }));
})()"""


@pytest.fixture(scope="module")
def firefox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Firefox]:
    program = find_firefox()
    if program is None:
        pytest.skip("no Firefox on this machine (Debian: apt-get install firefox-esr)")
    with run_firefox(program, tmp_path_factory.mktemp("profile")) as made:
        yield made


def test_every_page_opens_in_firefox_without_an_error(firefox: Firefox, bench: Bench) -> None:
    for size in ((1440, 900), (390, 844)):
        firefox.resize(*size)
        firefox.open(bench.address)
        firefox.wait_for("document.querySelector('main h1') && true")
        for name in PAGES:
            firefox.evaluate(f"void (location.hash = '#/{name}')")
            firefox.wait_for("document.querySelector('main h1')?.innerText && !document.querySelector('.starting')")
            assert firefox.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0, (name, size)
    assert [text for text in firefox.said if "WebGL" not in text] == []


def test_a_slider_moves_the_numbers_in_firefox(firefox: Firefox, bench: Bench) -> None:
    """Source of truth: the run of the server."""
    firefox.open(f"{bench.address}#/bench?scenario={pack_text(TEXT)}")
    before = firefox.wait_for(STROKE)
    run = bench.call("run", {"text": TEXT})
    assert float(before) == pytest.approx(1e3 * run["stroke"], rel=5e-3)
    firefox.wait_for("document.querySelector('.scene-view canvas, svg.scene-side') && true")
    firefox.wait_for("document.querySelector('.top-controls input[type=range]') && true")
    firefox.evaluate(SLIDE)
    after = firefox.wait_for(f"{STROKE} !== '{before}' && {STROKE}")
    assert float(after) < float(before)
