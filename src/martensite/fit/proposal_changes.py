"""Free and fixed parameters of a user in proposed scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from martensite.base.errors import InputError, UnknownNameError
from martensite.fit.experiment_kinds.base import Proposal
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import Scenario, read_scenario


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
    changed_proposals = [replace(one, free=(*_replace_free(one.free, free),)) for one in proposals]
    for text in fixed:
        changed_proposals = [fix_parameter(one, text) if _is_free(one, text) else one for one in changed_proposals]
    return changed_proposals


def list_held(
    offered: Sequence[Proposal], chosen: Proposal, scenario: Scenario, given: Sequence[str]
) -> dict[str, tuple[float, str]]:
    """Return path -> value and SI unit of the offered parameters that a chosen proposal does not fit.

    Args:
        offered: proposals for the logs, with all their free parameters.
        chosen: one of them, with fewer free parameters.
        scenario: scenario of the chosen proposal.
        given: paths and names with a value by the user, which is no assumption.
    """
    own = [one for one in offered if chosen.name == one.name or chosen.name.startswith(f"{one.name}, ")]
    names = {_find_name(text) for one in own for text in one.free} - {_find_name(text) for text in chosen.free}
    fixed_parameters: dict[str, tuple[float, str]] = {}
    for leaf in scenario.system.leaves():
        path = scenario.places.path(leaf.path)
        is_fixed = any(f".{leaf.path}".endswith(f".{name}") or path == name for name in names)
        if is_fixed and not any(f".{path}".endswith(f".{name}") for name in given):
            fixed_parameters[path] = float(leaf.value), leaf.declared.unit
    return fixed_parameters


def _find_name(text: str) -> str:
    return text.partition("=")[0].partition("@")[0].strip()


def _is_free(proposal: Proposal, text: str) -> bool:
    return _find_name(text) in map(_find_name, proposal.free)


def _replace_free(free_texts: Sequence[str], given: Sequence[str]) -> list[str]:
    own = {_find_name(text): text for text in given}
    remaining_texts = [
        text for text in free_texts if _find_name(text).partition("-")[0] not in own or _find_name(text) in own
    ]
    return [*(own.pop(_find_name(text), text) for text in remaining_texts), *own.values()]


def fix_parameter(proposal: Proposal, text: str) -> Proposal:
    """Return a proposal with a fixed parameter, `NAME` at its start or `NAME=VALUE`.

    Raises:
        InputError: a value is given for a difference of two parameters.
    """
    name, _, value = (part.strip() for part in text.partition("="))
    free = tuple(one for one in proposal.free if _find_name(one) != name)
    others = tuple({key: x for key, x in start.items() if key != name} for start in proposal.others)
    changed_proposal = replace(proposal, free=free, others=others)
    if not value:
        return changed_proposal
    scenario = read_scenario(proposal.text, log=proposal.rows[0])
    paths = [leaf.path for leaf in scenario.system.leaves() if f".{leaf.path}".endswith(f".{name}")]
    if not paths:
        raise InputError(f"`{name}` is a difference of two parameters, which takes no value in --fix; set its bounds.")
    return replace(
        changed_proposal, document=change_document(proposal.document, {scenario.places.path(paths[0]): value})
    )
