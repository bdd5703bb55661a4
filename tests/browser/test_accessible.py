"""Every page for those who use a keyboard, hear it read, or see badly: checked in the browser."""

from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

PAGES = ("start", "bench", "studies", "identify", "size", "sweep", "board")
AUDIT = (Path(__file__).parent / "audit.js").read_text("utf-8")
SCREENS = {"desk": (1280, 800), "tablet": (1024, 768), "phone": (390, 844)}
NAMED = {
    "button",
    "link",
    "textbox",
    "combobox",
    "slider",
    "spinbutton",
    "checkbox",
    "radio",
    "tab",
    "menuitem",
    "listbox",
    "switch",
    "progressbar",
    "region",
    "image",
    "searchbox",
    "figure",
}
"""Roles whose parts must be called something."""
FOCUS = """() => {
  const one = document.activeElement;
  if (!one || one === document.body) return null;
  const style = getComputedStyle(one);
  window.auditIds ??= new Map();
  if (!window.auditIds.has(one)) window.auditIds.set(one, window.auditIds.size);
  const box = one.getBoundingClientRect();
  return {
    id: window.auditIds.get(one), what: one.outerHTML.slice(0, 120),
    seen: style.boxShadow !== "none"
      || (style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0),
    within: box.bottom > 0 && box.top < innerHeight,
  };
}"""
REACHED = """() => [...document.querySelectorAll(
  "a[href], button, input:not([type=hidden]), select, textarea, summary, [tabindex]")]
  .filter((one) => one.tabIndex >= 0 && !one.disabled && one.type !== "radio"
    && one.checkVisibility({visibilityProperty: true}) && !window.auditIds.has(one))
  .map((one) => one.outerHTML.slice(0, 120))"""
MOST_TABS = 400
SETTLED = """async () => {
  const count = () => performance.getEntriesByType("resource").length + document.querySelectorAll("*").length;
  for (let before = -1; before !== count(); await new Promise((done) => setTimeout(done, 250))) before = count();
}"""


@pytest.fixture
def flat() -> bool:
    return False


@pytest.fixture
def place() -> str:
    return "start"


def opened(page: Page, name: str) -> None:
    """Go to a page and wait until what it asks for is there and drawn."""
    page.evaluate("name => { location.hash = `#/${name}`; }", name)
    page.evaluate(SETTLED)
    expect(page.get_by_text("Loading")).to_have_count(0)
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    page.evaluate(SETTLED)


def unnamed(page: Page) -> list[str]:
    """Parts without a name, as the browser tells them to a screen reader."""
    session = page.context.new_cdp_session(page)
    nodes: list[dict[str, Any]] = session.send("Accessibility.getFullAXTree")["nodes"]
    session.detach()
    found: list[str] = []
    for node in nodes:
        role = node.get("role", {}).get("value", "")
        if role in NAMED and not node["ignored"] and not node.get("name", {}).get("value"):
            found.append(f"{role} without a name: {node.get('properties', [])[:3]}")
    return found


def list_violations(page: Page) -> list[str]:
    """What axe-core finds: its rules for WCAG 2.2 AA and good practice."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(Axe().axe_script)
    found = page.evaluate("axe.run({resultTypes: ['violations']})")["violations"]
    return [f"{one['id']}: {node['html'][:120]}" for one in found for node in one["nodes"]]


def resize(page: Page, screen: str) -> None:
    """Give the page the size of a screen."""
    width, height = SCREENS[screen]
    page.set_viewport_size({"width": width, "height": height})


def list_faults(page: Page) -> dict[str, list[str]]:
    """Return the faults of each screen by the audit script, and those of names and axe-core."""
    faults: dict[str, list[str]] = {}
    for screen in SCREENS:
        resize(page, screen)
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        faults[screen] = page.evaluate(AUDIT)
    return {**faults, "names": unnamed(page), "axe": list_violations(page)}


@pytest.mark.parametrize("theme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_pages_have_no_faults(page: Page, theme: str) -> None:
    if theme == "dark":
        page.get_by_role("button", name="Switch to dark").click()
    found: dict[str, dict[str, list[str]]] = {}
    for name in (*PAGES, "studies/migaone"):
        resize(page, "desk")
        opened(page, name)
        found[name] = {where: faults for where, faults in list_faults(page).items() if faults}
    assert {name: faults for name, faults in found.items() if faults} == {}


def test_all_is_reached_by_keyboard_and_seen(page: Page) -> None:
    for name in PAGES:
        opened(page, name)
        walk_by_keyboard(page)


def walk_by_keyboard(page: Page) -> None:
    page.evaluate("window.auditIds = new Map(); document.activeElement.blur()")
    visited: list[int] = []
    for _ in range(MOST_TABS):
        page.keyboard.press("Tab")
        at = page.evaluate(FOCUS)
        if at is None:
            continue  # between the last part and the first
        if at["id"] in visited:
            break
        visited.append(at["id"])
        assert at["seen"], f"the focus is not seen on {at['what']}"
        assert at["within"], f"the focus is outside of the screen on {at['what']}"
    assert page.evaluate(REACHED) == []


def test_the_audit_notices_faults(page: Page) -> None:
    opened(page, "size")
    page.evaluate("""() => {
      const made = document.createElement("div");
      made.innerHTML = `<h5>Deep</h5><p id="page" style="color:#aaa;background:#fff">Pale</p>
        <button style="height:10px;min-height:0;padding:0"></button>
        <label for="none">x</label><img src="icon.svg"><div style="width:3000px">wide</div>
        <select style="width:90px"><option>A long choice</option></select>
        <a href="#x" tabindex="3">first</a>`;
      document.querySelector("main").append(made);
    }""")
    faults = " | ".join(page.evaluate(AUDIT))
    for words in (
        "the id page",
        "after a heading",
        "contrast of 2.3",
        "by 10 px",
        "by for to none",
        "has no alt",
        "too wide",
        "cuts “A long choice”",
        "order of Tab",
    ):
        assert words in faults, words
    assert any(one.startswith("button without a name") for one in unnamed(page))
    assert {"button-name", "color-contrast", "image-alt"} <= {one.partition(":")[0] for one in list_violations(page)}


def test_a_number_to_vary_is_chosen_by_arrow_keys(page: Page) -> None:
    opened(page, "sweep")
    field = page.get_by_role("combobox", name="Add a parameter to vary")
    options = page.get_by_role("listbox", name="Parameters of the scenario").get_by_role("option")
    field.fill("diameter")
    expect(options.first).to_have_attribute("aria-selected", "true")
    assert list_violations(page) == []  # with the list open, too
    field.fill("temperature")
    second = options.nth(1)
    name = second.locator("strong").inner_text()
    field.press("ArrowDown")
    expect(field).to_have_attribute("aria-activedescendant", second.get_attribute("id") or "")
    field.press("Enter")
    expect(page.get_by_role("region", name="Axes").get_by_role("group", name=name)).to_be_visible()
    expect(field).to_have_value("")
