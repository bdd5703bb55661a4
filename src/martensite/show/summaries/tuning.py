"""Summary of a tuning: tests, parameters and measures before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.formats import choose_difference_unit, typeset_unit
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.control.tuning.loop_runs import find_judged_output
from martensite.control.tuning.measures import UNITS

if TYPE_CHECKING:
    from martensite.control.rules.rule_starts import LoopTests
    from martensite.control.tuning.bench_tuning import TunedBench
    from martensite.scenario.scenario import Scenario

HEADINGS = ("quantity", "before", "after", "unit")
NAMES = {"itae": "ITAE", "iae": "IAE", "ise": "ISE", "hottest": "peak temperature"}
"""Names of measures on screens, if different from JSON."""
SHARES = ("overshoot",)


@dataclass(frozen=True, eq=False)
class TuningOutcome:
    """A finished tuning."""

    scenario: Scenario
    method: str
    """`rules`, `relay` or `gradient`."""
    tuned_bench: TunedBench
    drive: str
    tests: LoopTests | None
    origin: str
    """Description of the origin of the values."""


def summarise_tuning(outcome: TuningOutcome) -> Summary:
    """Return the summary of a tuning."""
    tuned = outcome.tuned_bench
    lead = f"{outcome.origin}; {tuned.evaluations:,} runs ({tuned.gradients:,} with derivatives)"
    blocks = [
        *_describe_tests(outcome),
        DataTable(HEADINGS, _table_rows(outcome), right=(1, 2)),
        *(Sentence(f"Caution: {note}", "caution") for note in tuned.notes),
    ]
    return Summary(outcome.scenario.title, blocks, _collect_numbers(outcome), lead)


def _describe_tests(outcome: TuningOutcome) -> Iterator[Block]:
    if outcome.tests is None or outcome.method == "gradient":
        return
    for name in ("heating", "cooling"):
        one = getattr(outcome.tests.step, name)
        K, T, L = one.first_order
        yield Sentence(f"Step test, {name}: gain K {K:.4g}, lag T {T:.4g} s, delay L {L:.4g} s (fit {one.fit:.1f} %).")
    cycle = outcome.tests.cycle
    if cycle is not None:
        steady = "" if cycle.steady else "; the cycle is not steady"
        yield Sentence(
            f"Relay test: ultimate gain K_u {cycle.gain:.4g}, period P_u {cycle.period:.4g} s, off/on ratio "
            f"{cycle.asymmetry:.3g}{steady}."
        )


def _table_rows(outcome: TuningOutcome) -> list[tuple[str, ...]]:
    tuned, places = outcome.tuned_bench, outcome.scenario.places
    rows: list[tuple[str, ...]] = [
        (places.path(path), f"{tuned.before[path]:.4g}", f"{value:.4g}", typeset_unit(unit))
        for path, value, unit in _list_gains(outcome)
    ]
    rows.append(("cost", f"{tuned.cost_before:.4g}", f"{tuned.cost:.4g}", ""))
    after = tuned.measures.to_dict()
    return rows + [
        _write_row(name, (value, after[name]), outcome) for name, value in tuned.measures_before.to_dict().items()
    ]


def _write_row(name: str, values: tuple[float, float], outcome: TuningOutcome) -> tuple[str, ...]:
    bench = outcome.tuned_bench.bench
    unit = bench.outputs()[find_judged_output(bench, outcome.drive)].unit
    display_unit, factor = choose_difference_unit(unit) if "{}" in UNITS[name] else ("", 1.0)
    label = "" if UNITS[name] in ("1", "signal") else UNITS[name].format(display_unit)
    if name in SHARES:
        factor, label = 0.01, "%"
    zero = 0.0
    if name == "hottest":
        zero, label = 273.15, "°C"
    cells = ("never" if math.isinf(value) else f"{(value - zero) / factor:.4g}" for value in values)
    return (NAMES.get(name, name.replace("_", " ")), *cells, typeset_unit(label))


def _collect_numbers(outcome: TuningOutcome) -> dict[str, Any]:
    tuned, places = outcome.tuned_bench, outcome.scenario.places
    step = outcome.tests.step if outcome.tests else None
    cycle = outcome.tests.cycle if outcome.tests else None
    return {
        "title": outcome.scenario.title,
        "method": outcome.method,
        "origin": outcome.origin,
        "loop": outcome.drive,
        "parameters": {
            places.path(path): {"before": tuned.before[path], "after": value, "unit": unit}
            for path, value, unit in _list_gains(outcome)
        },
        "before": tuned.measures_before.to_dict() | {"cost": tuned.cost_before},
        "after": tuned.measures.to_dict() | {"cost": tuned.cost},
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


def _list_gains(outcome: TuningOutcome) -> list[tuple[str, float, str]]:
    bench, places = outcome.tuned_bench.bench, outcome.scenario.places
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    return [(path, value, places.unit(leaves[path])) for path, value in outcome.tuned_bench.after.items()]
