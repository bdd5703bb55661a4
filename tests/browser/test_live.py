"""Running by hand in the page: a controller fights the load, and a position held by hand has a score."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

AUDIT = (Path(__file__).parent / "audit.js").read_text("utf-8")
READ = "document.querySelector('.live-strip strong')?.innerText"
SET = """(range, share) => {
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  set.call(range, Number(range.min) + share * (range.max - range.min));
  range.dispatchEvent(new Event("input", { bubbles: true }));
}"""


def run_by_hand(page: Page, door: str, title: str) -> None:
    page.evaluate("location.hash = '#/start'")
    page.get_by_role("link", name=door).click()
    live = page.get_by_role("button", name="Live", exact=True)
    expect(live).to_be_enabled()
    expect(page.get_by_role("heading", level=1)).to_have_text(title)
    live.click()
    page.get_by_role("region", name="Running by hand").wait_for()
    assert page.evaluate(AUDIT) == []


@pytest.mark.slow
def test_a_controller_fights_the_load_that_is_pulled(page: Page) -> None:
    run_by_hand(page, "Hold a position", "Position of a wire under PID control")
    page.wait_for_function(f"() => Math.abs({READ} - 3) < 0.1")
    preload = page.get_by_label("Preload of the spring")
    preload.evaluate(SET, 0.8)
    page.wait_for_function(f"() => {READ} < 2.8")  # the pull stretches the wire
    page.wait_for_function(f"() => Math.abs({READ} - 3) < 0.1")  # the controller heats
    page.get_by_role("slider", name="Set point", exact=True).evaluate(SET, 0.5)
    page.wait_for_function(f"() => Math.abs({READ} - 2) < 0.1")
    page.get_by_role("button", name="Pause", exact=True).click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("by hand")


@pytest.mark.slow
def test_a_position_held_by_hand_has_a_score_that_can_be_shared(page: Page) -> None:
    """25 s of the clock, without heat: the score of a wire that stays cold is 0."""
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    run_by_hand(page, "Lift a weight", "Wire and dead weight")
    page.get_by_role("button", name="Challenge: hold 3 mm by hand").click()
    score = page.get_by_role("region", name="Score")
    expect(score).to_contain_text(re.compile(r"^0 of 100 points"))
    score.locator("summary", has_text="Share").click()
    score.get_by_role("button", name="Copy text").click()
    expect(score.get_by_text("Copied.")).to_be_visible()
    text = page.evaluate("navigator.clipboard.readText()")
    assert "I held 3 mm by hand: 0 of 100 points" in text and "#/bench?scenario=" in text and "token" not in text
    with page.expect_download() as saved:
        score.get_by_role("button", name="Save picture").click()
    assert saved.value.path().read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
