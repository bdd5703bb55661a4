"""Steady states, cycles and response curves, in readable units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.formats import show_quantity, typeset_unit
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.control.loop.switched_cycles import SwitchedCycle
from martensite.simulate.judgement import Judgement
from martensite.simulate.steady.curves import FoldCurve
from martensite.simulate.steady.cycles import PeriodicOrbit
from martensite.simulate.steady.equilibria import SteadyState
from martensite.simulate.steady.periodic_motion import Stability
from martensite.simulate.steady.readable import choose_output, convert_speed
from martensite.simulate.steady.rotations import ResponseCurve, ResponseSweep

SPEEDS = ("rpm", "rad/s", "Hz")
"""Units of the rotor speed."""
SHOWN = 12
"""Largest number of listed points."""
PROFILE = "["
"""Mark in the name of an output of a single cell, which is omitted."""


def write_speed(speed: float, unit: str) -> str:
    """Return the rotor speed [rad/s] in a unit."""
    return f"{convert_speed(speed, unit):.4g} {unit}"


def summarise_rest(found: SteadyState, title: str) -> Summary:
    """Return the summary of a steady state."""
    shown = _choose_outputs(found)
    repeated = {name for name in shown if name.endswith("hottest") and found.outputs[name] == _read_twin(found, name)}
    rows = [_write_row(name, one, found.outputs[name]) for name, one in shown.items() if name not in repeated]
    held = ", ".join(
        f"{one.name} = {show_quantity(found.signals[one.name], one.unit)}" for one in found.system.drives()
    )
    slowest = f", slowest time constant {found.time_constant:.3g} s" if 0.0 < found.time_constant < np.inf else ""
    words = f"steady state at {held}, {_NAMES[found.start]}: {'stable' if found.stable else 'UNSTABLE'}{slowest}"
    blocks = [
        _describe_verdict(title, words, found.judgement, found.stable),
        DataTable(("quantity", "value", "unit", "column"), rows, right=(1,)),
        *_tell_neutral(found.stability),
        *map(Sentence, found.judgement.list_remedies()),
    ]
    numbers = {
        "kind": "rest",
        "signals": found.signals,
        "start": found.start,
        "outputs": {name: found.outputs[name] for name in shown},
        "stable": found.stable,
        "time_constant": found.time_constant,
        "neutral": found.stability.neutral,
        "limits": found.judgement.to_dict(),
    }
    return Summary("", blocks, numbers)


_NAMES = {
    "cold": "reached from the cold state",
    "hot": "reached from the hot state",
    "state": "reached from another steady state",
}


def _describe_verdict(title: str, words: str, judged: Judgement, stable: bool) -> Sentence:
    limits = "All limits are kept." if judged.kept else judged.verdict
    return Sentence(f"{title}: {words}. {limits}", "bad" if not judged.kept else "good" if stable else "caution")


def _choose_outputs(found: SteadyState | PeriodicOrbit) -> dict[str, Output]:
    return {name: one for name, one in found.system.outputs().items() if PROFILE not in name}


def _read_twin(found: SteadyState, name: str) -> float | None:
    """Return the temperature that belongs to an output `hottest`."""
    return found.outputs.get(f"{name.removesuffix('hottest')}temperature")


def _write_row(name: str, output: Output, *values: float) -> tuple[str, ...]:
    shown = units.of_column(name, output.unit)
    numbers = (show_quantity(one, output.unit, 4, shown).partition(" ")[0] for one in values)
    return (output.long_name, *numbers, typeset_unit(shown), name)


def _tell_neutral(found: Stability) -> list[Block]:
    """Return the sentence on neutral directions, from hysteresis and counters."""
    if not found.neutral:
        return []
    return [
        Sentence(
            f"Neutral directions: {found.neutral}. They belong to hysteresis memory and counters, which keep a changed "
            "value after a disturbance."
        )
    ]


def summarise_cycle(found: PeriodicOrbit, title: str) -> Summary:
    """Return the summary of a limit cycle."""
    shown = _choose_outputs(found)
    rows = [
        _write_row(name, one, *(float(f(found.outputs[name])) for f in (np.min, np.max))) for name, one in shown.items()
    ]
    switched = isinstance(found, SwitchedCycle)
    on = f", switched on for {found.on_time:.4g} s" if isinstance(found, SwitchedCycle) else ""
    words = f"limit cycle of {found.period:.6g} s{on}: {'stable' if found.stable else 'UNSTABLE'}"
    blocks = [
        _describe_verdict(title, words, found.judgement, found.stable),
        Sentence(f"After one period, at most {100.0 * found.stability.largest:.3g} % of a small disturbance remain."),
        DataTable(("quantity", "min", "max", "unit", "column"), rows, right=(1, 2)),
        *_tell_neutral(found.stability),
        *map(Sentence, found.judgement.list_remedies()),
    ]
    numbers: dict[str, Any] = {
        "kind": "switched cycle" if switched else "cycle",
        "period": found.period,
        "outputs": {name: [float(np.min(found.outputs[name])), float(np.max(found.outputs[name]))] for name in shown},
        "stable": found.stable,
        "multipliers": [[float(m.real), float(m.imag)] for m in found.stability.multipliers],
        "neutral": found.stability.neutral,
        "periods": found.periods,
        "limits": found.judgement.to_dict(),
    }
    if isinstance(found, SwitchedCycle):
        numbers["on_time"] = found.on_time
    return Summary("", blocks, numbers)


def summarise_response(
    found: ResponseCurve, title: str, speed: str, boundaries: list[FoldCurve], sweeps: Sequence[ResponseSweep] = ()
) -> Summary:
    """Return the summary of a response curve, and the boundaries of its folds."""
    name = choose_output(found)
    unit = found.varied.unit
    places = _choose_points(found)
    rows = [
        (
            show_quantity(float(found.parameter[k]), unit),
            write_speed(float(found.speed[k]), speed),
            show_quantity(float(found.amplitude[name][k]), found.units[name]),
            "fold" if found.fold[k] else "stable" if found.stable[k] else "unstable",
        )
        for k in places
    ]
    folds = int(found.fold.sum())
    jumps = "The rotor jumps at the folds." if folds else "No jump was found."
    blocks: list[Block] = [
        Sentence(f"{title}: response curve of {len(found.parameter)} points with {folds} folds. {jumps}"),
        DataTable((found.varied.name, "rotor speed", f"amplitude of {name}", "stability"), rows, right=(0, 1, 2)),
        Sentence("Curves that are not connected to this one are not found."),
    ]
    for one in boundaries:
        blocks += _tell_boundary(one)
    runs = [
        {"parameter": one.parameter.tolist(), "speed": one.speed.tolist(), "amplitude": one.amplitude[name].tolist()}
        for one in sweeps
    ]
    return Summary("", blocks, _collect_response(found, speed, boundaries) | {"runs": runs})


def _choose_points(found: ResponseCurve) -> list[int]:
    spread = np.round(np.linspace(0, len(found.parameter) - 1, SHOWN)).astype(int)
    return sorted({*spread.tolist(), *np.flatnonzero(found.fold).tolist()})


def _tell_boundary(one: FoldCurve) -> list[Block]:
    spread = sorted({*np.round(np.linspace(0, len(one.first) - 1, SHOWN // 2)).astype(int).tolist()})
    rows = [
        (show_quantity(float(one.second[k]), one.units[1]), show_quantity(float(one.first[k]), one.units[0]))
        for k in spread
    ]
    return [DataTable((one.names[1], f"fold of {one.names[0]}"), rows, right=(0, 1))]


def _collect_response(found: ResponseCurve, speed: str, boundaries: list[FoldCurve]) -> dict[str, Any]:
    return {
        "kind": "response",
        "over": found.varied.name,
        "unit": found.varied.unit,
        "parameter": found.parameter.tolist(),
        "speed": found.speed.tolist(),
        "amplitude": {name: column.tolist() for name, column in found.amplitude.items() if PROFILE not in name},
        "stable": found.stable.tolist(),
        "multiplier": found.multiplier.tolist(),
        "neutral": found.neutral.tolist(),
        "folds": [
            {
                "parameter": float(found.parameter[k]),
                "speed": float(found.speed[k]),
                "speed_shown": write_speed(float(found.speed[k]), speed),
            }
            for k in np.flatnonzero(found.fold)
        ],
        "boundaries": [
            {
                "of": list(one.names),
                "units": list(one.units),
                "first": one.first.tolist(),
                "second": one.second.tolist(),
            }
            for one in boundaries
        ],
    }
