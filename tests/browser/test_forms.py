"""The forms of the bench in a browser: sliders, fields, kinds, documents."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, Request, expect


def diameter(page: Page):
    """Field and slider of the diameter of the wire."""
    field = page.get_by_label("Diameter", exact=True)
    expect(field).to_have_value("0.1")
    return field, page.get_by_label("diameter, slider")


MOVES = 6


def all_parameters(page: Page) -> None:
    page.get_by_role("button", name="All parameters").click()


def undo(page: Page):
    return page.get_by_role("button", name="Undo")


def test_a_move_is_one_call(page: Page) -> None:
    """The bound of the review of slow machines: 500 moves make at most 520 calls."""
    field, slider = diameter(page)
    page.get_by_role("button", name="Pin this run").click()
    expect(page.locator(".insight-promise")).not_to_be_empty()
    page.wait_for_timeout(500)
    asked: list[str] = []

    def note(one: Request) -> None:
        name = one.url.rpartition("/")[2]
        # a busy machine is asked how far a call is
        if one.url.startswith("http") and not one.headers.get("x-lane", "").endswith(" remedy") and name != "lane":
            asked.append(name)

    page.on("request", note)
    slider.focus()
    for _ in range(MOVES):
        before = page.locator(".measures").inner_text()
        page.keyboard.press("ArrowRight")
        page.wait_for_function("before => document.querySelector('.measures').innerText !== before", arg=before)
        page.wait_for_timeout(300)
    assert len(asked) <= MOVES + 1 and set(asked) <= {"run", "model", "engine.js"}
    page.get_by_text("What differs").click()
    expect(page.get_by_role("table", name="Documents")).to_contain_text("element.diameter")
    assert asked.count("differences") == 1
    expect(field).not_to_have_value("0.1")


def test_a_slider_changes_the_scenario_in_one_step(page: Page) -> None:
    field, slider = diameter(page)
    title = page.get_by_text("steps in")
    before = title.text_content()
    box = slider.bounding_box()
    assert box
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.02 * step), box["y"] + box["height"] / 2)
    page.mouse.up()
    expect(field).not_to_have_value("0.1")
    expect(title).not_to_have_text(before or "")
    expect(undo(page)).to_be_enabled()
    undo(page).click()
    expect(field).to_have_value("0.1")
    expect(undo(page)).to_be_disabled()
    page.keyboard.press("Control+y")
    expect(field).not_to_have_value("0.1")


SLOW_CALLS = """() => {
    const fetch = window.fetch.bind(window);
    window.fetch = async (...given) => {
        await new Promise((after) => setTimeout(after, 500));
        return fetch(...given);
    };
}"""


def test_undo_leaves_what_a_slider_still_waits_to_try(page: Page) -> None:
    field, slider = diameter(page)
    title = page.get_by_text("steps in")
    before = title.text_content()
    box = slider.bounding_box()
    assert box
    page.evaluate(SLOW_CALLS)
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in (1, 2, 3, 4):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.05 * step), box["y"] + box["height"] / 2)
        if step == 1:
            expect(title).not_to_have_text(before or "")
    page.mouse.up()
    undo(page).click()
    page.wait_for_timeout(2500)
    expect(field).to_have_value("0.1")
    expect(undo(page)).to_be_disabled()


def test_a_field_takes_other_units_and_keys_and_refuses_in_words(page: Page) -> None:
    field, _ = diameter(page)
    field.fill("0.004 in")
    field.press("Enter")
    expect(field).to_have_value("0.1016")
    field.press("ArrowUp")
    expect(field).to_have_value("0.1026")
    field.fill("30 mm")
    field.press("Enter")
    expect(field).to_have_attribute("aria-invalid", "true")
    fault = page.locator("#form-element-diameter-fault")
    expect(fault).to_contain_text("at most 20 mm")
    expect(page.locator(".measures")).to_be_visible()
    field.press("Escape")
    expect(fault).to_have_count(0)
    expect(field).to_have_value("0.1026")


@pytest.mark.slow
def test_a_search_finds_by_meaning_and_what_the_material_gives_comes_back(page: Page) -> None:
    diameter(page)
    all_parameters(page)
    page.get_by_label("Find a parameter").fill("modulus austenite")
    field = page.locator("#form-element-law-E_A")
    expect(field).to_have_value("75")
    expect(page.locator("#form-element-law-E_M")).to_have_count(0)
    field.fill("60")
    field.press("Enter")
    row = page.locator(".form-row", has=field)
    expect(row.get_by_text("changed", exact=True)).to_be_attached()
    row.get_by_role("button", name="About E A").click()
    page.get_by_role("button", name="Use the material's 75 GPa").click()
    expect(field).to_have_value("75")
    expect(row.get_by_text("datasheet, material flexinol-90")).to_be_visible()


@pytest.mark.slow
def test_kinds_change_the_form_and_whole_examples_come(page: Page) -> None:
    diameter(page)
    all_parameters(page)
    law = page.locator("#form-element-law-kind")
    law.select_option("brinson")
    expect(page.get_by_text("Assumed start values")).to_be_visible()
    page.locator("#form-mechanism-kind").select_option("finger")
    expect(page.get_by_text("whole packaged scenario")).to_be_visible()
    expect(page.get_by_role("heading", level=1)).to_have_text("Robotic finger, 2 W")
    undo(page).click()
    expect(law).to_have_value("brinson")


def test_documents_are_opened_edited_and_refused(page: Page, tmp_path: Path) -> None:
    diameter(page)
    heading = page.get_by_role("heading", level=1)
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    page.get_by_label("Scenario file").set_input_files(tmp_path / "binary.toml")
    expect(page.get_by_text("is not text in UTF-8")).to_be_visible()
    page.get_by_label("Scenario", exact=True).last.select_option("platform_spring")
    expect(heading).to_have_text("Platform spring lifting 300 g")
    page.get_by_role("button", name="New").click()
    expect(heading).to_have_text("Wire and dead weight")
    page.get_by_role("button", name="Text …").click()
    text = page.get_by_role("dialog").get_by_role("textbox")
    whole = text.input_value()
    text.fill(whole.replace("dead-weight", "dead-wait"))
    page.get_by_role("button", name="Apply").click()
    expect(page.get_by_role("dialog").get_by_role("alert")).to_contain_text("Did you mean dead-weight?")
    text.fill(whole.replace("Wire and dead weight", "My own"))
    page.get_by_role("button", name="Apply").click()
    expect(heading).to_have_text("My own")
    (tmp_path / "mine.toml").write_text(whole.replace("300 g", "200 g"), "utf-8")
    page.get_by_label("Scenario file").set_input_files(tmp_path / "mine.toml")
    expect(page.get_by_label("Mass", exact=True)).to_have_value("200")
