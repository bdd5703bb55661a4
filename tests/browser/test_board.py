"""The page of boards in a browser: a dry run, an armed one on an emulated board, stopped; its log goes to Identify."""

import re

import pytest
from playwright.sync_api import Page, expect

pytest.importorskip("martensite.boards", reason="boards are a distribution of their own")
from martensite.boards.live_run import find_missing


@pytest.fixture
def place() -> str:
    return "board"


@pytest.mark.skipif(find_missing() != "", reason=find_missing())
def test_a_board_is_watched_armed_by_a_word_and_stopped(page: Page) -> None:
    expect(page.get_by_text("nothing real is heated")).to_be_visible()
    page.get_by_label("Duration").fill("0.1")
    page.get_by_role("button", name="Dry run").click()
    expect(page.get_by_text("Dry run: nothing was armed.")).to_be_visible()

    page.get_by_label("duty-cycle levels").check()
    page.get_by_label("Time:duty").fill("300 s:0.3")
    page.get_by_label("Type ARM").fill("arm")
    expect(page.get_by_role("button", name="Dry run")).to_be_disabled()  # it is another word
    page.get_by_label("Type ARM").fill("ARM")
    page.get_by_role("button", name="Arm and run").click()
    expect(page.get_by_label("Type ARM")).to_have_value("")  # each run asks for it anew
    expect(page.get_by_text("ARMED", exact=True)).to_be_visible()
    expect(page.get_by_role("application", name="Temperature over time")).to_be_visible()
    page.get_by_role("button", name="Stop and disarm").click()
    expect(page.get_by_text("The board is disarmed and says so.")).to_be_visible()
    expect(page.get_by_text("Stopped.")).to_be_visible()
    expect(page.get_by_label("Link")).to_contain_text(re.compile(r"frames\d+lost0doubled0garbled0"))
    with page.expect_download() as taken:
        page.get_by_role("button", name="Download log").click()
    text = taken.value.path().read_text("utf-8")
    assert "# scenario: " in text and "duty" in text and ",0.3" in text
    page.get_by_role("button", name="Open in Identify").click()
    expect(page.get_by_role("heading", name=re.compile("log_uno.csv"))).to_be_visible()


@pytest.mark.skipif(find_missing() == "", reason="all tools of the emulator are installed")
def test_an_emulator_without_its_tools_is_disabled_with_the_reason(page: Page) -> None:
    expect(page.get_by_text(find_missing())).to_be_visible()
    emulator = page.get_by_label("Port").get_by_role("option", name=re.compile("emulator"))
    expect(emulator).to_have_attribute("disabled", "")
    expect(page.get_by_role("button", name="Dry run")).to_be_disabled()
