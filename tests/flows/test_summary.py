"""What results say of themselves: one summary, as text, Markdown, HTML and JSON."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from command import Command

from martensite.base.errors import DataError
from martensite.base.formats import typeset_unit, write_difference, write_quantity
from martensite.base.summary import BulletList, DataTable, Heading, Notice, Sentence, Summary, Tone
from martensite.base.table_layout import format_table
from martensite.show.html import render_fragment
from martensite.show.pages import render_markdown, write_page

WORDS = "a long explanation in words that a terminal of eighty columns must wrap somewhere"
TABLE = DataTable(
    ("name", "value", "meaning", "hidden"),
    [("`A_s`", "68.0 degC", WORDS, "x"), ("`C_A`", "7.5 MPa/K", "slope", "y")],
    right=(1,),
    detail=(3,),
    tags={1: "held out"},
    tones={"slope": "good"},
    note="How to read it.",
)
WHOLE = Summary(
    "A title",
    [
        Heading("Numbers"),
        TABLE,
        Sentence("A caution with `name`.", "caution"),
        Notice("Read this first", ["Something is wrong."], warning=True),
        BulletList(["one", "two"]),
        Heading("For pages", detail=True),
        Sentence("not on a terminal"),
    ],
    {"value": 1.0},
    "In a line.",
)


def lines(table: DataTable, width: int) -> list[str]:
    return list(format_table(table.head, table.rows, table.right, width))


@pytest.mark.parametrize("width", [30, 40, 60, 80, 150])
def test_no_word_and_no_number_is_broken(width: int) -> None:
    text = "\n".join(lines(TABLE, width))
    for row in TABLE.rows:
        for word in (row[1], *row[2].split()):
            assert word in text
    assert max(map(len, text.splitlines())) <= width


def test_a_table_that_is_too_wide_is_set_below_itself_with_its_first_column() -> None:
    table = DataTable(("run", *"abcdef"), [("17", *["12.345 MPa"] * 6)], right=range(1, 7))
    found = lines(table, 40)
    assert len([line for line in found if line.startswith("17")]) == 2
    assert len([line for line in found if "─" in line]) == 2
    assert max(map(len, found)) <= 40


def test_a_word_wider_than_the_page_is_kept_whole() -> None:
    assert "x" * 100 in "\n".join(lines(DataTable(("name",), [("x" * 100,)]), 80))


def test_plain_text_leaves_details_out_and_colours_by_tone() -> None:
    def paint(text: str, tone: Tone) -> str:
        return f"<{tone}>{text}" if tone else text

    text = "\n".join(WHOLE.format_lines(80, paint))
    assert "not on a terminal" not in text and "hidden" not in text
    assert "<title>A title" in text and "<caution>A caution" in text and "<good>slope" in text
    assert "C_A (held out)" in text and "<caution>Read this first: Something is wrong." in text
    assert str(WHOLE).startswith("A title\nIn a line.\n")


def test_pages_show_everything(tmp_path: Path) -> None:
    for text in (render_markdown(WHOLE, "by", "figures"), render_fragment(WHOLE)):
        assert "not on a terminal" in text and "hidden" in text and "How to read it." in text
    page = tmp_path / "page.html"
    assert write_page(WHOLE, page) == [page]
    assert "<code>A_s</code>" in page.read_text(encoding="utf-8")
    with pytest.raises(DataError, match=r"ends in \.html or \.md"):
        write_page(WHOLE, tmp_path / "page.txt")


def test_numbers_are_read_in_familiar_units() -> None:
    assert write_quantity(293.15, "K") == "20 degC" and write_difference(2.0, "K") == "2 K"
    assert write_quantity(0.5, "1") == "0.5" and write_difference(0.5, "1") == "0.5"
    assert write_quantity(float("inf"), "Pa") == "none"
    assert (typeset_unit("W/m^2/K"), typeset_unit("1", "–")) == ("W/m²/K", "–")


PRINTING = {
    "kinds": ("list",),
    "laws": ("list", "law"),
    "blocks": ("list", "block"),
    "law": ("list", "law", "brinson"),
    "materials": ("materials",),
    "material": ("materials", "niti-brinson-1993"),
    "data": ("data",),
    "set": ("data", "show", "flexinol-isobaric"),
    "studies": ("study",),
    "path": ("law", "liang-rogers", "--path", "isobaric"),
}


@pytest.mark.parametrize("words", PRINTING.values(), ids=PRINTING)
def test_tables_fit_a_terminal(words: tuple[str, ...]) -> None:
    """As those of all commands that are called by `Command` in other tests."""
    assert "─" in Command().fine(*words)


def test_a_wide_table_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("martensite.show.terminal.measure_width", lambda: 150)
    with pytest.raises(AssertionError):
        Command().fine("list")


def make_cell(rng: random.Random) -> str:
    return " ".join("x" * rng.randint(1, 14) for _ in range(rng.randint(1, 6)))


def test_random_tables_keep_to_the_width() -> None:
    rng = random.Random(7)
    for _ in range(200):
        columns = rng.randint(1, 9)
        head, *rows = ([make_cell(rng) for _ in range(columns)] for _ in range(rng.randint(1, 5)))
        table = DataTable(head, rows)
        found = lines(table, 80)
        assert max(map(len, found)) <= 80
        for row in table.rows:
            for cell in row:
                assert all(re.search(rf"\b{part}\b", "\n".join(found)) for part in cell.split())
