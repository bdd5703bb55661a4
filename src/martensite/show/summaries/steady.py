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


def summarise_rest(state: SteadyState, title: str) -> Summary:
    """Return the summary of a steady state."""
    outputs = _choose_outputs(state)
    repeated = {name for name in outputs if name.endswith("hottest") and state.outputs[name] == _read_twin(state, name)}
    rows = [_write_row(name, one, state.outputs[name]) for name, one in outputs.items() if name not in repeated]
    signals = ", ".join(
        f"{one.name} = {show_quantity(state.signals[one.name], one.unit)}" for one in state.system.drives()
    )
    slowest = f", slowest time constant {state.time_constant:.3g} s" if 0.0 < state.time_constant < np.inf else ""
    words = f"steady state at {signals}, {_NAMES[state.start]}: {'stable' if state.stable else 'UNSTABLE'}{slowest}"
    blocks = [
        _describe_verdict(title, words, state.judgement, state.stable),
        DataTable(("quantity", "value", "unit", "column"), rows, right=(1,)),
        *_tell_neutral(state.stability),
        *map(Sentence, state.judgement.list_remedies()),
    ]
    numbers = {
        "kind": "rest",
        "signals": state.signals,
        "start": state.start,
        "outputs": {name: state.outputs[name] for name in outputs},
        "stable": state.stable,
        "time_constant": state.time_constant,
        "neutral": state.stability.neutral,
        "limits": state.judgement.to_dict(),
    }
    return Summary("", blocks, numbers)


_NAMES = {
    "cold": "reached from the cold state",
    "hot": "reached from the hot state",
    "state": "reached from another steady state",
}


def _describe_verdict(title: str, words: str, judged: Judgement, stable: bool) -> Sentence:
    limits = "All limits are kept." if judged.is_within_limits else judged.verdict
    return Sentence(
        f"{title}: {words}. {limits}", "bad" if not judged.is_within_limits else "good" if stable else "caution"
    )


def _choose_outputs(solution: SteadyState | PeriodicOrbit) -> dict[str, Output]:
    return {name: one for name, one in solution.system.outputs().items() if PROFILE not in name}


def _read_twin(state: SteadyState, name: str) -> float | None:
    """Return the temperature that belongs to an output `hottest`."""
    return state.outputs.get(f"{name.removesuffix('hottest')}temperature")


def _write_row(name: str, output: Output, *values: float) -> tuple[str, ...]:
    display_unit = units.of_column(name, output.unit)
    numbers = (show_quantity(one, output.unit, 4, display_unit).partition(" ")[0] for one in values)
    return (output.long_name, *numbers, typeset_unit(display_unit), name)


def _tell_neutral(stability: Stability) -> list[Block]:
    """Return the sentence on neutral directions, from hysteresis and counters."""
    if not stability.neutral:
        return []
    return [
        Sentence(
            f"Neutral directions: {stability.neutral}. They belong to hysteresis memory and counters, which keep a "
            "changed value after a disturbance."
        )
    ]


def summarise_cycle(cycle: PeriodicOrbit, title: str) -> Summary:
    """Return the summary of a limit cycle."""
    outputs = _choose_outputs(cycle)
    rows = [
        _write_row(name, one, *(float(f(cycle.outputs[name])) for f in (np.min, np.max)))
        for name, one in outputs.items()
    ]
    switched = isinstance(cycle, SwitchedCycle)
    on = f", switched on for {cycle.on_time:.4g} s" if isinstance(cycle, SwitchedCycle) else ""
    words = f"limit cycle of {cycle.period:.6g} s{on}: {'stable' if cycle.stable else 'UNSTABLE'}"
    blocks = [
        _describe_verdict(title, words, cycle.judgement, cycle.stable),
        Sentence(f"After one period, at most {100.0 * cycle.stability.largest:.3g} % of a small disturbance remain."),
        DataTable(("quantity", "min", "max", "unit", "column"), rows, right=(1, 2)),
        *_tell_neutral(cycle.stability),
        *map(Sentence, cycle.judgement.list_remedies()),
    ]
    numbers: dict[str, Any] = {
        "kind": "switched cycle" if switched else "cycle",
        "period": cycle.period,
        "outputs": {name: [float(np.min(cycle.outputs[name])), float(np.max(cycle.outputs[name]))] for name in outputs},
        "stable": cycle.stable,
        "multipliers": [[float(m.real), float(m.imag)] for m in cycle.stability.multipliers],
        "neutral": cycle.stability.neutral,
        "periods": cycle.periods,
        "limits": cycle.judgement.to_dict(),
    }
    if isinstance(cycle, SwitchedCycle):
        numbers["on_time"] = cycle.on_time
    return Summary("", blocks, numbers)


def summarise_response(
    curve: ResponseCurve, title: str, speed: str, boundaries: list[FoldCurve], sweeps: Sequence[ResponseSweep] = ()
) -> Summary:
    """Return the summary of a response curve, and the boundaries of its folds."""
    name = choose_output(curve)
    unit = curve.varied.unit
    places = _choose_points(curve)
    rows = [
        (
            show_quantity(float(curve.parameter[k]), unit),
            write_speed(float(curve.speed[k]), speed),
            show_quantity(float(curve.amplitude[name][k]), curve.units[name]),
            "fold" if curve.fold[k] else "stable" if curve.stable[k] else "unstable",
        )
        for k in places
    ]
    folds = int(curve.fold.sum())
    jumps = "The rotor jumps at the folds." if folds else "No jump was found."
    blocks: list[Block] = [
        Sentence(f"{title}: response curve of {len(curve.parameter)} points with {folds} folds. {jumps}"),
        DataTable((curve.varied.name, "rotor speed", f"amplitude of {name}", "stability"), rows, right=(0, 1, 2)),
        Sentence("Curves that are not connected to this one are not found."),
    ]
    for one in boundaries:
        blocks += _tell_boundary(one)
    runs = [
        {"parameter": one.parameter.tolist(), "speed": one.speed.tolist(), "amplitude": one.amplitude[name].tolist()}
        for one in sweeps
    ]
    return Summary("", blocks, _collect_response(curve, speed, boundaries) | {"runs": runs})


def _choose_points(curve: ResponseCurve) -> list[int]:
    spread = np.round(np.linspace(0, len(curve.parameter) - 1, SHOWN)).astype(int)
    return sorted({*spread.tolist(), *np.flatnonzero(curve.fold).tolist()})


def _tell_boundary(one: FoldCurve) -> list[Block]:
    spread = sorted({*np.round(np.linspace(0, len(one.first) - 1, SHOWN // 2)).astype(int).tolist()})
    rows = [
        (show_quantity(float(one.second[k]), one.units[1]), show_quantity(float(one.first[k]), one.units[0]))
        for k in spread
    ]
    return [DataTable((one.names[1], f"fold of {one.names[0]}"), rows, right=(0, 1))]


def _collect_response(curve: ResponseCurve, speed: str, boundaries: list[FoldCurve]) -> dict[str, Any]:
    return {
        "kind": "response",
        "over": curve.varied.name,
        "unit": curve.varied.unit,
        "parameter": curve.parameter.tolist(),
        "speed": curve.speed.tolist(),
        "amplitude": {name: column.tolist() for name, column in curve.amplitude.items() if PROFILE not in name},
        "stable": curve.stable.tolist(),
        "multiplier": curve.multiplier.tolist(),
        "neutral": curve.neutral.tolist(),
        "folds": [
            {
                "parameter": float(curve.parameter[k]),
                "speed": float(curve.speed[k]),
                "speed_shown": write_speed(float(curve.speed[k]), speed),
            }
            for k in np.flatnonzero(curve.fold)
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
