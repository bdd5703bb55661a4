"""What `identify` prints: scores of free runs, what was found, and how far to trust it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

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


def print_identified(
    found: Identified, written: Sequence[Path], records: Sequence[Sampled]
) -> None:
    """Print all there is to say of what was identified."""
    from martensite.cli import show

    for k, (stage, one) in enumerate(zip(found.stages, found.estimates, strict=True), start=1):
        chain = one.chain
        head = f"Stage {k}" if len(found.stages) > 1 else "Model"
        names = ", ".join(f"`{name}`" for name in chain.input_names)
        show.text(f"{head}: {names} -> `{stage.output}`: {chain.text()}", "bold")
        show.text(
            f"{len(chain.theta)} free numbers, sample time {chain.interval:.6g} s, "
            f"{one.options.starts} starts; {one.agreeing} of {len(one.fits)} refined searches "
            "agree within 0.1 point"
        )
        searched = found.searches[k - 1]
        if searched is not None:
            _print_search(searched)
        _print_dynamics(chain)
    _print_scores(found)
    for sentence in warnings(found, records):
        show.text(sentence, "yellow")
    for path in written:
        show.text(f"wrote {path}")


def _print_dynamics(chain: Chain) -> None:
    """What the numbers of blocks with memory mean."""
    from martensite.cli import show

    rows = [
        (str(k), name, f"{value:.5g}", unit)
        for k, (block, theta) in enumerate(zip(chain.blocks, chain.split(), strict=True), start=1)
        if block.states()
        for name, value, unit in block.shown(theta)
    ]
    if rows:
        show.table(("block", "number", "value", "unit"), rows[:MOST_NUMBERS], right="value")
    if len(rows) > MOST_NUMBERS:
        show.text(f"and {len(rows) - MOST_NUMBERS} more numbers of blocks with memory; see --json")


def _print_scores(found: Identified) -> None:
    from martensite.cli import show

    show.text("Scores, all of free runs: no measured output is fed back", "bold")
    rows = [
        (
            s.model, s.role, s.record, s.output, f"{s.fit:.2f}",
            f"{s.rms:.4g} {_difference(s.unit)}", f"{s.worst:.4g} {_difference(s.unit)}",
        )
        for s in found.scores
    ]  # fmt: skip
    columns = ("model", "used for", "record", "output", "fit [%]", "RMS error", "largest error")
    show.table(columns, rows, right="fit [%],RMS error,largest error")


def _difference(unit: str) -> str:
    """Unit of a difference."""
    return {"degC": "K", "1": ""}.get(unit, unit)


def _print_search(searched: Searched) -> None:
    from martensite.cli import show

    show.text(f"Structures, by {searched.by}; within 0.5 points the smallest is chosen")
    shown = list(searched.candidates[:MOST_ROWS])
    faulty = any(c.fault for c in shown)
    rows = [
        (
            ("> " if c is searched.chosen else "  ") + c.structure, str(c.numbers),
            _percent(c.estimation), _percent(c.validation), f"{c.agreeing} of {c.searches}",
            f"{c.seconds:.1f}", *((c.fault,) if faulty else ()),
        )
        for c in shown
    ]  # fmt: skip
    heads = ("structure", "numbers", "estimation [%]", "chosen by [%]", "agreeing", "s")
    heads = (*heads, "fault") if faulty else heads
    show.table(heads, rows, right="numbers,estimation [%],chosen by [%],s")
    if len(searched.candidates) > len(shown):
        show.text(f"and {len(searched.candidates) - len(shown)} more, all worse")


def _percent(value: float) -> str:
    return f"{value:.2f}" if value == value else "none"


def warnings(found: Identified, records: Sequence[Sampled]) -> list[str]:
    """Sentences on what is to be known before the model is believed."""
    said = [f"{r.name}: {remark}" for r in records for remark in r.remarks]
    for one in found.estimates:
        if one.options.starts > 1 and one.agreeing < ENOUGH:
            few = f"{one.agreeing} of {len(one.fits)} refined searches"
            said.append(
                f"`{one.chain.text()}`: only {few} ended within 0.1 point of the best, so that "
                "it may be a poor optimum; give more --starts."
            )
    roles = {score.role for score in found.scores}
    if "validation" not in roles and "other" not in roles:
        said.append(
            "Only the logs that were fitted are scored, which is no proof: at one cadence a slow "
            "block can stand for hysteresis. Give --validate a log of another cadence, such as "
            "slow ramps with minor loops."
        )
    if (
        any(s is not None for s in found.searches)
        and "validation" in roles
        and "other" not in roles
    ):
        said.append(
            "The validation logs chose the structure, so that their fit is no final figure; give "
            "--other a log that nothing has seen."
        )
    return said


def as_dict(
    found: Identified, written: Sequence[Path], records: Sequence[Sampled]
) -> dict[str, Any]:
    """All of it for JSON."""
    return {
        "model": found.model.text(),
        "interval": found.model.interval,
        "free_run": True,
        "stages": [
            {
                "structure": one.chain.text(), "inputs": list(one.chain.input_names),
                "output": stage.output, "free_numbers": len(one.chain.theta),
                "numbers": dict(zip(one.chain.names(), map(float, one.chain.theta), strict=True)),
                "refined_fits": [float(fit) for fit in one.fits], "agreeing": int(one.agreeing),
                "search": None if searched is None else _searched(searched),
            }
            for stage, one, searched in zip(
                found.stages, found.estimates, found.searches, strict=True
            )
        ],
        "scores": [asdict(score) for score in found.scores],
        "warnings": warnings(found, records),
        "files": [str(path) for path in written],
    }  # fmt: skip


def _searched(searched: Searched) -> dict[str, Any]:
    return {
        "by": searched.by,
        "chosen": searched.chosen.structure,
        "complete": searched.complete,
        "candidates": [_candidate(c) for c in searched.candidates],
    }


def _candidate(one: StructureCandidate) -> dict[str, Any]:
    return {
        "structure": one.structure, "numbers": one.numbers, "estimation": one.estimation,
        "validation": one.validation, "agreeing": int(one.agreeing), "searches": one.searches,
        "seconds": one.seconds, "fault": one.fault,
    }  # fmt: skip
