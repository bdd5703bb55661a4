"""The page of docs/howto/export-wasm.md: a wire in a browser, under a slider."""

from __future__ import annotations

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from benchmarks.wasm_runs import say_missing, write_module
from fences import ROOT, fences
from playwright.sync_api import Page

from martensite.export.wasm import build_wasm
from martensite.scenario.scenario import load


class Quiet(SimpleHTTPRequestHandler):
    """A server that says nothing of what it serves."""

    def log_message(self, format: str, *args: Any) -> None:
        pass


def test_a_slider_heats_the_wire(tab: Any, tmp_path: Path) -> None:
    if say_missing():
        pytest.skip(f"WebAssembly is not tried: there is no {say_missing()}")
    (text,) = [one.text for one in fences(ROOT / "docs/howto/export-wasm.md") if one.language == "html"]
    (tmp_path / "index.html").write_text(text, encoding="utf-8")
    write_module(build_wasm(load(ROOT / "examples/pwm_bias_spring.toml").whole, name="spring"), tmp_path)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        origin = f"http://127.0.0.1:{server.server_port}"
        page: Page = tab.page
        tab.empty(origin)
        page.goto(origin)
        page.wait_for_function("document.getElementById('said').value.startsWith('22.0 °C')")
        page.locator("#volts").fill("4")
        page.wait_for_function("parseFloat(document.getElementById('said').value) > 30")
        tab.check()
        server.shutdown()
