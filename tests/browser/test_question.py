"""The way of a newcomer: a question, a few sliders, large numbers, and what would help; on small screens too."""

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Locator, Page, expect

ABOVE = """(names) => names.map((name) => document.querySelector(name).getBoundingClientRect().bottom)"""
WIDE = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture
def flat() -> bool:
    return False


def measure(page: Page, name: str) -> Locator:
    return page.locator(".measure").filter(has=page.locator("dt", has_text=name))


def number(page: Page, name: str) -> float:
    return float(measure(page, name).locator("strong").inner_text())


def test_why_it_is_slow_to_cool_and_what_would_help(page: Page, clicks: Callable[[], int]) -> None:
    page.get_by_role("link", name="Lift a weight").click()
    sentence = page.get_by_role("region", name="What limits this run")
    expect(sentence).to_contain_text(re.compile(r"Cooling takes \d+\s% of the cycle"))
    promise = page.locator(".insight-promise")
    expect(promise).to_contain_text(re.compile(r"return in about [\d.]+\ss, [\d.]+\stimes as fast"))
    page.get_by_role("button", name="What would help?").click()

    up, down = number(page, "Time up"), number(page, "Time down")
    share = float(re.findall(r"takes (\d+)\s%", sentence.inner_text())[0])
    assert abs(share - 100 * down / (up + down)) <= 1.0
    own, thinner = (page.get_by_role("row", name=re.compile(name)) for name in ("This run", "Four parallel wires"))
    expect(thinner).to_be_visible()
    assert clicks() <= 2
    before, after = ([cell.inner_text() for cell in row.get_by_role("cell").all()] for row in (own, thinner))
    said = float(re.findall(r"([\d.]+)\stimes as fast", promise.inner_text())[0])
    slow, fast = (float(cells[3].split()[0]) for cells in (before, after))
    assert abs(said - slow / fast) <= 0.1
    stress = [float(cells[5].split()[0]) for cells in (before, after)]
    assert abs(stress[0] - stress[1]) <= 0.01 * stress[0], "four wires of half the diameter carry the same stress"

    bottoms = page.evaluate(ABOVE, [".measures", ".insight"])
    assert all(bottom <= 800 for bottom in bottoms)
    page.get_by_role("button", name="What would help?").click()
    for width, height in ((1280, 800), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(100)
        assert max(page.evaluate(ABOVE, [".scene-view", ".planes", ".player"])) <= height


def test_numbers_follow_the_sliders_on_top_and_are_compared(page: Page) -> None:
    expect(page.get_by_role("group", name="Controls on top").locator(".form-row")).to_have_count(5)
    before = number(page, "Time down")
    page.get_by_role("button", name="Pin this run").click()
    ambient = page.get_by_label("Ambient temperature", exact=True)
    ambient.fill("12")
    ambient.press("Enter")
    change = measure(page, "Time down").locator(".change")
    expect(change).to_contain_text("▼")
    expect(change).to_have_class(re.compile("better"))
    assert number(page, "Time down") < before
    page.get_by_role("button", name="Take diameter off the top").click()
    expect(page.get_by_label("Diameter", exact=True)).to_have_count(0)
    page.get_by_role("button", name="All parameters").click()
    page.get_by_role("button", name="Keep diameter on top").click()
    expect(page.get_by_role("group", name="Controls on top").get_by_label("Diameter", exact=True)).to_be_visible()


def test_on_a_phone_results_come_first_and_controls_are_a_sheet(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    expect(page.locator(".measures")).to_be_in_viewport()
    slider = page.get_by_label("heating power, slider")
    expect(slider).not_to_be_visible()
    page.get_by_role("button", name="Change something …").click()
    expect(slider).to_be_in_viewport()
    expect(page.locator(".measures strong").first).to_be_in_viewport()
    page.get_by_role("button", name="Close controls").click()
    expect(slider).not_to_be_visible()
    assert page.evaluate(WIDE) == 0
    menu = page.get_by_role("button", name="Bench, other pages")
    menu.click()
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Size").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Size")
    expect(page.get_by_role("navigation", name="Pages")).not_to_be_visible()
    box = page.locator("header.frame").bounding_box()
    assert box and box["height"] <= 50


def test_an_exceeded_limit_replaces_the_advice_and_offers_changes_that_keep_it(page: Page) -> None:
    page.goto(f"{page.url.partition('#')[0]}#/start")
    page.get_by_role("link", name="Lift a weight").click()
    expect(page.locator(".insight")).to_be_visible()
    mass = page.get_by_label("Mass", exact=True)
    mass.fill("500")
    mass.press("Enter")
    danger = page.get_by_role("region", name="Exceeded limits")
    expect(danger).to_contain_text("Too much stress")
    expect(page.locator(".insight")).to_have_count(0)
    cures = danger.get_by_role("list", name="Changes that keep the limit").get_by_role("listitem")
    expect(cures).to_have_count(2)  # the stress of a hanging weight does not depend on the heat
    promised = float(re.findall(r"peak stress ([\d.]+)", cures.nth(0).inner_text())[0])
    cures.nth(0).get_by_role("button").click()
    expect(danger).to_have_count(0)
    assert number(page, "Peak stress") == promised < 172.0
