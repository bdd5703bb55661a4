"""A run of a scenario: its result, and how far it is from records and from pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base.formats import typeset_unit, write_difference, write_quantity
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary

if TYPE_CHECKING:
    from martensite.design.tuning.averaging import Averaging
    from martensite.scenario.compare import Agreement
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.result import Result

NOTHING = 1e-12
"""What is smaller is the error of rounding."""
AVERAGED = ("pulses - average", "RMS", "largest")
PEAKS = (
    ("hottest", "peak temperature", max),
    ("stress", "peak stress", max),
    ("force", "peak force", max),
    ("martensite_fraction", "least martensite fraction", min),
)
"""Output, what is said of it, and which end."""
COMPARED = ("computed - measured", "RMS", "largest", "at", "measured range")


def summarise_run(
    scenario: Scenario, result: Result, agreements: Sequence[Agreement] = (), averaging: Averaging | None = None
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
        Heading("Key results", detail=True),
        tabulate_key_results(result),
    ]
    data = {"title": scenario.title, **own.data} | {
        "cautions": scenario.cautions,
        "comparison": [asdict(agreement) for agreement in agreements],
        "averaging": _collect_averaging(averaging),
    }
    stroke = write_difference(result.stroke, result.unit(result.coordinate))
    return Summary(scenario.title, blocks, data, f"{own.lead}; stroke {stroke}")


def tabulate_key_results(result: Result) -> DataTable:
    """The few numbers by which runs are compared: strokes, peaks, energies, time beyond limits."""
    beyond = sum(alarm.duration for alarm in result.alarms)
    rows = [*_list_strokes(result), *_list_peaks(result), *_list_energies(result)]
    return DataTable(("result", "value"), [*rows, ("time beyond limits", f"{beyond:.4g} s")], right=(1,))


def _list_strokes(result: Result) -> Iterator[tuple[str, str]]:
    """How far each coordinate goes that is judged."""
    judged = {result.coordinate, *result.system.mechanism.convergence_scales()}
    for name, output in result.system.mechanism.outputs().items():
        if name in judged:
            words = "stroke ({})" if name == result.coordinate else "range of {}"
            size = write_difference(result.range(name), output.unit)
            yield words.format(output.long_name), size


def _list_peaks(result: Result) -> Iterator[tuple[str, str]]:
    """Highest temperature, stress and force of all elements, and the lowest martensite fraction."""
    ports = list(result.system.actuators())
    for name, words, choose in PEAKS if ports else ():
        columns = [result.system.label(port, name) for port in ports]
        value = choose(choose(result.columns[column]) for column in columns)
        value = value if abs(value) > NOTHING else 0.0
        number, _, unit = write_quantity(value, result.unit(columns[0]), 4).partition(" ")
        yield words, f"{number} {typeset_unit(unit)}".strip()


def _list_energies(result: Result) -> Iterator[tuple[str, str]]:
    """Each energy at the end, and the efficiency; none where a temperature is prescribed."""
    from martensite.design.analysis.energy import find_ways, integrate_energies

    actuators = result.system.actuators().values()
    if not actuators or any(one.source.sets_temperature for one in actuators):
        return
    ways = find_ways(result)
    found = integrate_energies(result, ways or [])
    yield "electrical energy in", f"{found.electrical[-1]:.4g} J"
    yield "heat to the surroundings", f"{found.lost[-1]:.4g} J"
    if ways is not None:
        yield "work given while pulling", f"{1e3 * found.work[-1]:.4g} mJ"
        yield "work taken back while stretched", f"{1e3 * found.returned[-1]:.4g} mJ"
        yield "efficiency (work over electrical)", f"{100.0 * found.efficiency[-1]:.4g} %"


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
        (names[name].long_name, *(write_difference(v, names[name].unit) for v in (d.rms, d.largest)))
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
