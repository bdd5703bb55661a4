"""The modules of the package are those of its scenarios, and no run of a packaged scenario needs a compiler.

Source of truth: the digest of the C that is generated now.
"""

from __future__ import annotations

import gzip
from importlib import import_module
from pathlib import Path

import pytest
from node_js import WEB

from martensite.app.calls.models import build_model
from martensite.app.documents import list_standalone
from martensite.app.static_site import packaged_modules
from martensite.app.static_site.packaged_modules import MODULES, SUFFIX, list_runs, provide_module
from martensite.app.static_site.run_module import RunSource
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.export.wasm import module

MAGIC = b"\0asm\1\0\0\0"


@pytest.fixture
def no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(module, "find_zig", lambda: None)


def test_the_modules_are_those_of_the_present_c(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(WEB))
    texts = import_module("write_modules").list_texts()
    runs = list_runs(texts)
    assert len(texts) >= len(list_standalone()) + 5
    present = {path.name for path in MODULES.glob("*" + SUFFIX)}
    assert present == {one.file for one in runs}, "the generated C has changed: run `make modules`"
    assert packaged_modules._read_rounding().keys() == {one.key for one in runs}, "run `make modules`"
    for name in present:
        assert gzip.decompress((MODULES / name).read_bytes()).startswith(MAGIC)


def test_a_packaged_scenario_with_other_numbers_needs_no_compiler(no_compiler: None) -> None:
    text = list_standalone()["finger"]
    asked = {"text": text, "changes": {"element.diameter": "0.3 mm"}, "paths": ["mechanism.extension"]}
    found = build_model(asked, Desk(Path(), lambda note: None))
    assert str(found["module"]).startswith("AGFzbQEAAA")
    assert [one["path"] for one in found["scenario"]["controls"]] == ["mechanism.extension"]


def test_another_structure_is_compiled_once(no_compiler: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = RunSource("given", "int run;", "int first;")
    with pytest.raises(InputError, match="WebAssembly is compiled by zig"):
        provide_module(source)
    compiled: list[str] = []
    monkeypatch.setattr(RunSource, "compile", lambda one: compiled.append(one.run) or MAGIC)
    assert [provide_module(source), provide_module(source)] == [MAGIC, MAGIC]
    assert compiled == ["int run;"]
