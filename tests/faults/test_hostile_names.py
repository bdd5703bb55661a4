"""Titles and names from outside in reports and figures: shown as they are, never taken for mark-up.

Source of truth: a title that would do harm is in the page as text, and the page has no tag, link or code of
its own making.
"""

from collections.abc import Callable
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest

from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.show.figures.model import write_signal_label
from martensite.show.figures.panels import make_panels
from martensite.show.html import render_fragment, render_page
from martensite.show.pages import render_markdown

HOSTILE = (
    "<script>alert(1)</script>",
    "</title><img src=x onerror=alert(1)>",
    "*/ ]]> %s {title} --> <!-- <?x ?>",
    "a ` lone one and `two` and ``<script>``",
    "[here](javascript:alert(1))",
    "one\n# two\n<script>",
    "a | b \\<script>",
)

HARMLESS = "a `name` with words enough for a cell of several lines, and one more"


def spread(words: str) -> Summary:
    """A summary that says some words wherever words may stand."""
    blocks: list[Block] = [
        Heading(words),
        Sentence(words),
        BulletList([words]),
        Notice(words, [words], warning=True),
        DataTable((words, "x"), [(words, words)], note=words, tags={0: "held out"}, folded=words),
        Picture("figure", lambda: make_panels(1.0, 1.0, 1, 1)[0], words),
    ]
    return Summary(words, blocks, lead=words)


class Tags(HTMLParser):
    """Collects the tags and attributes of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: set[str] = set()
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found |= {tag, *(f"{tag}.{name}" for name, _ in attrs)}

    def handle_data(self, data: str) -> None:
        self.text += data


def read_tags(page: str) -> Tags:
    tags = Tags()
    tags.feed(page)
    return tags


def render_whole(one: Summary) -> str:
    return render_page(one, "martensite")


@cache
def list_usual(render: Callable[[Summary], str]) -> set[str]:
    """Tags and attributes of a page without hostile words."""
    return read_tags(render(spread(HARMLESS))).found | read_tags(render(spread("short"))).found


@pytest.mark.parametrize("words", HOSTILE)
def test_html_has_no_tags_but_its_own(words: str) -> None:
    for render in (render_fragment, render_whole):
        hostile = read_tags(render(spread(words)))
        assert hostile.found <= list_usual(render)
        assert words.replace("`", "").split("\n")[0] in hostile.text.replace("`", "")


@pytest.mark.parametrize("words", HOSTILE)
def test_markdown_has_no_tags_links_or_open_code(words: str) -> None:
    text = render_markdown(spread(words), "martensite", "figures")
    outside = "".join(text.split("`")[::2])
    assert text.count("`") % 2 == 0
    assert not [part for part in outside.split("<")[1:] if part[:1].isalpha() or part[:1] in "/!?"]
    assert "](javascript" not in outside
    assert text.count("\n# ") == 0
    assert text.startswith("# ")


def test_own_words_of_a_report_stay_as_they_are() -> None:
    own = "`E_A` [GPa] is at most 80 GPa: p < 0.0001 & more, 2 <= 3 (see [here])."
    assert own in render_markdown(Summary("A title", [Sentence(own)]), "martensite", "figures")


def test_a_dollar_in_the_name_of_a_column_is_no_mathematics(tmp_path: Path) -> None:
    figure, ((axes,),) = make_panels(3.0, 2.0, 1, 1)
    axes.set_ylabel(write_signal_label(r"a$\nosuch{$b", {}))
    figure.savefig(tmp_path / "figure.png")
