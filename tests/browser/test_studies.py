"""The pages of studies in a browser: a study computed, read, and found again."""

import re

import pytest
from playwright.sync_api import Page, expect

QUICK = "wire-heating"
LONG = "hammerstein-wiener"


@pytest.fixture
def place() -> str:
    return "start"


def visit(page: Page, place: str) -> None:
    page.evaluate("place => { location.hash = place; }", f"#/{place}")


@pytest.mark.slow
def test_studies_are_listed_and_lead_to_their_pages(page: Page) -> None:
    visit(page, "studies")
    expect(page.get_by_role("heading", level=2)).to_have_count(8)
    page.get_by_role("link", name="Sommerfeld effect").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Sommerfeld effect")
    guide = page.get_by_role("region", name="Guide")
    expect(guide).to_contain_text("This is a fit, not a prediction")
    guide.get_by_text("Sources").click()
    expect(guide).to_contain_text("Universidade Tecnológica Federal do Paraná")


def test_a_study_runs_and_its_claims_are_read(page: Page) -> None:
    visit(page, f"studies/{QUICK}")
    expect(page.get_by_role("region", name="Digest")).to_contain_text("use instead")  # it came with the study
    picture = page.get_by_role("img", name="Steady temperatures").first
    expect(picture).to_be_visible()
    assert picture.evaluate("image => image.decode().then(() => image.naturalWidth)") > 300
    pairs = page.get_by_role("region", name="Printed and computed values", exact=True).locator("li")
    expect(pairs.first).to_contain_text("misprint")  # errors in print come first
    expect(pairs.first).to_contain_text("paper 13 Ω")
    address = page.get_by_role("region", name="Address").locator("code").inner_text()
    assert address == f"{page.url.split('#')[0]}#/studies/{QUICK}" and "token" not in address
    page.get_by_role("button", name="Compute again").click()
    expect(page.get_by_role("progressbar")).to_be_visible()
    expect(page.get_by_text("the results are stored")).to_be_visible()
    claims = page.get_by_role("region", name="Claims", exact=True)
    rows = claims.locator("tbody tr")
    expect(rows).to_have_count(9)
    button = claims.get_by_role("button", name="self-contradictory")
    expect(button).to_contain_text("↯")
    button.click()
    expect(rows).to_have_count(int(re.findall(r"\d+", button.inner_text())[0]))
    claims.get_by_label("Find").fill("1.3 V")
    expect(rows.first).to_contain_text("1.3 V")
    claims.get_by_role("button", name="Published").click()
    expect(claims.get_by_role("columnheader", name="Published")).to_have_attribute("aria-sort", "ascending")
    claims.get_by_label("Find").fill("no such words")
    expect(rows).to_have_count(0)

    # a second visit is immediate: the results are kept, the list has the tally
    visit(page, "studies")
    expect(page.locator(".tally").first).to_contain_text("reproduced")
    page.reload()
    visit(page, f"studies/{QUICK}")
    expect(claims.locator("tbody tr")).to_have_count(9)
    page.get_by_role("button", name="Enlarge").last.click()
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()


def test_a_scenario_of_a_study_opens_on_the_bench(page: Page) -> None:
    visit(page, f"studies/{QUICK}")
    page.get_by_role("button", name="Open in bench: Kossoski's wire, closure B").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("closure B")
    expect(page).to_have_url(re.compile("#/bench"))


def test_work_survives_a_reload_and_is_cancelled(page: Page) -> None:
    visit(page, f"studies/{LONG}")
    page.get_by_role("button", name="Compute again").click()
    expect(page.get_by_role("progressbar")).to_be_visible()
    expect(page.get_by_text("part 1 of 3: open loop")).to_be_visible()
    page.reload()
    expect(page.get_by_text("part 1 of 3: open loop")).to_be_visible()
    visit(page, f"studies/{QUICK}")  # another page tells of it, and begins nothing beside it
    expect(page.get_by_text(f"Computing {LONG}")).to_be_visible()
    expect(page.get_by_role("button", name=re.compile("^Compute (again|claims)"))).to_have_count(0)
    page.get_by_role("button", name="Cancel").click()
    visit(page, f"studies/{LONG}")
    expect(page.get_by_text("Cancelled.", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Compute again")).to_be_visible()


def test_data_that_are_missing_are_named(page: Page) -> None:
    visit(page, "studies/electrothermal-staircase")
    expect(page.get_by_role("button", name=re.compile("^Compute (again|claims)"))).to_be_visible()
    if page.get_by_text("not on this machine").count() == 0:
        pytest.skip("the data set is on this machine")
    expect(page.get_by_text("martensite data fetch flexinol-electrothermal")).to_be_visible()
