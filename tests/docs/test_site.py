"""The folder of documentation and bench: what is in it, and that it is light; without zig and browser."""

from __future__ import annotations

import io
import math
import random
import re
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from fences import ROOT
from matplotlib.figure import Figure
from static_wire import TEXT

from martensite.app.static_site.site_writer import list_offered
from martensite.base.errors import DataError

DOCS = ROOT / "docs"
WORD = r"[A-Za-z]|-?\d[\d.]*(?:e[+-]?\d+)?"


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return import_module("make_site")


def test_scenarios_that_pages_write_are_on_the_bench(site: Any, tmp_path: Path) -> None:
    cell = "```{{code-cell}} ipython3\n%%writefile {}.toml\n{}```\n"
    broken = TEXT.replace("[element]", "[elements]")
    own = TEXT.replace("[drive", '[measured]\nfile = "/log.csv"\n\n[drive', 1)
    for page, texts in {"a": {"wire": TEXT, "x": broken, "log": own}, "b": {"wire": TEXT, "y": TEXT + "\n"}}.items():
        (tmp_path / f"{page}.md").write_text("".join(cell.format(*one) for one in texts.items()), encoding="utf-8")
    assert site.list_documented(tmp_path) == {"wire": TEXT, "y": TEXT + "\n"}


def test_whatever_is_linked_is_on_the_bench(site: Any) -> None:
    known = list_offered() | site.list_documented()
    index = (DOCS / "index.md").read_text("utf-8")
    (devices,) = re.findall(r"```\{devices\}\n(.*?)```", index, re.DOTALL)
    names = [line.partition(" ")[0] for line in devices.splitlines()]
    pictures = {name: (DOCS / "_static" / "devices" / f"{name}.webp").stat().st_size for name in names}
    assert len(pictures) >= 4 and max(pictures.values()) < 60_000
    tagged = [name for page in DOCS.rglob("*.md") for name in re.findall(r"\blive-(\w+)\]", page.read_text("utf-8"))]
    linked = re.findall(r"^[^|\n]+\|[^|\n]+\|[^|\n]+\| (\S+)$", index, re.MULTILINE)
    assert tagged and linked
    assert {*names, *tagged, *linked} <= known.keys()


def test_only_an_earlier_site_is_taken_away(site: Any, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("x", encoding="utf-8")
    with pytest.raises(DataError, match="holds something else"):
        site.clear_folder(tmp_path)
    (tmp_path / "bench" / "runs").mkdir(parents=True)
    (tmp_path / "bench" / "runs" / "manifest.json").write_text("{}", encoding="utf-8")
    site.clear_folder(tmp_path)
    assert not tmp_path.exists()


def test_a_drawing_is_the_same_in_fewer_bytes(site: Any) -> None:
    figure, drawn = Figure(), io.StringIO()
    figure.subplots().plot([math.sin(k) for k in range(999)], label="sine")
    figure.savefig(drawn, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    before, after = drawn.getvalue(), site.shorten_drawing(drawn.getvalue())
    assert len(after) < 0.8 * len(before)
    trees = [list(ElementTree.fromstring(one).iter()) for one in (before, after)]
    for old, new in zip(*trees, strict=True):
        assert (old.tag, old.keys(), (old.text or "").strip()) == (new.tag, new.keys(), (new.text or "").strip())
        words = [re.findall(WORD, " ".join(one.attrib.values())) for one in (old, new)]
        for one, other in zip(*words, strict=True):
            assert one == other or abs(float(one) - float(other)) <= 0.0051


def test_its_weight_is_told_and_has_an_end(site: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bench").mkdir()
    (tmp_path / "index.html").write_bytes(bytes(2_000_000))
    (tmp_path / "bench" / "bench.js").write_bytes(bytes(1_000_000))
    said = site.report_size(tmp_path)
    assert "2 files, 3.0 MB, 0.0 MB compressed" in said and "the bench: 1 files, 1.0 MB" in said
    (tmp_path / "bench" / "run.wasm").write_bytes(random.Random(1).randbytes(1_000_000))
    monkeypatch.setattr(site, "MOST", 0.99e6)
    with pytest.raises(DataError, match="more than 1 MB compressed"):
        site.report_size(tmp_path)
