"""The mechanism in space: it plays, it scrubs, it rests, and it does without WebGL."""

from __future__ import annotations

import json
import re
import struct
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from app_server import Bench
from playwright.sync_api import Locator, Page, expect

from martensite.cli.commands.web_bench import pack_text

EXAMPLES = Path(__file__).parents[2] / "examples"
Opened = Callable[[str], Locator]


def shortened(text: str) -> str:
    """A scenario whose run takes no time, by another title than that which the page opens with."""
    text = re.sub(r'^title = ".*"', 'title = "Short run"', text, flags=re.MULTILINE)
    text = re.sub(r'duration = "\d+ s"', 'duration = "6 s"', text)
    return re.sub(r"samples = \d+", "samples = 121", text)


@pytest.fixture
def flat() -> bool:
    return False


def short_example(name: str) -> str:
    """The text of a packaged example, shortened."""
    return shortened((EXAMPLES / f"{name}.toml").read_text("utf-8"))


def put_on_bench(page: Page, text: str) -> None:
    """By the address, once the page has written there what it shows now."""
    page.wait_for_function(
        """async () => {
          const before = location.hash;
          await new Promise(done => setTimeout(done, 450));
          return location.hash === before;
        }"""
    )
    page.evaluate("letters => location.hash = `#/bench?scenario=${letters}`", pack_text(text))


@pytest.fixture
def place() -> str:
    return "start"


@pytest.fixture
def opened(page: Page) -> Opened:
    """Puts an example on the bench; answers with its view, once that is drawn."""

    def put(name: str) -> Locator:
        text = short_example(name)
        page.evaluate("letters => location.hash = `#/bench?scenario=${letters}`", pack_text(text))
        title = tomllib.loads(text)["title"]
        expect(page.get_by_role("heading", level=1)).to_have_text(title)
        view = page.locator(".scene-view")
        expect(view).to_have_attribute("data-rendered", re.compile(r"[1-9]"))
        expect(view).to_have_attribute("data-time", "0")
        return view

    return put


def scrub(page: Page, share: float) -> None:
    page.locator(".player input[type=range]").evaluate(
        "(e, s) => { e.value = String(+e.max * s); e.dispatchEvent(new Event('input', { bubbles: true })); }", share
    )


def rendered(view: Locator) -> int:
    return int(view.get_attribute("data-rendered") or 0)


def drawn_at(view: Locator) -> float:
    return float(view.get_attribute("data-time") or -1.0)


def seen_at(page: Page, view: Locator, share: float) -> bytes:
    """What the view looks like once it shows a share of the run of 6 s."""
    scrub(page, share)
    page.wait_for_function(
        "time => Math.abs(document.querySelector('.scene-view').dataset.time - time) < 0.02", arg=6 * share
    )
    return settled(page, view)


def seen_moved(page: Page, view: Locator, share: float, before: bytes) -> bytes:
    """Return the picture at a share of the run once it differs from another one: a busy page draws late."""
    for _ in range(20):
        if (now := seen_at(page, view, share)) != before:
            return now
    raise AssertionError("the picture does not move")


def settled(page: Page, view: Locator) -> bytes:
    """What it looks like once nothing more is drawn: the page may still have been growing."""
    page.wait_for_function(
        """async () => {
          const { dataset } = document.querySelector('.scene-view');
          const before = dataset.rendered;
          await new Promise(done => setTimeout(done, 250));
          return dataset.rendered === before;
        }"""
    )
    return view.screenshot()


@pytest.mark.parametrize(
    "name", ["constant_power", *(pytest.param(n, marks=pytest.mark.slow) for n in ("hand", "closed_loop_platform"))]
)
def test_what_is_drawn_moves_with_the_cursor(page: Page, opened: Opened, name: str) -> None:
    view = opened(name)
    seen_moved(page, view, 0.75, seen_at(page, view, 0.0))


def test_it_moves_with_the_cursor_plays_and_pauses(page: Page, opened: Opened) -> None:
    view = opened("finger")
    before = seen_moved(page, view, 0.7, seen_at(page, view, 0.0))  # it is heated from 3 s on
    page.get_by_role("button", name="Play").click()
    expect(view).to_have_attribute("aria-label", re.compile(r"at (4\.[6-9]|5)"))
    page.get_by_role("button", name="Pause").click()
    assert drawn_at(view) > 4.5
    assert settled(page, view) != before


def test_it_says_what_is_under_the_pointer_and_is_taken_away_as_a_model(page: Page, opened: Opened) -> None:
    view = opened("finger")
    box = view.bounding_box()
    assert box
    label = page.locator(".scene-label.hover")
    places = [(x, y) for y in (0.2, 0.3, 0.4, 0.5) for x in (0.45, 0.55)]
    for x, y in places:
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
        settled(page, view)
        if label.count() and label.is_visible():
            break
    expect(label).to_contain_text(re.compile("phalanx|wire|spring|drum"))
    page.locator(".scene summary", has_text="Save").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="GLB").click()
    model = download.value.path().read_bytes()
    magic, version, length = struct.unpack("<4sII", model[:12])
    assert (magic, version, length) == (b"glTF", 2, len(model))
    tree = json.loads(model[20 : 20 + struct.unpack("<I", model[12:16])[0]])
    moved = {tree["nodes"][c["target"]["node"]]["name"] for c in tree["animations"][0]["channels"]}
    assert any(name.startswith("far_phalanx") for name in moved)
    assert not any(name.startswith("near_phalanx") for name in moved)


@pytest.mark.slow
def test_it_is_taken_away_as_pictures(page: Page, opened: Opened) -> None:
    """At a speed at which two pictures are the whole run."""
    opened("constant_power")
    page.get_by_label("Speed").select_option("100")
    page.locator(".scene summary", has_text="Save").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="GIF").click()
    gif = download.value.path().read_bytes()
    assert (gif[:6], gif[-1]) == (b"GIF89a", 0x3B)
    assert struct.unpack("<HH", gif[6:10]) == (640, 360)
    assert gif.count(b"\x21\xf9\x04") == 2


@pytest.mark.slow
def test_the_pinned_run_is_a_ghost(page: Page, opened: Opened) -> None:
    view = opened("constant_power")
    page.get_by_role("button", name="Pin this run").click()
    held = view.get_attribute("data-held")
    text = short_example("constant_power").replace("100 mm", "110 mm")
    count = rendered(view)
    put_on_bench(page, text)
    page.wait_for_function("n => +document.querySelector('.scene-view').dataset.rendered > n", arg=count)
    expect(view).not_to_have_attribute("data-held", str(held))


@pytest.mark.slow
def test_keys(page: Page, opened: Opened) -> None:
    view = opened("constant_power")
    before = settled(page, view)
    view.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    assert settled(page, view) != before
    page.keyboard.press("0")
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    page.locator(".player input[type=range]").focus()
    scrub(page, 0.0)
    page.keyboard.press("ArrowRight")
    expect(view).to_have_attribute("aria-label", re.compile(r"at 0\.00\d+ s"))
    page.get_by_role("button", name="One sample back").click()
    expect(view).to_have_attribute("aria-label", re.compile(r"at 0 s"))


@pytest.mark.slow
def test_colours_are_by_what_is_chosen(page: Page, opened: Opened) -> None:
    view = opened("constant_power")
    by_temperature = seen_at(page, view, 0.5)
    page.get_by_label("Colour of elements").select_option("martensite_fraction")
    expect(page.locator(".scene-legend")).to_contain_text("austenite")
    expect(view).to_have_attribute("data-time", re.compile("^3"))
    assert settled(page, view) != by_temperature


@pytest.mark.slow
def test_changed_numbers_move_what_is_there(page: Page, opened: Opened) -> None:
    """Of a run of the same structure nothing is made anew."""
    view = opened("constant_power")
    seen_at(page, view, 0.5)
    page.evaluate("document.querySelector('.scene-view canvas').dataset.mine = 'yes'")
    held = view.get_attribute("data-held")
    text = short_example("constant_power")
    for length in ("110 mm", "120 mm", "130 mm"):
        count = rendered(view)
        changed = text.replace("100 mm", length)
        put_on_bench(page, changed)
        page.wait_for_function("n => +document.querySelector('.scene-view').dataset.rendered > n", arg=count)
    expect(page.locator(".scene-view canvas[data-mine=yes]")).to_have_count(1)
    assert view.get_attribute("data-held") == held


@pytest.mark.slow
def test_without_webgl_it_is_drawn_from_the_side(page: Page, bench: Bench) -> None:
    page.evaluate("localStorage.setItem('flat', 'yes')")
    page.goto(f"{bench.origin}/#/bench?scenario={pack_text(short_example('finger'))}")
    page.reload()
    side = page.locator("svg.scene-side")
    expect(side).to_be_visible()
    expect(page.get_by_text("no WebGL")).to_be_visible()
    frame = page.locator(".scene-flat").bounding_box()
    for shape in side.locator("rect, circle, polyline").all():
        box = shape.bounding_box()
        assert frame and box and box["y"] >= frame["y"] - 1
        assert box["y"] + box["height"] <= frame["y"] + frame["height"] + 1
    before = side.inner_html()
    scrub(page, 1.0)
    expect(side).to_have_attribute("aria-label", re.compile("at 6 s"))
    assert side.inner_html() != before
