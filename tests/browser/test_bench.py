"""The bench in a browser."""

from playwright.sync_api import Page, expect


def test_it_opens_with_a_run(page: Page) -> None:
    expect(page.get_by_role("heading", level=1)).not_to_have_text("Bench")
    expect(page.get_by_text("steps in")).to_be_visible()
