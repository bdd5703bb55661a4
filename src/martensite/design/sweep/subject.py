"""Variable parameters of a scenario, and the common setup of its variants."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.base.errors import InputError
from martensite.kernels.compiler import find_compiler
from martensite.signals.base import AbstractWaveform
from martensite.simulate.cuda.device import open_device
from martensite.simulate.drive_waveforms import by_name
from martensite.simulate.variants import VariantSetup

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario


def build_course(
    scenario: Scenario, step: float | None = None, runtime: str | None = None, precision: str = "float64"
) -> VariantSetup:
    """Return the common setup of all variants of a scenario.

    Args:
        scenario: nominal scenario.
        step: longest of equal steps [s], by default as in the scenario; None for runs to its tolerance.
        runtime: c, cuda or floats, by default c with a compiler.
        precision: float64, or float32 on CUDA.

    Raises:
        InputError: runs in float32 have no step, or a CUDA device is missing.
    """
    system, samples = scenario.require_home("Every run of a sweep").whole, scenario.samples
    interval = system.sample_time()
    if interval:
        samples = min(samples, max(int(scenario.duration / interval + 1e-6) + 1, 2))
    chosen = runtime or ("c" if find_compiler() is not None else "floats")
    longest = interval or (scenario.step if step is None else step)
    if longest is None and chosen == "cuda" and precision != "float64":
        raise InputError(
            "A sweep in float32 runs on equal steps; give the longest one by `--step`, or leave out `--precision`."
        )
    if chosen == "cuda":
        open_device()  # raises before files are written
    return VariantSetup(
        system,
        list_waveforms(scenario),
        scenario.duration,
        samples,
        longest,
        (),
        chosen,
        precision,
        tolerance=scenario.tolerance,
        devices=None if chosen == "cuda" else 1,
    )


def list_waveforms(scenario: Scenario) -> dict[str, AbstractWaveform]:
    """Return all signals of a scenario by name, with references and noise of a bench."""
    played = dict(by_name(scenario.system, scenario.waveform))
    if scenario.bench is None:
        return played
    from martensite.control.loop.run import noise_waveforms, reference_waveforms

    played |= reference_waveforms(scenario.bench)
    return played | noise_waveforms(scenario.bench, scenario.duration, scenario.seed)
