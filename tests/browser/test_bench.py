"""The bench in a browser."""

import pytest
from playwright.sync_api import Page, expect


@pytest.fixture
def place() -> str:
    return "bench"


def test_it_opens_with_a_weight_that_is_lifted(page: Page) -> None:
    expect(page.get_by_role("heading", level=1)).to_have_text("Wire and dead weight")
    expect(page.locator(".measure").filter(has_text="Cycle rate").locator("strong")).not_to_have_text("–")
    about = page.get_by_text("steps in")
    expect(about).not_to_be_visible()
    page.get_by_role("button", name="About this run").click()
    expect(about).to_be_visible()
