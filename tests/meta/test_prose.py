"""Plain English: hits of patterns per 1000 words, by place, which only go down.

Source of truth: the style guide. Well-kept scientific packages have 4 to 6 hits per 1000 words. A failure lists the
sentences. Rewrite them; do not raise a limit. Lower a limit when a change lowers its rate.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
from command import list_commands
from source_facts import PACKAGE, ROOT, join_literal, read_package, walk_tree

RULES = {
    "a clause as the subject: begin with the noun": (
        r"^(What|Whatever|Whoever|Whose|Who|Which|How|Where|That (a|an|the|it|in|its))\b(?!.*\?$)"
    ),
    "'what' for a noun: name the thing": (
        r"(?<!^)\b(of|by|in|for|with|from|on|to|than|as|and|is|are|say|has|does|do|at) what\b"
    ),
    "'that of': repeat the noun": r"\b(that|those) (of|which|who|under|in|on|by|from)\b",
    "passive verb of speech: reports, lists": (
        r"\b(is|are|was|were|be|been) (said|told|named|asked for|looked for|had|met|meant)\b"
    ),
    "riddle: state the fact": (
        r"\b(none (for|if|but|that|else)|nothing (else|more|that|of)|no other|by itself|of (its|their|one's|our) own)\b"
    ),
    "inverted condition: if ...": (
        r"\b([Hh]ad|[Ww]ere) (it|there|the|they|he)\b|^(So|Nor|Neither|Left out|Held(?!-)|Alone|Beside)\b"
    ),
    "'who' without a noun: users who": (
        r"\b(who|whoever|whom) (has|have|knows|wants|names|holds|needs|asks|looks|puts|types|sees)\b"
    ),
    "'shall' and 'one': you, must": (
        r"\bshall\b|\b[Oo]ne (has|gets|sees|can|must|may|takes|wants|reads|likes|asks|waits|looks)\b"
    ),
    "', too': also": r",? too[.,;:)]|, too$",
    "old word: again, fix, available, continuous, next to": r"\b(anew|mend(s|ed)?|at hand|for ever|beside)\b",
    "says, tells: reports, prints": (
        r"\b(says?|tells?|speaks?) (what|which|how|where|why|so|that|of|it|whether|when)\b|\bsays\b"
    ),
    "stands in: is in": r"\bstands? (in|on|under|beside|behind|for|there|below|above|at|as|alone|before|open)\b",
    "number: parameter, value": r"\b(free|own|material|other|its|their|these|those|the|same|of) numbers?\b(?! of)",
    "share: fraction": r"\bshares?\b",
    "march, room, lane: integration, package, batch element": r"\b(march(es|ed|ing)?|rooms?|lanes?)\b",
    "at rest: steady state": r"\b(at|to|of|from|where it) rests?\b",
    "kept back, judged: held out, tested": r"\bkept? back\b|\bjudge[ds]?\b",
    "so many: N": r"\b(so|as) (many|much|long|few)\b",
    "duty: duty cycle": r"\bdut(y|ies)\b(?! cycle)",
    "surroundings: ambient": r"\bsurroundings\b",
    "private word: the word of the field": (
        r"\b([Ww]ay of the|course of the|courses|cadences?|rung|hair|nobody|bears?|lapse|owed|bid)\b"
    ),
}
"""Patterns by what is wrong and what to write."""
LIMITS = {
    "README.md": 6.0,
    "CHANGELOG.md": 4.0,
    "CONTRIBUTING.md": 4.0,
    "paper": 2.0,
    "docs": 3.0,
    "docs/howto": 2.0,
    "docs/explanation": 4.0,
    "docs/reference": 4.0,
    "docs/sources": 1.0,
    "docs/decisions": 6.0,
    "docs/developer": 3.0,
    "help": 4.0,
    "messages": 7.5,
    "web": 4.0,
    "docstrings": 9.0,
}
"""Largest number of hits per 1000 words, by place."""
SCREENS = (
    "show/summaries/*.py",
    "simulate/judgement.py",
    "simulate/alarms.py",
    "fit/fit_verdicts.py",
    "design/sizing/remarks.py",
)
"""Files whose texts are shown on screens."""
ADMONITION = re.compile(r"^```\{(?:note|warning|tip|admonition)\}[^\n]*\n(.*?)^```\s*$", re.S | re.M)
"""Prose in a fence."""
MOST_WORDS = 35
WORDS = re.compile(r"[A-Za-z]{2,}")
END = re.compile(r"(?<=[.!?])[\"')*_`]*\s+(?=[A-Z0-9*`\"'(\[])")


def split_sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a text that have at least four words."""
    for one in END.split(re.sub(r"\s+", " ", text.replace("e.g. ", "such as ")).strip()):
        if len(WORDS.findall(one)) >= 4:
            yield one.strip(" -*")


def read_markdown(path: Path) -> Iterator[str]:
    """Yield the sentences of a page, without code, headings, tables, formulas and fields of numbers."""
    text = ADMONITION.sub(r"\n\1\n", path.read_text("utf-8"))
    text = re.sub(r"\A---\n.*?\n---\n|<!--.*?-->|^(```|~~~).*?^\1\s*$", "\n", text, flags=re.S | re.M)
    text = re.sub(r"\$\$.*?\$\$|(\{\{[a-z-]+: .+?\}\})", lambda found: "0" if found[1] else " ", text, flags=re.S)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"^\s*(#|\||:::|---|\([\w-]+\)=).*$", "\n", text, flags=re.M)
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.|:)\s)", text):
        yield from split_sentences(re.sub(r"^\s*(?:[-*]|\d+\.|:)\s+|^> ?", "", block))


def read_sources() -> list[str]:
    """Return the messages of the package: errors, and all texts in the modules of screens."""
    messages = [text for one in read_package().values() for text in one.messages]
    for path in {path for pattern in SCREENS for path in PACKAGE.glob(pattern)}:
        skipped = set[int]()
        for node in walk_tree(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Expr):
                skipped.add(id(node.value))
            elif isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in skipped:
                messages.append(join_literal(node))
    return messages


def read_docstrings() -> Iterator[str]:
    """Yield the sentences of all docstrings."""
    for text in (text for one in read_package().values() for text in one.documented):
        for part in re.split(r"\n\s*\n|\n(?=\s+\w+:)", text):
            yield from split_sentences(re.sub(r"^\s*(Args|Returns|Raises|Yields):\s*$", "", part, flags=re.M))


def read_messages() -> Iterator[str]:
    """Yield the sentences of errors and screens."""
    for text in read_sources():
        yield from split_sentences(text)


def read_help() -> Iterator[str]:
    """Yield the sentences of all help texts."""
    for _, command in list_commands():
        for text in (command.help or "", *(getattr(one, "help", "") or "" for one in command.params)):
            for part in text.split("\n\n"):
                yield from split_sentences(re.sub(r" *\[default: [^]]*\]", "", part))


def read_web() -> Iterator[str]:
    """Yield the texts of the web page."""
    for path in sorted((ROOT / "web" / "src").rglob("*.ts*")):
        for line in path.read_text("utf-8").splitlines():
            if not line.strip().startswith(("//", "*", "/*", "import")):
                for text in re.findall(r"[\"'`>]([A-Z][^\"'`<>{}$]{24,}[.:?])[\"'`<]", line):
                    yield from split_sentences(text)


READERS = {"help": read_help, "messages": read_messages, "web": read_web, "docstrings": read_docstrings}


def read_place(place: str) -> Iterable[str]:
    """Return the sentences of a place."""
    if place in READERS:
        return READERS[place]()
    path = ROOT / place
    files = [path] if path.is_file() else sorted(path.glob("*.md"))
    return (one for file in files for one in read_markdown(file))


def find_hits(sentences: Iterable[str]) -> tuple[int, Counter[str], list[str]]:
    """Return the number of words, the hits by rule, and the sentences that are hit."""
    rules = {name: re.compile(pattern) for name, pattern in RULES.items()}
    words, hits, bad = 0, Counter[str](), list[str]()
    for one in sentences:
        words += len(WORDS.findall(one))
        found = [name for name, rule in rules.items() if rule.search(one)]
        found += ["more than 35 words: split"] if len(one.split()) > MOST_WORDS else []
        found += ["two of ; and : in a sentence: split"] if one.count("; ") + one.count(": ") > 1 else []
        hits.update(found)
        bad += [f"{one[:160]}  <- {found[0]}"] if found else []
    return words, hits, bad


@pytest.mark.parametrize("place", LIMITS)
def test_a_place_keeps_its_limit(place: str) -> None:
    words, hits, bad = find_hits(read_place(place))
    assert words > 0, f"`{place}` has no sentences: its reader no longer fits."
    rate = 1000.0 * sum(hits.values()) / words
    told = "\n".join([*bad[:40], *(f"{count:5} {name}" for name, count in hits.most_common())])
    assert rate <= LIMITS[place], f"{rate:.1f} hits per 1000 words of `{place}`, limit {LIMITS[place]:g}\n{told}"


def test_the_patterns_hit_what_the_guide_forbids() -> None:
    """A sentence of the guide for each rule that names words, and a plain one that none hits."""
    bad = (
        "What is not well written is answered by a sentence.",
        "Had it been 41 degrees, the film would hardly rise.",
        "The duty of the wire that of the other one, too.",
        "It says how many numbers of a material stand beside the others.",
    )
    assert [one for one in bad if not find_hits([one])[1]] == []
    plain = "The guard keeps the wire below 140 °C at the ambient temperature of this file."
    assert not find_hits([plain])[1]
