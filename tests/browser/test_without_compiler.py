"""Live mode and sliders on a machine without a compiler: the page runs the modules of the package.

Source of truth: the columns of `martensite run`.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from app_server import Bench, running
from playwright.sync_api import Page, expect

from martensite.app.documents import build_packaged, list_standalone

WARM = "low => Number(document.querySelector('.scene-values').innerText.match(/([\\d.]+) °C/)[1]) > low"
NO_ZIG = "import sys\nsys.modules['ziglang'] = None\n"


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """A bench that finds no compiler."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "sitecustomize.py").write_text(NO_ZIG)
    surroundings = {"PATH": "", "CC": "", "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    with running(folder / "files", environment=surroundings) as made:
        yield made


@pytest.fixture
def bench(bare: Bench) -> Bench:
    return bare


@pytest.fixture
def place() -> str:
    return "start"


def open_door(page: Page, name: str) -> None:
    page.locator("a.door", has_text=name).click()
    expect(page.locator(".bench-title h1")).not_to_have_text("Bench")


@pytest.mark.parametrize("door", ["Lift a weight", "Bend a finger"])
def test_live_moves_without_a_compiler(page: Page, door: str) -> None:
    open_door(page, door)
    page.get_by_role("button", name="Live").click()
    expect(page.get_by_role("region", name="Running by hand")).to_be_visible()
    page.keyboard.down("h")
    page.wait_for_function(WARM, arg=40)
    page.keyboard.up("h")
    page.get_by_role("button", name="Pause").click()


def test_a_slider_runs_in_the_page_once_the_model_is_there(page: Page) -> None:
    """Once the page has the model, a move asks no server for its run, and has the steps of `martensite run`."""
    open_door(page, "Lift a weight")
    about, field = page.locator(".bench-title"), page.locator("#form-mechanism-mass")
    lanes: list[str] = []
    page.on("request", lambda request: lanes.append(request.headers.get("x-lane", "").rpartition(" ")[2]))
    with page.expect_response("**/api/call/model"):
        field.fill("320")
        field.press("Enter")
    # The page reads the model after its answer has come: moves before that ask the server, and are as right.
    for mass in range(330, 430, 10):
        lanes.clear()
        before = page.inner_text(".measures")
        field.fill(str(mass))
        field.press("Enter")
        expect(page.locator(".measures")).not_to_have_text(before, use_inner_text=True)
        result = build_packaged(list_standalone()["dead_weight"], {"mechanism.mass": f"{mass} g"}).run()
        expect(about).to_contain_text(f"{len(result.times)} samples, {result.steps} steps")
        if "run" not in lanes:
            return
    pytest.fail("the server was asked for each of ten runs")
