"""Identified models: scores of free runs, what was found, and how far to trust it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary

if TYPE_CHECKING:
    from martensite.identify.chains.chain import Chain
    from martensite.identify.chains.search import Searched, StructureCandidate
    from martensite.identify.chains.stages import Identified
    from martensite.signals.sampling.sampled import Sampled

ENOUGH = 3
"""Searches that should end alike."""
MOST_ROWS = 15
"""Candidates of a search that are shown."""
MOST_NUMBERS = 12
"""Numbers of a chain that are shown."""
SCORES = ("model", "used for", "record", "output", "fit [%]", "RMS error", "largest error")
STRUCTURES = ("structure", "numbers", "estimation [%]", "chosen by [%]", "agreeing", "s", "fault")


def summarise_identified(found: Identified, records: Sequence[Sampled]) -> Summary:
    """Everything about models in stages.

    Args:
        found: the models.
        records: all that were read for them.
    """
    blocks = [block for k in range(len(found.stages)) for block in _describe_stage(found, k)]
    warned = [Sentence(one, "caution") for one in collect_warnings(found, records)]
    return Summary("", [*blocks, *_describe_scores(found), *warned], _collect_numbers(found, records))


def _describe_stage(found: Identified, k: int) -> Iterator[Block]:
    stage, one, searched = found.stages[k], found.estimates[k], found.searches[k]
    chain = one.chain
    head = f"Stage {k + 1}" if len(found.stages) > 1 else "Model"
    names = ", ".join(f"`{name}`" for name in chain.input_names)
    yield Heading(f"{head}: {names} -> `{stage.output}`: {chain.text()}")
    yield Sentence(
        f"{len(chain.theta)} free numbers, sample time {chain.interval:.6g} s, "
        f"{one.options.starts} starts; {one.agreeing} of {len(one.fits)} refined searches "
        "agree within 0.1 point"
    )
    if searched is not None:
        yield from _describe_search(searched)
    yield from _describe_dynamics(chain)


def _describe_dynamics(chain: Chain) -> Iterator[Block]:
    """What the numbers of blocks with memory mean."""
    rows = [
        (str(k), name, f"{value:.5g}", unit)
        for k, (block, theta) in enumerate(zip(chain.blocks, chain.split(), strict=True), start=1)
        if block.states()
        for name, value, unit in block.describe_numbers(theta)
    ]
    if rows:
        yield DataTable(("block", "number", "value", "unit"), rows[:MOST_NUMBERS], right=(2,))
    if len(rows) > MOST_NUMBERS:
        left = len(rows) - MOST_NUMBERS
        yield Sentence(f"and {left} more numbers of blocks with memory; see --json")


def _describe_scores(found: Identified) -> Iterator[Block]:
    yield Heading("Scores, all of free runs: no measured output is fed back")
    rows = [
        (
            s.model,
            s.role,
            s.record,
            s.output,
            f"{s.fit:.2f}",
            *(f"{v:.4g} {_choose_difference_unit(s.unit)}".rstrip() for v in (s.rms, s.worst)),
        )
        for s in found.scores
    ]
    yield DataTable(SCORES, rows, right=(4, 5, 6))
    yield from map(Sentence, _describe_starts(found))


def _describe_starts(found: Identified) -> Iterator[str]:
    """In which state the runs of every record begin."""
    runs = [s for s in found.scores if s.model in ("model", "series")]
    for said in dict.fromkeys(s.begins for s in runs):
        names = dict.fromkeys(f"`{s.record}`" for s in runs if s.begins == said)
        yield f"Initial state of {', '.join(names)}: {said}"


def _choose_difference_unit(unit: str) -> str:
    return {"degC": "K", "1": ""}.get(unit, unit)


def _describe_search(searched: Searched) -> Iterator[Block]:
    yield Sentence(f"Structures, by {searched.by}; within 0.5 points the smallest is chosen")
    shown = searched.candidates[:MOST_ROWS]
    count = len(STRUCTURES) if any(c.fault for c in shown) else len(STRUCTURES) - 1
    rows = [
        (
            ("> " if c is searched.chosen else "  ") + c.structure,
            str(c.numbers),
            _write_score(c.estimation),
            _write_score(c.validation),
            f"{c.agreeing} of {c.searches}",
            f"{c.seconds:.1f}",
            c.fault,
        )[:count]
        for c in shown
    ]
    yield DataTable(STRUCTURES[:count], rows, right=(1, 2, 3, 5))
    if len(searched.candidates) > len(shown):
        yield Sentence(f"and {len(searched.candidates) - len(shown)} more, all worse")


def _write_score(value: float) -> str:
    return f"{value:.2f}" if value == value else "none"


def collect_warnings(found: Identified, records: Sequence[Sampled]) -> list[str]:
    """Sentences on what is to be known before the model is believed."""
    said = [f"{r.name}: {remark}" for r in records for remark in r.remarks]
    for one in found.estimates:
        said += one.remarks
        if one.options.starts > 1 and one.agreeing < ENOUGH:
            few = f"{one.agreeing} of {len(one.fits)} refined searches"
            said.append(
                f"`{one.chain.text()}`: only {few} ended within 0.1 point of the best, so that "
                "it may be a poor optimum; give more --starts."
            )
    said += [remark for searched in found.searches if searched is not None for remark in searched.remarks]
    roles = {score.role for score in found.scores}
    if "validation" not in roles and "other" not in roles:
        said.append(
            "Only the logs that were fitted are scored, which is no proof: at one cadence a slow "
            "block can stand for hysteresis. Give --validate a log of another cadence, such as "
            "slow ramps with minor loops."
        )
    if any(s is not None for s in found.searches) and "validation" in roles and "other" not in roles:
        said.append(
            "The validation logs chose the structure, so that their fit is no final figure; give "
            "--other a log that nothing has seen."
        )
    return said


def _collect_numbers(found: Identified, records: Sequence[Sampled]) -> dict[str, Any]:
    stages = zip(found.stages, found.estimates, found.searches, strict=True)
    return {
        "model": found.model.text(),
        "interval": found.model.interval,
        "free_run": True,
        "stages": [
            {
                "structure": one.chain.text(),
                "inputs": list(one.chain.input_names),
                "output": stage.output,
                "free_numbers": len(one.chain.theta),
                "numbers": dict(zip(one.chain.names(), map(float, one.chain.theta), strict=True)),
                "refined_fits": [float(fit) for fit in one.fits],
                "agreeing": int(one.agreeing),
                "search": None if searched is None else _collect_search(searched),
            }
            for stage, one, searched in stages
        ],
        "scores": [asdict(score) for score in found.scores],
        "warnings": collect_warnings(found, records),
    }


def _collect_search(searched: Searched) -> dict[str, Any]:
    return {
        "by": searched.by,
        "chosen": searched.chosen.structure,
        "complete": searched.complete,
        "candidates": [_collect_candidate(c) for c in searched.candidates],
    }


def _collect_candidate(one: StructureCandidate) -> dict[str, Any]:
    return {
        "structure": one.structure,
        "numbers": one.numbers,
        "estimation": one.estimation,
        "validation": one.validation,
        "agreeing": int(one.agreeing),
        "searches": one.searches,
        "seconds": one.seconds,
        "fault": one.fault,
    }
