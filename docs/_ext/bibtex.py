"""The bibliography as Markdown, from the package's `references.bib`."""

from __future__ import annotations

from martensite.scenario import citations
from martensite.scenario.citations import read_fields

_ORDER = ("journal", "booktitle", "school", "organization", "edition")


def bibliography() -> str:
    """All works, sorted by key, each with a target that other pages link to."""
    known = citations.read_bibliography()
    return "\n".join(_entry(key, known[key]) for key in sorted(known))


def describe_work(key: str) -> str:
    """Authors, title and place of a work, in a sentence."""
    return _sentence(read_fields(citations.read_bibliography()[key]))


def _entry(key: str, text: str) -> str:
    return f"(bib-{key})=\n**{key}**\n: {_sentence(read_fields(text))}\n"


def _sentence(found: dict[str, str]) -> str:
    authors = found.get("author", "").replace(" and others", " et al.").replace(" and ", "; ")
    volume = " ".join(found[name] for name in (*_ORDER, "volume") if name in found)
    place = ", ".join(filter(None, (volume, _pages(found))))
    pieces = [authors, f"*{found['title']}*", f"{place} {_year(found)}".strip()]
    text = ". ".join(piece for piece in pieces if piece) + "."
    links = [
        f"[doi:{found['doi']}](https://doi.org/{found['doi']})" if "doi" in found else "",
        f"[arXiv:{found['eprint']}](https://arxiv.org/abs/{found['eprint']})" if "eprint" in found else "",
        f"<{found['url']}>" if "url" in found else "",
        f"({found['note']})" if "note" in found else "",
    ]
    return " ".join([text.replace("..", "."), *(link for link in links if link)])


def _pages(found: dict[str, str]) -> str:
    return f"p. {found['pages']}" if "pages" in found else ""


def _year(found: dict[str, str]) -> str:
    return f"({found['year']})" if "year" in found else ""
