"""A tuning, with its tests and other plants: before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.formats import choose_difference_unit, write_quantity
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.control.tuning.loop_runs import find_judged_output
from martensite.control.tuning.measures import UNITS

if TYPE_CHECKING:
    from martensite.control.rules.rule_starts import LoopTests
    from martensite.control.tuning.bench_tuning import TunedBench
    from martensite.scenario.scenario import Scenario

HEADINGS = ("", "before", "after")
SHARES = ("overshoot",)


@dataclass(frozen=True, eq=False)
class TuningOutcome:
    """A finished tuning."""

    scenario: Scenario
    method: str
    """`rules`, `relay` or `gradient`."""
    found: TunedBench
    drive: str
    tests: LoopTests | None
    origin: str
    """Origin of the values, in words."""


def summarise_tuning(found: TuningOutcome) -> Summary:
    """Return everything about a tuning."""
    tuned = found.found
    lead = f"{found.origin}; {tuned.evaluations:,} runs, {tuned.gradients:,} with derivatives"
    blocks = [
        *_describe_tests(found),
        DataTable(HEADINGS, _table_rows(found), right=(1, 2)),
        *(Sentence(f"Caution: {note}", "caution") for note in tuned.notes),
    ]
    return Summary(found.scenario.title, blocks, _collect_numbers(found), lead)


def _describe_tests(found: TuningOutcome) -> Iterator[Block]:
    if found.tests is None or found.method == "gradient":
        return
    for name in ("heating", "cooling"):
        one = getattr(found.tests.step, name)
        K, T, L = one.first_order
        yield Sentence(f"{name}: K {K:.4g}, T {T:.4g} s, L {L:.4g} s (fit {one.fit:.1f} %)")
    cycle = found.tests.cycle
    if cycle is not None:
        steady = "" if cycle.steady else ", not steady"
        yield Sentence(f"relay: K_u {cycle.gain:.4g}, P_u {cycle.period:.4g} s, off/on {cycle.asymmetry:.3g}{steady}")


def _table_rows(found: TuningOutcome) -> list[tuple[str, str, str]]:
    tuned, places = found.found, found.scenario.places
    rows = [
        (f"{places.path(path)} [{unit}]", f"{tuned.before[path]:.5g}", f"{value:.5g}")
        for path, value, unit in _list_gains(found)
    ]
    rows.append(("cost", f"{tuned.cost_before:.4g}", f"{tuned.cost:.4g}"))
    after = tuned.measured.to_dict()
    return rows + [
        (name, _write_measure(name, value, found), _write_measure(name, after[name], found))
        for name, value in tuned.measured_before.to_dict().items()
    ]


def _write_measure(name: str, value: float, found: TuningOutcome) -> str:
    bench = found.found.bench
    unit = bench.outputs()[find_judged_output(bench, found.drive)].unit
    if math.isinf(value):
        return "never"
    if name == "hottest":
        return write_quantity(value, "K")
    if "{}" not in UNITS[name]:
        label = "" if UNITS[name] in ("1", "signal") else f" {UNITS[name]}"
        return f"{100.0 * value:.3g} %" if name in SHARES else f"{value:.4g}{label}"
    shown, factor = choose_difference_unit(unit)
    return f"{value / factor:.4g} {UNITS[name].format(shown)}"


def _collect_numbers(found: TuningOutcome) -> dict[str, Any]:
    tuned, places = found.found, found.scenario.places
    step = found.tests.step if found.tests else None
    cycle = found.tests.cycle if found.tests else None
    return {
        "title": found.scenario.title,
        "method": found.method,
        "origin": found.origin,
        "loop": found.drive,
        "parameters": {
            places.path(path): {"before": tuned.before[path], "after": value, "unit": unit}
            for path, value, unit in _list_gains(found)
        },
        "before": tuned.measured_before.to_dict() | {"cost": tuned.cost_before},
        "after": tuned.measured.to_dict() | {"cost": tuned.cost},
        "runs": tuned.evaluations,
        "gradients": tuned.gradients,
        "step_test": None
        if step is None
        else {name: getattr(step, name).first_order._asdict() for name in ("heating", "cooling")},
        "relay_test": None
        if cycle is None
        else {
            "ultimate_gain": cycle.gain,
            "ultimate_period": cycle.period,
            "amplitude": cycle.amplitude,
            "asymmetry": cycle.asymmetry,
            "steady": cycle.steady,
        },
        "notes": tuned.notes,
    }


def _list_gains(found: TuningOutcome) -> list[tuple[str, float, str]]:
    """Return the path, number and unit of what was tuned."""
    bench, places = found.found.bench, found.scenario.places
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    return [(path, value, places.unit(leaves[path])) for path, value in found.found.after.items()]
