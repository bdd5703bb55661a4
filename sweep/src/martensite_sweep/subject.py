"""What of a scenario can be varied, and what all of its variants have in common."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError
from martensite.kernels.compiler import find_compiler
from martensite.scenario.assemble import waveform_path
from martensite.scenario.place_units import PlaceUnits
from martensite.search.free_numbers import Target
from martensite.signals.base import AbstractWaveform
from martensite.simulate.drive_waveforms import by_name
from martensite.simulate.variants import ACCELERATED, VariantSetup
from martensite_sweep.cuda.device import open_device

SWITCHES = "automatic_from", "automatic_until"
"""Numbers of a bench that no program has: they are in what is played."""

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.scenario.scenario import Scenario


def build_course(
    scenario: Scenario, step: float | None = None, runtime: str | None = None, precision: str = "float64"
) -> VariantSetup:
    """What all variants of a scenario have in common.

    Args:
        scenario: the nominal one.
        step: longest of equal steps [s]; by default that of the scenario, or None for runs to its
            tolerance.
        runtime: c, jax, cuda or floats; by default c if there is a compiler.
        precision: float64, or float32 on JAX or CUDA.

    Raises:
        InputError: runs on JAX or in float32 have no step, or there is no CUDA device.
    """
    system, samples = scenario.require_home("Every run of a sweep").whole, scenario.samples
    interval = system.sample_time()
    if interval:
        samples = min(samples, max(int(scenario.duration / interval + 1e-6) + 1, 2))
    chosen = runtime or ("c" if find_compiler() is not None else "floats")
    found = interval or (scenario.step if step is None else step)
    if found is None and (chosen == "jax" or (chosen == "cuda" and precision != "float64")):
        raise InputError(
            "A sweep on JAX or in float32 runs on equal steps; say how long they are at most by `--step`, or take the "
            "runtime `c`."
        )
    if chosen == "cuda":
        open_device()  # missed before anything is written
    return VariantSetup(
        system,
        list_waveforms(scenario),
        scenario.duration,
        samples,
        found,
        (),
        chosen,
        precision,
        tolerance=scenario.tolerance,
        devices=None if chosen in ACCELERATED else 1,
    )


def list_waveforms(scenario: Scenario) -> dict[str, AbstractWaveform]:
    """All that drives a scenario, by name; references and noise of a bench among it."""
    played = dict(by_name(scenario.system, scenario.waveform))
    if scenario.bench is None:
        return played
    from martensite.control.loop.run import noise_waveforms, reference_waveforms

    played |= reference_waveforms(scenario.bench)
    return played | noise_waveforms(scenario.bench, scenario.duration, scenario.seed)


def list_targets(scenario: Scenario) -> dict[str, Target]:
    """Every number of a scenario that can be varied, by its path in the scenario."""
    references = _list_references(scenario.bench) if scenario.bench else {}
    found = [*_list_system_targets(scenario, references), *_list_waveform_targets(scenario)]
    return {target.name: target for target in found}


def _list_system_targets(scenario: Scenario, references: Mapping[str, str]) -> Iterator[Target]:
    """Numbers of the system or bench; those of a reference belong to its waveform."""
    for leaf in scenario.whole.leaves():
        name, unit = scenario.places.path(leaf.path), scenario.places.unit(leaf)
        if scenario.places.is_copy(leaf.path) or not math.isfinite(leaf.value):
            continue
        if name.rpartition(".")[2] in SWITCHES:
            continue
        begin = next((b for b in references if leaf.path.startswith(b)), None)
        drive = None if begin is None else references[begin]
        path = leaf.path.removeprefix(begin or "")
        yield Target(name, path, unit, float(leaf.value), leaf.declared.doc, drive)


def _list_references(bench: Bench) -> dict[str, str]:
    """Beginning of a path in a bench -> the name under which its waveform is played."""
    from martensite.control.loop.names import list_hands, list_references

    members = bench.controllers.members()
    found = {f"controllers.{one}.reference.": name for one, name in zip(members, list_references(bench), strict=True)}
    return found | {f"controllers.{one}.manual.signal.": name for one, (name, _) in list_hands(bench).items()}


def _list_waveform_targets(scenario: Scenario) -> Iterator[Target]:
    """Numbers of the waveforms of a scenario."""
    signals = {drive.name: drive.unit for drive in scenario.system.drives()}
    played: Mapping[str, Any] = by_name(scenario.system, scenario.waveform)
    for name, waveform in played.items():
        begin = waveform_path(scenario.system, name, scenario.places.drive)
        for leaf in waveform.leaves():
            if math.isfinite(leaf.value):
                unit = PlaceUnits(signals[name]).unit(leaf.declared)
                words = leaf.declared.doc
                yield Target(begin + leaf.path, leaf.path, unit, float(leaf.value), words, name)
