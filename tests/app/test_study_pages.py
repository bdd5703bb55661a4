"""Pages of studies without a server: values, figure and address of each."""

import re
from html import unescape
from pathlib import Path

from martensite.app.calls.studies import describe_study_page
from martensite.app.static_site.study_pages import PAGES, render_page, write_studies
from martensite.app.worker import Desk
from martensite.studies.base import load_study, study_names


def test_every_study_has_a_page_with_its_figure_and_its_printed_values(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    runs.mkdir()
    write_studies(tmp_path, runs)
    for name in study_names():
        shipped = load_study(name).load_shipped_answer()
        assert shipped is not None
        page = (tmp_path / PAGES / f"{name}.html").read_text("utf-8")
        assert (tmp_path / PAGES / f"{name}.svg").read_bytes().rstrip().endswith(b"</svg>")
        assert f'src="{name}.svg"' in page and f'href="../#/studies/{name}"' in page and "<script" not in page
        rows = [unescape(row) for row in re.findall(r"<tr class=.*?</tr>", page)]
        assert len(rows) == len(shipped.claims)
        for row, claim in zip(rows, shipped.claims, strict=True):
            assert claim.statement in row and claim.verdict in row
            if claim.published is not None:
                assert f">{claim.published:.4g}<" in row


def test_text_of_a_study_is_no_markup(tmp_path: Path) -> None:
    page = describe_study_page({"name": "migaone"}, Desk(tmp_path))
    assert "<b>" not in render_page(page | {"title": "<b>", "guide": ['"<b>']}, False)
