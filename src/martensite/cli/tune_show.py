"""What a tuning shows and writes: a table of before and after, the scenario, the figure."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.cli import show
from martensite.cli.outputs import Outputs, parts

if TYPE_CHECKING:
    from martensite.cli.tune_run import Tuning

HEAD = ("", "before", "after")
PER_TIME = {"Ki": "/s", "Kd": "*s"}
"""What gains in seconds have beside the unit of Kp."""
SHARES = ("overshoot",)


def shown(found: Tuning, outputs: Outputs, json: bool) -> None:
    """Write the files, then print."""
    with parts(outputs) as files:
        if files.data is not None:
            files.data.write_text(saved(found), encoding="utf-8")
        if files.figure is not None:
            _draw(found, files.figure)
    if json:
        show.as_json(as_dict(found) | {"files": [str(path) for path in outputs.paths()]})
        return
    _print(found, outputs.paths())


def saved(found: Tuning) -> str:
    """The scenario with the new numbers, as TOML."""
    import tomllib

    from martensite.scenario.overrides import as_toml, change_document

    document = tomllib.loads(found.scenario.text)
    numbers = {found.scenario.places.path(p): float(v) for p, v in found.found.after.items()}
    return f"# tuned: {found.origin}\n\n{as_toml(change_document(document, numbers))}"


def as_dict(found: Tuning) -> dict[str, Any]:
    """A tuning, ready for JSON; numbers in SI."""
    tuned, places = found.found, found.scenario.places
    step = found.tests.step if found.tests else None
    cycle = found.tests.cycle if found.tests else None
    return {
        "title": found.scenario.title,
        "method": found.given.method,
        "origin": found.origin,
        "loop": found.drive,
        "parameters": {
            places.path(path): {"before": tuned.before[path], "after": value, "unit": unit}
            for path, value, unit in _gains(found)
        },
        "before": tuned.measured_before.to_dict() | {"cost": tuned.cost_before},
        "after": tuned.measured.to_dict() | {"cost": tuned.cost},
        "runs": tuned.evaluations,
        "gradients": tuned.gradients,
        "step_test": None if step is None else {
            name: getattr(step, name).first_order._asdict() for name in ("heating", "cooling")
        },
        "relay_test": None if cycle is None else {
            "ultimate_gain": cycle.gain, "ultimate_period": cycle.period,
            "amplitude": cycle.amplitude, "asymmetry": cycle.asymmetry, "steady": cycle.steady,
        },
        "other_plants": None if found.ratio is None else {
            "count": found.others, "itae_ratio_median": found.ratio.median,
            "itae_ratio_worst": found.ratio.worst, "share_improved": found.ratio.won,
        },
        "notes": tuned.notes,
    }  # fmt: skip


def _gains(found: Tuning) -> list[tuple[str, float, str]]:
    """Path, number and unit of what was tuned."""
    from martensite.control.loop.names import list_readings

    bench, places = found.found.bench, found.scenario.places
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    controller = bench.controllers.members()[found.drive]
    drives = {drive.name: drive.unit for drive in bench.plant.drives()}
    base = f"{drives[found.drive]}/{list_readings(bench)[controller.measured].unit}"
    seconds = getattr(controller, "gains_are", "") == "in-seconds"
    rows: list[tuple[str, float, str]] = []
    for path, value in found.found.after.items():
        name = path.rpartition(".")[2]
        gain = name in ("Kp", "Ki", "Kd")
        unit = base + (PER_TIME.get(name, "") if seconds else "")
        rows.append((path, value, unit if gain else places.unit(leaves[path])))
    return rows


def _print(found: Tuning, written: list[Path]) -> None:
    tuned = found.found
    show.text(found.scenario.title, "bold")
    show.text(f"{found.origin}; {tuned.evaluations:,} runs, {tuned.gradients:,} with derivatives")
    _print_tests(found)
    show.table(HEAD, _rows(found), right="before,after")
    if found.ratio is not None:
        show.text(
            f"on {found.others} other plants: ITAE after/before {found.ratio.median:.3g} in the "
            f"median, {found.ratio.worst:.3g} at worst, better on {100.0 * found.ratio.won:.3g} %"
        )
    for note in tuned.notes:
        show.text(f"Caution: {note}", "yellow")
    for path in written:
        show.text(f"wrote {path}")


def _print_tests(found: Tuning) -> None:
    if found.tests is None or found.given.method == "gradient":
        return
    for name in ("heating", "cooling"):
        one = getattr(found.tests.step, name)
        K, T, L = one.first_order
        show.text(f"{name}: K {K:.4g}, T {T:.4g} s, L {L:.4g} s (fit {one.fit:.1f} %)")
    cycle = found.tests.cycle
    if cycle is not None:
        steady = "" if cycle.steady else ", not steady"
        show.text(
            f"relay: K_u {cycle.gain:.4g}, P_u {cycle.period:.4g} s, off/on "
            f"{cycle.asymmetry:.3g}{steady}"
        )


def _rows(found: Tuning) -> list[tuple[str, str, str]]:
    tuned, places = found.found, found.scenario.places
    rows = [
        (f"{places.path(path)} [{unit}]", f"{tuned.before[path]:.5g}", f"{value:.5g}")
        for path, value, unit in _gains(found)
    ]
    rows.append(("cost", f"{tuned.cost_before:.4g}", f"{tuned.cost:.4g}"))
    after = tuned.measured.to_dict()
    return rows + [
        (name, _number(name, value, found), _number(name, after[name], found))
        for name, value in tuned.measured_before.to_dict().items()
    ]


def _number(name: str, value: float, found: Tuning) -> str:
    """A measure in a unit that people read."""
    from martensite.base import units
    from martensite.design.tuning.loop_runs import judged_output
    from martensite.design.tuning.measures import UNITS

    bench = found.found.bench
    unit = bench.outputs()[judged_output(bench, found.drive)].unit
    if math.isinf(value):
        return "never"
    if name == "hottest":
        return show.quantity(value, "K")
    if "{}" not in UNITS[name]:
        label = "" if UNITS[name] in ("1", "signal") else f" {UNITS[name]}"
        return f"{100.0 * value:.3g} %" if name in SHARES else f"{value:.4g}{label}"
    shown_unit = {"degC": "K"}.get(
        units.choose_readable_unit(unit), units.choose_readable_unit(unit)
    )
    factor, _ = units.find_conversion(shown_unit, unit)
    return f"{value / factor:.4g} {UNITS[name].format(shown_unit)}"


def _draw(found: Tuning, path: Path) -> None:
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.tuning import plot_tuning

    write_figure(plot_tuning(found.found, found.drive, found.scenario.title), path)
