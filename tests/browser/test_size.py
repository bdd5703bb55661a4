"""The page of sizing in a browser: a request typed, wires found, one opened on the bench."""

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

SMALL = "force=0.5+N&stroke=3+mm&rate=0.2+Hz&supply=5+V&alloy=90"


@pytest.fixture
def place() -> str:
    return "start"


def visit(page: Page, place: str) -> None:
    page.evaluate("place => { location.hash = place; }", f"#/{place}")


def test_a_wrong_unit_is_refused_beside_its_field(page: Page) -> None:
    visit(page, "size")
    page.get_by_role("button", name="Example").click()
    page.get_by_label("rate").fill("0.5 kgf")
    page.get_by_label("supply").focus()
    expect(page.get_by_role("alert")).to_have_text("The unit `kgf` cannot be converted to `Hz`.")
    expect(page.get_by_label("rate")).to_have_attribute("aria-invalid", "true")
    page.get_by_label("rate").fill("0.05 Hz")
    page.get_by_role("textbox", name="force").fill("0.8 kgf")
    page.get_by_label("supply").focus()
    expect(page.get_by_role("alert")).to_have_count(0)
    expect(page).to_have_url(re.compile(r"force=0\.8\+kgf"))
    page.get_by_role("textbox", name="force").fill("")
    page.get_by_role("button", name="Find wires").click()
    expect(page.get_by_role("alert")).to_have_text("Fill in `force` first.")


def test_a_wish_becomes_a_wire_in_two_clicks(page: Page, clicks: Callable[[], int]) -> None:
    page.get_by_role("link", name="Which wire?").click()
    expect(page.get_by_role("textbox", name="force")).to_have_value("8 N")  # the form writes its wish to the address
    visit(page, f"size?{SMALL}")  # as typed into the form
    expect(page.get_by_role("textbox", name="force")).to_have_value("0.5 N")
    page.get_by_role("button", name="Find wires").click()
    expect(page.get_by_role("progressbar")).to_be_visible()
    wires = page.get_by_role("region", name="Wires", exact=True)
    expect(wires.get_by_text("wires meet the request, best first.")).to_be_visible()
    expect(wires.get_by_text("✗ no")).to_have_count(0)
    chosen = page.get_by_role("region", name="Chosen wire")
    expect(chosen.get_by_role("heading")).to_have_text("1: 0.10 mm, 90 °C")
    expect(chosen.get_by_role("img", name=re.compile("^Circuit: 5 V"))).to_be_visible()
    assert clicks() <= 2
    wires.get_by_label("Show rejected wires").check()
    expect(wires.locator("tbody tr.choosable")).to_have_count(12)
    expect(wires.get_by_text("too slow").first).to_be_visible()

    wires.get_by_role("button", name="Show wire 2:").press("Enter")
    expect(chosen.get_by_role("heading")).to_contain_text("2: ")
    expect(chosen.get_by_role("row", name=re.compile("^stress .* of 172 MPa"))).to_be_visible()
    wires.locator("tr.reason").last.click()
    expect(chosen.get_by_text("Not met:").first).to_be_visible()

    page.get_by_role("textbox", name="force").fill("0.6 N")
    expect(page.get_by_text("these wires are for force 0.5 N")).to_be_visible()
    page.reload()  # the form is in the address, and the job is found again
    expect(page.get_by_role("textbox", name="force")).to_have_value("0.6 N")
    expect(page.get_by_text("wires meet the request, best first.")).to_be_visible()


@pytest.mark.slow
def test_a_wire_is_saved_and_opened_on_the_bench(page: Page) -> None:
    visit(page, f"size?{SMALL}")
    page.get_by_role("button", name="Find wires").click()
    chosen = page.get_by_role("region", name="Chosen wire")
    expect(chosen).to_be_visible()
    with page.expect_download() as saving:
        chosen.get_by_role("button", name="Save scenario").click()
    assert saving.value.suggested_filename == "flexinol-0.10mm-90.toml"
    assert "[mechanism]" in saving.value.path().read_text("utf-8")
    chosen.get_by_role("button", name="Open in bench").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Flexinol 0.10 mm, 90 °C")


@pytest.mark.slow
def test_a_cancelled_sizing_shows_what_it_has(page: Page) -> None:
    visit(page, f"size?{SMALL.replace('&alloy=90', '')}")
    page.get_by_role("button", name="Find wires").click()
    expect(page.get_by_text(re.compile(r"Simulating wires: [1-9]"))).to_be_visible()
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_text(re.compile(r"Cancelled: \d+ of 24 wires"))).to_be_visible()


@pytest.mark.slow
def test_the_model_stands_beside_the_makers_table(page: Page) -> None:
    visit(page, "size?tab=catalogue&alloy=90&stress=150+MPa")
    page.get_by_role("button", name="Compare").click()
    expect(page.get_by_role("progressbar")).to_be_visible()
    check = page.get_by_role("region", name="Check of the catalogue")
    expect(check).to_contain_text("load 150 MPa")
    expect(check.locator("tbody tr")).to_have_count(12)
    expect(page).to_have_url(re.compile("tab=catalogue"))
