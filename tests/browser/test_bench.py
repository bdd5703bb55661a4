"""The bench in a browser."""

from app_server import Bench
from playwright.sync_api import Page, expect


def test_it_opens_with_a_weight_that_is_lifted(page: Page, bench: Bench) -> None:
    other = page.context.new_page()
    other.goto(f"{bench.address}#/bench")
    expect(other.get_by_role("heading", level=1)).to_have_text("Wire and dead weight")
    expect(other.locator(".measure").filter(has_text="Cycle rate").locator("strong")).not_to_have_text("–")
    about = other.get_by_text("steps in")
    expect(about).not_to_be_visible()
    other.get_by_role("button", name="About this run").click()
    expect(about).to_be_visible()
