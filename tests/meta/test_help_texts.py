"""Help texts: complete at 80 columns, in noun phrases or imperatives, with the same name for the same option.

Source of truth: section 6 of the design and the style of the project, for every command that is registered.
"""

from __future__ import annotations

import re

import pytest
from command import Command, list_commands

OPENINGS = re.compile(r"(It|No|Nothing|Of|Whose|What|Who|How|As|When|For|They|These|Those|Where) ")
"""First words that leave out the noun."""
ONE_NAME = {"--save": "--out", "--output-file": "--out", "--budget": "--time-box", "--overwrite": "--force"}
"""Names that no option has, since another name is in use for the same meaning."""
OTHER_MEANING: dict[tuple[str, ...], set[str]] = {("hardware", "characterise"): {"--budget"}}
"""Options whose name is in `ONE_NAME`, and which mean another quantity: a duration of experiments."""


COMMANDS = dict(list_commands())


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_the_help_of_a_command_is_complete(words: tuple[str, ...]) -> None:
    text = Command(*words).fine("--help")
    assert max(map(len, text.splitlines())) <= 80
    assert [line for line in text.splitlines() if line.endswith("...") and not line.startswith("Usage")] == []
    flat = " ".join(text.split())
    for one in COMMANDS[words].params:
        told = getattr(one, "help", "") or ""
        assert told and told[0].isupper() and not OPENINGS.match(told), (one.name, told)
        for default in re.findall(r"\[default: [^]]*\]", told):
            assert default.replace(" ", "") in flat.replace(" ", ""), (one.name, default)


def test_an_option_of_the_same_meaning_has_the_same_name() -> None:
    """`--out` writes the result, `--force` overwrites it, `--time-box` limits the CPU time."""
    named = {
        (words, name)
        for words, one in COMMANDS.items()
        for option in one.params
        for name in option.opts
        if name in ONE_NAME and name not in OTHER_MEANING.get(words, set())
    }
    assert named == set()
