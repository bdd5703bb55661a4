"""The widget of a notebook in a browser, with a model as anywidget gives it, and the kernel's side of it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import FrameLocator, Page, expect
from static_wire import TEXT

from martensite.app.documents import build_packaged
from martensite.app.notebook import BenchWidget

ADDRESS = "http://127.0.0.1:9/notebook"
MODEL = """async ([esm, state]) => {
  const heard = {};
  const model = {
    get: (name) => state[name],
    set: (name, value) => { state[name] = value; changed.add(name); },
    save_changes: () => { for (const name of changed) keep(name, state[name]); changed.clear(); },
    on: (event, one) => (heard[event] ??= new Set()).add(one),
    off: (event, one) => heard[event]?.delete(one),
    send: async (content) => {
      const [told, data] = await ask(content);
      const buffers = data === null ? [] : [new DataView(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer)];
      for (const one of heard["msg:custom"] ?? []) one(told, buffers);
    },
  };
  const changed = new Set();
  window.put = (name, value) => { state[name] = value; for (const one of heard[`change:${name}`] ?? []) one(); };
  const module = await import(URL.createObjectURL(new Blob([esm], { type: "text/javascript" })));
  window.leave = module.default.render({ model, el: document.querySelector("#cell") });
}"""


@pytest.fixture
def widget(monkeypatch: pytest.MonkeyPatch) -> BenchWidget:
    return build_packaged(TEXT).show_bench()


@pytest.fixture
def page(tab: Any, widget: BenchWidget, monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    """A notebook with the widget in a cell, 950 wide and dark."""
    made: Page = tab.context.new_page()
    made.set_viewport_size({"width": 1000, "height": 900})
    asked, said, sent = list[str](), list[str](), list[Any]()
    made.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    made.on("pageerror", lambda error: said.append(str(error)))
    made.on("request", lambda request: asked.append(request.url))
    monkeypatch.setattr(widget, "send", lambda content, buffers=None: sent.append((content, buffers)))

    def ask(content: dict[str, Any]) -> tuple[Any, str | None]:
        widget._handle_custom_msg(content, [])
        told, buffers = sent.pop()
        return told, b64encode(buffers[0]).decode() if buffers else None

    made.expose_function("ask", ask)
    made.expose_function("keep", lambda name, value: widget.set_state({name: value}))
    cell = '<body style="background: #111"><div id="cell" style="width: 950px"></div></body>'
    made.route(ADDRESS, lambda route: route.fulfill(body=cell, content_type="text/html"))
    made.goto(ADDRESS)
    made.evaluate(MODEL, [BenchWidget._esm, {"text": widget.text, "height": widget.height}])
    yield made
    made.close()
    assert said == []
    assert [url for url in asked if not url.startswith(("blob:", "data:", "about:")) and url != ADDRESS] == []


@pytest.fixture
def frame(page: Page) -> FrameLocator:
    return page.frame_locator("iframe[title='martensite bench']")


def about(**changes: str) -> str:
    """What the page says of a run."""
    result = build_packaged(TEXT, {path.replace("__", "."): text for path, text in changes.items()}).run()
    return f"{len(result.times)} samples, {result.steps} steps"


def test_a_slider_runs_in_the_kernel(page: Page, frame: FrameLocator, widget: BenchWidget) -> None:
    title = frame.locator(".bench-title")
    expect(title).to_contain_text(about())
    expect(frame.locator("html")).to_have_attribute("data-theme", "dark")
    expect(frame.locator(".scene canvas, .scene svg").first).to_be_visible()
    slider = frame.locator(".top-controls input[type=range]").first
    expect(slider).to_be_visible()
    slider.focus()
    slider.press("ArrowRight")
    expect(frame.get_by_role("button", name="Undo")).to_be_enabled()
    expect(frame.locator(".bench")).to_have_attribute("aria-busy", "false")
    result = widget.scenario.run()
    assert widget.text != TEXT
    expect(title).to_contain_text(f"{result.steps} steps")
    page.evaluate("text => put('text', text)", build_packaged(TEXT, {"element.diameter": "0.12 mm"}).text)
    expect(title).to_contain_text(about(element__diameter="0.12 mm"))
    page.evaluate("document.body.style.background = '#fff'")
    expect(frame.locator("html")).to_have_attribute("data-theme", "light")


def test_live_mode_runs_in_the_cell(page: Page, frame: FrameLocator) -> None:
    expect(frame.locator(".bench-title")).to_contain_text(about())
    frame.get_by_role("button", name="Live").click()
    expect(frame.get_by_role("region", name="Running by hand")).to_be_visible()
