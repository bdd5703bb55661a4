"""A run of a scenario: its result, and how far it is from records and from pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base.formats import write_difference
from martensite.base.summary import Block, DataTable, Sentence, Summary

if TYPE_CHECKING:
    from martensite.design.tuning.averaging import Averaging
    from martensite.scenario.compare import Agreement
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.result import Result

AVERAGED = ("pulses - average", "RMS", "largest")
COMPARED = ("computed - measured", "RMS", "largest", "at", "measured range")


def summarise_run(
    scenario: Scenario,
    result: Result,
    agreements: Sequence[Agreement] = (),
    averaging: Averaging | None = None,
) -> Summary:
    """Everything about a run.

    Args:
        scenario: what was run.
        result: what came out.
        agreements: how far it is from the record it was compared with.
        averaging: what it leaves out by averaging over pulses, if that was asked for.
    """
    own = result.summary()
    warned = len(result.warnings)
    told, warnings = own.blocks[: len(own.blocks) - warned], own.blocks[len(own.blocks) - warned :]
    blocks = [
        *told,
        *_describe_agreements(result, agreements),
        *_describe_averaging(averaging),
        *(Sentence(f"Caution: {caution}", "caution") for caution in scenario.cautions),
        *warnings,
    ]
    data = {"title": scenario.title, **own.data} | {
        "cautions": scenario.cautions,
        "comparison": [asdict(agreement) for agreement in agreements],
        "averaging": _collect_averaging(averaging),
    }
    stroke = write_difference(result.stroke, result.unit(result.coordinate))
    return Summary(scenario.title, blocks, data, f"{own.lead}; stroke {stroke}")


def _describe_agreements(result: Result, agreements: Sequence[Agreement]) -> Iterator[Block]:
    rows = [
        (
            result.outputs[found.quantity].long_name,
            write_difference(found.rms, found.unit),
            write_difference(found.maximum, found.unit),
            f"{found.time:.4g} s",
            write_difference(found.range, found.unit),
        )
        for found in agreements
    ]
    if rows:
        yield DataTable(COMPARED, rows, right=(1, 2, 3, 4))


def _describe_averaging(found: Averaging | None) -> Iterator[Block]:
    if found is None:
        return
    names = found.average.outputs
    rows = [
        (
            names[name].long_name,
            *(write_difference(v, names[name].unit) for v in (d.rms, d.largest)),
        )
        for name, d in found.differences.items()
    ]
    yield DataTable(AVERAGED, rows, right=(1, 2))
    yield Sentence(
        f"pulses of {found.frequency:.6g} Hz make the temperature ripple by up to "
        f"{found.ripple:.3g} K (estimate {found.estimate:.3g} K)"
    )


def _collect_averaging(found: Averaging | None) -> dict[str, Any] | None:
    """What averaging leaves out, by name in SI."""
    if found is None:
        return None
    return {
        "frequency": found.frequency,
        "differences": {name: asdict(d) for name, d in found.differences.items()},
        "ripple": found.ripple,
        "estimate": found.estimate,
        "alarms": [asdict(alarm) for alarm in found.pulsed.result.alarms],
    }
