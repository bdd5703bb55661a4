"""Names say what a thing is or does: the rules for names, and the glossary they may draw on.

Source of truth: the rules themselves. A module-level function is a verb with a noun, a public class name occurs once,
no function, class or file is called by a bare participle, and the glossary in `docs/conventions.md` is short enough to
be read. No member of a class is one of the participles that fit everything (`kept`, `found`).
`test_breaches_are_found` shows that each rule can fail.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from source_facts import ROOT, Facts, collect_facts, read_package

ONE_WORD = 0.25
"""Largest share of module-level functions with a name of one word: commands, and verbs that need
no object."""
TERMS = 75
PARTICIPLE = re.compile(r"(?!_?(?:embed|feed|need|seed|speed|exceed|proceed|red)$)_?[a-z]+ed$")
IRREGULAR = {"drawn", "told", "seen", "kept", "held", "shown", "given", "taken", "brought", "known"}
FIELD = {
    *("combined", "compiled", "detached", "extended", "failed", "fixed", "held", "infrared"),
    *("lumped", "mixed", "nested", "planned", "sampled", "unscented"),
}
"""Participles that are words of the field (a lumped element, a held sample), or states."""

VAGUE = IRREGULAR | {"found", "left", "made", "met", "named", "said", "wanted", "written"}
IN_FILES = {
    *(("Mpc", "kept"), ("AbstractFilter", "wanted"), ("InverseModel", "wanted")),  # keys of scenarios
    ("ProcessNoisePlant", "held"),  # an argument in saved runs
    *(("ClampReference", "held"), ("ControllerState", "wanted"), ("SensorState", "held")),  # states of saved runs
}
"""Members whose names are in files of users."""
CLASSES = {
    *("combined", "printed"),  # names in saved runs, and in studies of printed numbers
    *("clamped", "recorded", "given", "parametrised"),  # a clamped end, recorded data, a value given by name
}
"""Participles that may name a class, besides the words of the field."""

Names = Iterator[tuple[str, str]]


def list_functions(modules: Mapping[str, Facts]) -> Names:
    """Yield module and name of every function at the top of a module."""
    yield from ((path, name) for path, one in modules.items() for name in one.top)


def list_classes(modules: Mapping[str, Facts]) -> Names:
    """Yield module and name of every public class."""
    for path, one in modules.items():
        yield from ((path, node.name) for node in one.classes if not node.name.startswith("_"))


def list_vague_members(modules: Mapping[str, Facts]) -> list[tuple[str, str]]:
    """Class and name of every field, property and method whose name fits any content."""
    members = [
        (one.name, member) for facts in modules.values() for one in facts.classes for member in name_members(one)
    ]
    return [(owner, name) for owner, name in members if name.strip("_") in VAGUE and (owner, name) not in IN_FILES]


def name_members(one: ast.ClassDef) -> Iterator[str]:
    """Yield the names of the annotated fields, properties and methods of a class."""
    for node in one.body:
        match node:
            case ast.FunctionDef(name=name) | ast.AnnAssign(target=ast.Name(id=name)):
                yield name
            case _:
                pass


def is_participle(name: str) -> bool:
    """Whether a name is one participle and nothing else."""
    word = name.strip("_")
    return word not in FIELD and (word in IRREGULAR or bool(PARTICIPLE.fullmatch(word)))


def share_of_one_word(names: list[str]) -> float:
    """Share of names without a second word."""
    return sum("_" not in name.strip("_") for name in names) / len(names)


def find_doubles(names: Names) -> dict[str, list[str]]:
    """Names that occur more than once, and where."""
    pairs = list(names)
    counts = Counter(name for _, name in pairs)
    return {n: [path for path, name in pairs if name == n] for n in counts if counts[n] > 1}


def list_terms(page: str) -> list[str]:
    """Terms of the glossary: first cells of its tables."""
    cells = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("| ")]
    return [cell for cell in cells if cell != "term"]


def test_most_functions_are_a_verb_and_a_noun() -> None:
    names = [name for _, name in list_functions(read_package())]
    assert share_of_one_word(names) <= ONE_WORD


def test_no_function_is_a_bare_participle() -> None:
    assert [pair for pair in list_functions(read_package()) if is_participle(pair[1])] == []


def test_no_file_is_a_bare_participle() -> None:
    assert [path for path in read_package() if is_participle(Path(path).stem)] == []


def test_no_class_is_a_bare_participle() -> None:
    words = [(path, "_".join(re.findall("[A-Z][a-z]*", name)).lower()) for path, name in list_classes(read_package())]
    assert [(path, word) for path, word in words if word not in CLASSES and is_participle(word)] == []


def test_no_member_of_a_class_is_a_vague_participle() -> None:
    assert list_vague_members(read_package()) == []


def test_a_public_class_name_occurs_once() -> None:
    assert find_doubles(list_classes(read_package())) == {}


def test_the_formatter_decides_everywhere() -> None:
    files = [path for top in (ROOT / "src", ROOT / "tests") for path in sorted(top.rglob("*.py"))]
    told = re.compile(r"#\s*fmt:\s*(skip|off)")
    assert [str(path) for path in files if told.search(path.read_text("utf-8"))] == []


def test_the_glossary_is_short_and_says_each_term_once() -> None:
    terms = list_terms((ROOT / "docs" / "conventions.md").read_text("utf-8").partition("## Glossary")[2])
    assert len(set(terms)) == len(terms) <= TERMS


def test_breaches_are_found() -> None:
    tree = {"a.py": collect_facts("class Course: ...\ndef drawn(): ...\ndef judged(): ...")}
    again = tree | {"b.py": collect_facts("class Course: ...\ndef draw_loop(): ...")}
    names = [name for _, name in list_functions(again)]
    assert share_of_one_word(names) == 2 / 3
    assert [is_participle(name) for name in names] == [True, True, False]
    assert find_doubles(list_classes(again)) == {"Course": ["a.py", "b.py"]}
    vague = collect_facts(
        "class Fit:\n    kept: int\n    rows: int\n    def _found(self): ...\n    def find(self): ..."
    )
    assert list_vague_members({"a.py": vague}) == [("Fit", "kept"), ("Fit", "_found")]
    assert list_terms("| term | meaning |\n|---|---|\n| lane | a run |") == ["lane"]
