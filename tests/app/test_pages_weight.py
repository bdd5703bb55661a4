"""What a browser loads of the page."""

import gzip
import os
import re
from pathlib import Path

import pytest

from martensite.app.site import NOTEBOOK, STATIC, WIDGET

MOST = 500_000
"""Bytes of the page with all that it may load, as they go over the wire, compressed."""
REPORT, MOST_OF_REPORT = "report.html", 150_000
"""The page of a report, which is loaded only to make one."""
MOST_OF_WIDGET = 10_000
"""Bytes of the widget of a notebook: a loader, without any module of the page."""


def loaded(folder: Path) -> dict[str, int]:
    """Files of the page, and their bytes as they go over the wire."""
    files = [path for path in folder.iterdir() if path.is_file() and path.name not in (REPORT, WIDGET, NOTEBOOK)]
    return {path.name: len(gzip.compress(path.read_bytes(), 9)) for path in files}


def test_all_of_the_page_weighs_less_than_half_a_megabyte() -> None:
    files = loaded(STATIC)
    assert {"index.html", "bench.js", "bench.css", "icon.svg"} <= files.keys()
    assert sum(files.values()) < MOST, files


def test_the_page_of_a_report_is_light_and_loads_nothing() -> None:
    text = (STATIC / REPORT).read_text("utf-8")
    assert len(text.encode()) < MOST_OF_REPORT
    assert "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:" in text
    assert not re.search(r"""<(?:link|script|img)\b[^>]*\b(?:src|href)=|@import|url\((?!#)""", text)


def test_the_widget_of_a_notebook_loads_nothing() -> None:
    text = (STATIC / WIDGET).read_text("utf-8")
    assert len(text.encode()) < MOST_OF_WIDGET
    assert not re.search(r"""<(?:link|script|img)\b[^>]*\b(?:src|href)=\\?["']http|@import""", text)


def test_the_widget_loads_modules_that_are_there() -> None:
    """Every module that a listed one imports is listed too: an import map resolves no other."""
    (listed,) = re.findall(r'\[(\\?"bench\.css[^]]*)\]', (STATIC / WIDGET).read_text("utf-8"))
    names = set(re.findall(r"[\w-]+\.(?:js|css)", listed))
    assert NOTEBOOK in names
    for name in names:
        text = (STATIC / name).read_text("utf-8")
        assert set(re.findall(r"""\b(?:from|import|import\()"\./([^"]+)\"""", text)) <= names, name


def test_the_weight_of_a_heavy_page_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "bench.js").write_bytes(os.urandom(MOST))  # which nothing makes smaller
    assert sum(loaded(tmp_path).values()) >= MOST


@pytest.mark.parametrize("name", sorted(p.name for p in STATIC.iterdir() if p.suffix == ".js"))
def test_scripts_load_nothing_from_elsewhere(name: str) -> None:
    text = (STATIC / name).read_text("utf-8")
    # esbuild writes imports like this; what looks nearly so is a sentence of the page
    imported = re.findall(r"""\b(?:from|import)"([^"]+)";|\bimport\("([^"]+)"\)""", text)
    imported = [one or other for one, other in imported]
    assert all(one.startswith("./") and (STATIC / one).is_file() for one in imported), imported
    assert not re.search(r"\b(eval|new Function)\(", text)
    assert len(gzip.compress(text.encode())) < 300_000


def test_the_page_has_no_scripts_of_its_own() -> None:
    text = (STATIC / "index.html").read_text("utf-8")
    assert re.findall(r"<script[^>]*>([^<]*)</script>", text) == [""]
    assert not re.search(r"\son\w+=", text)
    assert "//" not in re.sub(r"<!--.*?-->", "", text)
