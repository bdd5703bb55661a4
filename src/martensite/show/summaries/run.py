"""Summaries of a run of a scenario, and of laws on a path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, NamedTuple

from martensite.base.formats import show_quantity, write_difference
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.control.loop.names import describe_controllers
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.judgement import judge_run
from martensite.simulate.measures.base import parse_measure
from martensite.simulate.path_stages import PathStage, list_stages, residual_strain

if TYPE_CHECKING:
    from martensite.design.analysis.averaging import Averaging
    from martensite.scenario.compare import Agreement
    from martensite.scenario.law_logs import LawComparison
    from martensite.scenario.laws import ConfiguredLaw
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.point import PointResult
    from martensite.simulate.result import Result

NOTHING = 1e-12
"""Size below which a value is rounding error."""
AVERAGED = ("pulses - average", "RMS", "largest")
ENERGIES = {
    "electrical": ("E", "electrical energy in", "J", 1.0),
    "lost": ("Q", "heat lost to the ambient", "J", 1.0),
    "stored": ("E − Q", "stored in the elements", "J", 1.0),
    "work": ("W", "work during contraction", "mJ", 1e3),
    "returned": ("W_b", "work returned during extension", "mJ", 1e3),
}
"""Energy -> symbol, meaning, shown unit, and its number per joule."""
PEAKS = (
    ("hottest", "peak temperature", max),
    ("stress", "peak stress", max),
    ("force", "peak force", max),
    ("martensite_fraction", "minimum martensite fraction", min),
)
"""Output, its description, and the function of its extreme."""
COMPARED = ("computed - measured", "RMS", "largest", "at", "measured range")
COLUMNS = ("path", "leg", "ξ", "transforms", "starts", "half", "ends", "strain", "stress")


def summarise_run(
    scenario: Scenario,
    result: Result,
    agreements: Sequence[Agreement] = (),
    averaging: Averaging | None = None,
    measures: Sequence[str] = (),
) -> Summary:
    """Return the summary of a run, with some measures and error bounds."""
    own = result.summary()
    measured = [measure_run(result, words) for words in measures]
    controllers = {} if scenario.bench is None else describe_controllers(scenario.bench)
    warned = len(result.warnings)
    own_blocks, warnings = own.blocks[: len(own.blocks) - warned], own.blocks[len(own.blocks) - warned :]
    guard = _collect_guard(scenario)
    verdict = describe_run(scenario.title, result)
    blocks = [
        verdict,
        Sentence(write_key_numbers(result)),
        *own_blocks,
        Sentence(f"{own.lead}."),
        *([tabulate_measures(measured)] if measured else []),
        *_describe_agreements(result, agreements),
        *_describe_averaging(averaging),
        *(Sentence(f"Controller of {drive}, {words}.") for drive, words in controllers.items()),
        *(Sentence(f"Caution: {caution}", "caution") for caution in scenario.cautions),
        *guard.blocks,
        *warnings,
        *(Sentence(words) for words in judge_run(result).list_remedies()),
        Heading("Key results", detail=True),
        tabulate_key_results(result),
    ]
    data = {"title": scenario.title, **own.data} | {
        "measures": {one.words: one.to_dict() for one in measured},
        "cautions": scenario.cautions,
        "controllers": controllers,
        "comparison": [asdict(agreement) for agreement in agreements],
        "averaging": _collect_averaging(averaging),
        "noise_seed": result.seed,
        **guard.data,
    }
    return Summary("", blocks, data)


def describe_run(title: str, result: Result) -> Sentence:
    """Return the verdict on a run: all limits kept, exceeded limits, or the stop."""
    judged = judge_run(result)
    stopped = next((words for words in result.warnings if words.startswith("The run stopped")), "")
    if judged.is_within_limits and result.status.failed:
        return Sentence(f"{title}: FAILED. {stopped or result.status.sentence}", "bad")
    if not judged.is_within_limits:
        return Sentence(f"{title}: {judged.verdict}", "bad")
    count = len(result.warnings)
    noted = f" ({count} {'warning' if count == 1 else 'warnings'} below)" if count else ""
    return Sentence(f"{title}: OK, all limits kept{noted}.", "caution" if count else "good")


def write_key_numbers(result: Result) -> str:
    """Return stroke and peaks of a run in one line, temperature and stress with their limits."""
    stroke = write_difference(result.stroke, result.unit(result.coordinate))
    parts = [f"Stroke {stroke}", *(f"{name} {value}" for name, value in list_peaks(result, limits=True))]
    return ", ".join(parts) + "."


class MeasuredNumber(NamedTuple):
    """A measure of a run [SI] with an error bound, or None."""

    words: str
    value: float
    unit: str
    bound: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return value, unit and bound for JSON."""
        return {"value": self.value, "unit": self.unit, "bound": self.bound}

    def write_bound(self) -> str:
        """Return the bound in the unit of the value."""
        if self.bound is None:
            return "not estimated"
        return f"± {write_difference(self.bound, self.unit, 2)}"


def measure_run(result: Result, words: str) -> MeasuredNumber:
    """Return a measure of a single run, such as `max(temperature)`, with a bound on its error."""
    unit = parse_measure(words).unit_in(result.system)
    return MeasuredNumber(words, result.measure(words), unit, result.bound(words))


def tabulate_measures(measured: Sequence[MeasuredNumber]) -> DataTable:
    """Return a table of measures with error bounds."""
    rows = [(one.words, show_quantity(one.value, one.unit, 6), one.write_bound()) for one in measured]
    return DataTable(("measure", "value", "error"), rows, right=(1, 2))


def _collect_guard(scenario: Scenario) -> Summary:
    if scenario.bench is None:
        return Summary("", [], {})
    from martensite.scenario.guard_report import collect_guard, describe_guard

    guard = collect_guard(scenario) or {}
    return Summary("", list(describe_guard(guard)), {"guard": guard})


def tabulate_key_results(result: Result) -> DataTable:
    """Return key results: strokes, peaks, energies, time beyond limits."""
    beyond = sum(alarm.duration for alarm in result.alarms)
    rows = [*_list_strokes(result), *list_peaks(result), *_list_energies(result)]
    return DataTable(("result", "value"), [*rows, ("time beyond limits", f"{beyond:.4g} s")], right=(1,))


def _list_strokes(result: Result) -> Iterator[tuple[str, str]]:
    judged = {result.coordinate, *result.system.mechanism.convergence_scales()}
    for name, output in result.system.mechanism.outputs().items():
        if name in judged:
            words = "stroke ({})" if name == result.coordinate else "range of {}"
            size = write_difference(result.range(name), output.unit, name=name)
            yield words.format(output.long_name), size


def list_peaks(result: Result, limits: bool = False) -> Iterator[tuple[str, str]]:
    """Yield the highest temperature, stress and force of all elements, and the lowest martensite fraction.

    Args:
        result: single run.
        limits: whether to add the limits of temperature and stress.
    """
    actuators = result.system.actuators()
    for name, words, choose in PEAKS if actuators else ():
        columns = {result.system.label(port, name): one for port, one in actuators.items()}
        ends = {column: choose(result.find_range(column)) for column in columns}
        column = choose(ends, key=ends.__getitem__)
        value = ends[column] if abs(ends[column]) > NOTHING else 0.0
        limit = getattr(columns[column].element.limits, f"{words.partition(' ')[2]}_limit", math.inf)
        limited = limits and math.isfinite(limit)
        suffix = f" (limit {show_quantity(limit, result.unit(column))})" if limited else ""
        yield words, show_quantity(value, result.unit(column)) + suffix


def _list_energies(result: Result) -> Iterator[tuple[str, str]]:
    from martensite.simulate.energy import find_ways, integrate_energies

    actuators = result.system.actuators().values()
    if not actuators or any(one.source.sets_temperature for one in actuators):
        return
    fine = add_step_rows(result)
    ways = find_ways(fine)
    energies = integrate_energies(fine, ways or [])
    for name in ("electrical", "lost") if ways is None else ("electrical", "lost", "work", "returned"):
        _, words, unit, factor = ENERGIES[name]
        yield words, f"{factor * getattr(energies, name)[-1]:.4g} {unit}"
    if ways is not None:
        yield "efficiency (work over electrical)", f"{100.0 * energies.efficiency[-1]:.4g} %"


def _describe_agreements(result: Result, agreements: Sequence[Agreement]) -> Iterator[Block]:
    rows = [
        (
            result.outputs[agreement.quantity].long_name,
            write_difference(agreement.rms, agreement.unit),
            write_difference(agreement.maximum, agreement.unit),
            f"{agreement.time:.4g} s",
            write_difference(agreement.range, agreement.unit),
        )
        for agreement in agreements
    ]
    if rows:
        yield DataTable(COMPARED, rows, right=(1, 2, 3, 4))


def _describe_averaging(averaging: Averaging | None) -> Iterator[Block]:
    if averaging is None:
        return
    names = averaging.average.outputs
    rows = [
        (names[name].long_name, *(write_difference(v, names[name].unit) for v in (d.rms, d.largest)))
        for name, d in averaging.differences.items()
    ]
    yield DataTable(AVERAGED, rows, right=(1, 2))
    yield Sentence(
        f"Pulses of {averaging.frequency:.6g} Hz cause a temperature ripple of up to "
        f"{averaging.ripple:.3g} K (estimate {averaging.estimate:.3g} K)."
    )


def _collect_averaging(averaging: Averaging | None) -> dict[str, Any] | None:
    if averaging is None:
        return None
    return {
        "frequency": averaging.frequency,
        "differences": {name: asdict(d) for name, d in averaging.differences.items()},
        "ripple": averaging.ripple,
        "estimate": averaging.estimate,
        "alarms": [asdict(alarm) for alarm in averaging.pulsed.result.alarms],
    }


def summarise_laws(path: str, dressed: Sequence[ConfiguredLaw], results: Sequence[Sequence[PointResult]]) -> Summary:
    """Return the summary of laws on a named path."""
    pairs = list(zip(dressed, results, strict=True))
    blocks = [block for one, own in pairs for block in _describe_law(path, one, own)]
    return Summary("", blocks, {"path": path, "laws": [_collect_law(*pair) for pair in pairs]})


def _describe_law(path: str, one: ConfiguredLaw, own: Sequence[PointResult]) -> Iterator[Block]:
    source = "" if one.material is None else f", material {one.material.name}"
    yield Heading(f"{one.law.registered_name} on the path {path}{source}")
    rows = [row for result in own for row in _list_rows(result)]
    yield DataTable(COLUMNS, rows, right=(2, 4, 5, 6, 7, 8))
    yield from (Sentence(_tell_rest(result)) for result in own)
    yield from (Sentence(f"Caution: {caution}", "caution") for caution in one.cautions)
    yield from (Sentence(words, "caution") for result in own for words in result.warnings)


def _collect_law(one: ConfiguredLaw, own: Sequence[PointResult]) -> dict[str, Any]:
    return {
        "name": one.law.registered_name,
        "material": None if one.material is None else one.material.name,
        "cautions": one.cautions,
        "paths": [_collect_path(result) for result in own],
    }


def _collect_path(result: PointResult) -> dict[str, Any]:
    return {
        "label": result.label,
        "status": result.status.name,
        "steps": result.steps,
        "accuracy": result.accuracy,
        "residual_strain": residual_strain(result),
        "work": result.work,
        "warnings": result.warnings,
        "legs": [_describe_leg(stage) for stage in list_stages(result)],
    }


def _describe_leg(stage: PathStage) -> dict[str, Any]:
    spots = None if stage.spots is None else [one._asdict() for one in stage.spots]
    return asdict(stage) | {"spots": spots, "end": stage.end._asdict()}


def _tell_rest(result: PointResult) -> str:
    accuracy = "" if result.accuracy is None else f", error at most {result.accuracy:.1e} of each range"
    return (
        f"{result.label}: residual strain {100.0 * residual_strain(result):.3f} %, work "
        f"{result.work / 1e6:.3f} MJ/m³ ({result.steps:,} steps{accuracy})"
    )


def _list_rows(result: PointResult) -> list[tuple[str, ...]]:
    label = result.label.replace(" ", "\u00a0")
    return [(label if i == 0 else "", *_write_stage(i + 1, stage)) for i, stage in enumerate(list_stages(result))]


def _write_stage(number: int, stage: PathStage) -> tuple[str, ...]:
    spots = [_write_spot(stage, i) for i in range(3)]
    change = f"{stage.martensite:+.3f}" if stage.process != "orientation" else "0"
    strain, stress = f"{100.0 * stage.strain:.3f} %", f"{stage.end.stress / 1e6:.1f} MPa"
    return f"{number} {stage.kind}", change, stage.process, *spots, strain, stress


def _write_spot(stage: PathStage, i: int) -> str:
    if stage.spots is None:
        return ""
    spot, parts = stage.spots[i], list[str]()
    if "temperature" in stage.varies:
        parts.append(f"{spot.temperature - 273.15:.1f} °C")
    if "stress" in stage.varies:
        parts.append(f"{spot.stress / 1e6:.1f} MPa")
    return ", ".join(parts)


def summarise_law_logs(comparisons: Sequence[LawComparison]) -> Summary:
    """Return the deviations of laws from logs."""
    data: list[dict[str, Any]] = []
    for one in comparisons:
        law, source = one.configured.law.registered_name, one.configured.material
        names = {"law": law, "material": "" if source is None else source.name, "log": one.log}
        largest = float(abs(one.misfit).max())
        numbers = {"compared": one.compared, "rms": one.rms, "largest": largest, "shift": one.shift}
        data.append(names | numbers | {"cautions": [*one.configured.cautions, *one.result.warnings]})
    rows = [
        (*list(one.values())[:4], *(f"{100.0 * one[n]:.3g} %" for n in ("rms", "largest", "shift"))) for one in data
    ]
    cautions = dict.fromkeys(words for one in data for words in one["cautions"])
    blocks: list[Block] = [
        DataTable(("law", "material", "log", "compared", "RMS", "largest", "strain offset"), rows, right=(4, 5, 6)),
        Sentence("Differences are percentages of the recorded range. Strain offsets were fitted to each log."),
        *(Sentence(f"Caution: {words}", "caution") for words in cautions),
    ]
    return Summary("Laws compared with a log", blocks, {"laws": data})
