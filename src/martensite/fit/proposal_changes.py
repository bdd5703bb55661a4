"""Free and fixed parameters of a user in proposed scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from martensite.base.errors import InputError, UnknownNameError
from martensite.fit.experiment_kinds.base import Proposal
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import read_scenario


def change_proposals(proposals: Sequence[Proposal], free: Sequence[str], fixed: Sequence[str]) -> list[Proposal]:
    """Return proposals with other free parameters.

    Args:
        proposals: proposals for the logs.
        free: texts of free parameters, which replace parameters of the same name, and differences from it, or are
            added.
        fixed: names of fixed parameters, each with `=VALUE` if the value is known.

    Raises:
        UnknownNameError: a fixed name is free in no proposal.
        InputError: a value is given for a difference of two parameters.
    """
    names = list(dict.fromkeys(_find_name(text) for one in proposals for text in one.free))
    for text in fixed:
        if _find_name(text) not in names:
            raise UnknownNameError("free parameter", _find_name(text), names)
    made = [replace(one, free=(*_replace_free(one.free, free),)) for one in proposals]
    for text in fixed:
        made = [_fix_parameter(one, text) if _is_free(one, text) else one for one in made]
    return made


def _find_name(text: str) -> str:
    return text.partition("=")[0].partition("@")[0].strip()


def _is_free(proposal: Proposal, text: str) -> bool:
    return _find_name(text) in map(_find_name, proposal.free)


def _replace_free(known: Sequence[str], given: Sequence[str]) -> list[str]:
    own = {_find_name(text): text for text in given}
    kept = [text for text in known if _find_name(text).partition("-")[0] not in own or _find_name(text) in own]
    return [*(own.pop(_find_name(text), text) for text in kept), *own.values()]


def _fix_parameter(proposal: Proposal, text: str) -> Proposal:
    name, _, value = (part.strip() for part in text.partition("="))
    free = tuple(one for one in proposal.free if _find_name(one) != name)
    others = tuple({key: x for key, x in start.items() if key != name} for start in proposal.others)
    made = replace(proposal, free=free, others=others)
    if not value:
        return made
    scenario = read_scenario(proposal.text, log=proposal.rows[0])
    paths = [leaf.path for leaf in scenario.system.leaves() if f".{leaf.path}".endswith(f".{name}")]
    if not paths:
        raise InputError(f"`{name}` is a difference of two parameters, which takes no value in --fix; set its bounds.")
    return replace(made, document=change_document(proposal.document, {scenario.places.path(paths[0]): value}))
