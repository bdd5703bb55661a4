"""Material point on a path: a law without wire, heat balance or mechanism.

On each leg, temperature and either stress or strain change linearly in time. Stress-driven legs evaluate the law;
strain-driven legs solve for the stress of every step (`simulate.compiled_law`). Tension and elongation are
positive. Strain counts from unloaded austenite at the reference temperature of the law.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import TYPE_CHECKING

from martensite.base.errors import InputError, ParameterError, SolveError, UnknownNameError, suggest_name
from martensite.base.status import Status
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.simulate.compiled_law import AUSTENITE, ROW, describe_compression, describe_forgotten_loops
from martensite.simulate.point_march import PathDriver, PathSection, PointTrack, march_point

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

RUNTIMES = ("floats", "c")
CONTROLS = ("stress", "strain")
JUDGED = {"strain": 1e-4, "stress": 1e6, "martensite": 0.01}
"""Judged columns with their smallest relevant ranges."""
STEPS = 100
MOST_STEPS = 100_000
"""Largest number of steps for refinement; a larger path has a warning."""


@dataclass(frozen=True, kw_only=True)
class PathLeg:
    """Straight leg of a path; omitted quantities remain constant."""

    temperature: float | None = None
    """At its end [K]."""
    stress: float | None = None
    """At its end [Pa]; not together with `strain`."""
    strain: float | None = None
    """At its end [-]; not together with `stress`."""
    hold: str | None = None
    """Constant quantity without given stress and strain: `stress` or `strain`.

    By default, the quantity that the previous leg prescribed, or stress at the start.
    """
    duration: float = 1.0
    """Duration [s], for rate-dependent laws."""
    steps: int | None = None
    """Samples on this leg and its coarsest steps; by default as for the whole path."""

    def __post_init__(self) -> None:
        if self.stress is not None and self.strain is not None:
            raise ParameterError("A leg takes `stress` or `strain` at its end, but both are given; leave one out.")
        if self.hold is not None and self.hold not in CONTROLS:
            raise ParameterError(f"Argument `hold` of a leg is `{self.hold}`. {suggest_name(self.hold, CONTROLS)}")
        if self.hold is not None and self.control is not None:
            raise ParameterError(f"A leg with a value of `{self.control}` holds nothing; leave `hold` out.")
        self._check_numbers()

    @property
    def control(self) -> str | None:
        """Return `stress` or `strain` if the leg gives its end, else None."""
        if self.stress is not None:
            return "stress"
        return None if self.strain is None else "strain"

    def _check_numbers(self) -> None:
        if not 0.0 < self.duration < math.inf:
            raise ParameterError(f"Argument `duration` of a leg must be above 0 s, but is {self.duration} s.")
        if self.steps is not None and self.steps < 1:
            raise ParameterError(f"Argument `steps` of a leg must be at least 1, but is {self.steps}.")
        for name in ("temperature", "stress", "strain"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise ParameterError(f"Argument `{name}` of a leg must be finite, but is {value}.")
        if self.temperature is not None and self.temperature <= 0.0:
            raise ParameterError(f"Argument `temperature` of a leg must be above 0 K, but is {self.temperature} K.")


@dataclass(frozen=True, eq=False)
class PointResult:
    """Path of a material point, with columns of equal length in SI."""

    law: AbstractLaw
    legs: tuple[PathLeg, ...]
    time: NDArray[np.float64]
    """[s]"""
    stress: NDArray[np.float64]
    """[Pa]"""
    strain: NDArray[np.float64]
    """Strain of the material [-], larger than a prescribed strain if slack."""
    temperature: NDArray[np.float64]
    """[K]"""
    martensite: NDArray[np.float64]
    """Martensite fraction [-]."""
    oriented: NDArray[np.float64]
    """Net oriented fraction [-]."""
    ends: list[int]
    """Index of the first sample, and of the last one of each leg."""
    status: Status
    residual: float
    """Largest mismatch of a fraction at the end of a strain-driven step [-]."""
    steps: int
    accuracy: float | None
    """Largest change on halving the steps, as a fraction of each range; None for a single run."""
    label: str = ""
    warnings: list[str] = field(default_factory=list[str])

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a column by name, in SI units, (samples,).

        Raises:
            UnknownNameError: the column does not exist.
        """
        if name not in COLUMNS:
            raise UnknownNameError("column", name, COLUMNS)
        return getattr(self, name)

    @property
    def work(self) -> float:
        """Return the work on the point along the path, ∫ σ dε [J/m³]: the loss of a closed loop."""
        import numpy as np

        return math.fsum((0.5 * (self.stress[1:] + self.stress[:-1]) * np.diff(self.strain)).tolist())


COLUMNS = ("time", "stress", "strain", "temperature", "martensite", "oriented")


def material_point(
    law: AbstractLaw,
    legs: Sequence[PathLeg],
    *,
    start: tuple[float, float],
    fractions: Fractions = AUSTENITE,
    steps: int = STEPS,
    tolerance: float | None = 1e-4,
    tension_only: bool = True,
    runtime: str = "floats",
    label: str = "",
) -> PointResult:
    """Simulate a law along a path of stress or strain and temperature.

    Steps are halved until strain, stress and martensite fraction at the samples change by less than `tolerance`
    times their range.

    Args:
        law: any law.
        legs: pieces of the path.
        start: stress [Pa] and temperature [K] where the path begins.
        fractions: martensite and net oriented fraction at the start [-]; austenite by default.
        steps: samples per leg, and its coarsest steps, where the leg does not say.
        tolerance: accepted change on halving, as a fraction of range; None for one run with
            exactly the given steps.
        tension_only: a strain-driven point goes slack instead of being compressed.
        runtime: floats (default), or c (compiled on the spot; for laws with many variables).
        label: a name for figures and tables.

    Raises:
        InputError: an argument is out of range.
        SolveError: a step could not be solved; the message gives where and a remedy.
    """
    _check_path(legs, start, fractions, steps, tolerance, runtime)
    sections = _fill_sections(legs, steps, start[1])
    drive = PathDriver(law, fractions, *start, sections, tension_only, runtime)
    track, accuracy = _refine_steps(drive, tolerance)
    if track.status.failed:
        raise SolveError(
            f"The law `{law.registered_name or type(law).__name__}` could not be driven along its "
            f"path: leg {track.leg + 1} failed at t = {track.time:.6g} s. "
            f"{_SENTENCES.get(track.status, track.status.sentence)}"
        )
    result = _build_result(law, legs, drive, track, accuracy, label)
    path = [result[name].tolist() for name in ("stress", "temperature", "martensite", "oriented")]
    result.warnings.extend([*describe_forgotten_loops(law, *path), *describe_compression(law, path[0])])
    if tolerance is not None and accuracy is not None and accuracy > tolerance:
        result.warnings.append(
            f"Warning: the tolerance of {tolerance:.1e} was not reached in {result.steps:,} "
            f"steps; halving still changes the path by {accuracy:.1e} of its range."
        )
    return result


_SENTENCES = {
    Status.UNSOLVED: (
        "The stress of a prescribed strain was not found to its tolerance. Try more steps, a "
        "slower leg, or a start at which the given fractions are stable."
    )
}


def _check_path(
    legs: Sequence[PathLeg],
    start: tuple[float, float],
    fractions: Fractions,
    steps: int,
    tolerance: float | None,
    runtime: str,
) -> None:
    if not legs:
        raise ParameterError("A path needs at least one leg; none given.")
    if not (math.isfinite(start[0]) and 0.0 < start[1] < math.inf):
        raise ParameterError(
            f"Argument `start` must be a finite stress [Pa] and a temperature above 0 K, but is {start}."
        )
    martensite, oriented = fractions
    if not (0.0 <= martensite <= 1.0 and abs(oriented) <= martensite):
        raise ParameterError(
            "Argument `fractions` must be a martensite fraction between 0 and 1 and an oriented "
            f"one of at most that size, but is ({martensite}, {oriented})."
        )
    if steps < 1:
        raise ParameterError(f"Argument `steps` must be at least 1, but is {steps}.")
    if tolerance is not None and not 0.0 < tolerance < math.inf:
        raise ParameterError(f"Argument `tolerance` must be above 0, but is {tolerance}.")
    if runtime not in RUNTIMES:
        raise InputError(f"No runtime named `{runtime}`. {suggest_name(runtime, RUNTIMES)}")


def _fill_sections(legs: Sequence[PathLeg], steps: int, temperature: float) -> list[PathSection]:
    """Return the legs with all values that are known before the simulation."""
    sections: list[PathSection] = []
    control, first = "stress", temperature
    for leg in legs:
        control = leg.control or leg.hold or control
        last = first if leg.temperature is None else leg.temperature
        target = leg.strain if control == "strain" else leg.stress
        sections.append(PathSection(control, target, first, last, leg.duration, leg.steps or steps))
        first = last
    return sections


def _refine_steps(drive: PathDriver, tolerance: float | None) -> tuple[PointTrack, float | None]:
    """Halve the steps to the tolerance; return the finest run and its last change."""
    finer, track = 1, march_point(drive, 1)
    if tolerance is None:
        return track, None
    accuracy = math.inf
    while accuracy > tolerance or track.status.failed:
        if finer > 1 and 2 * finer * drive.samples > MOST_STEPS:
            break
        finer *= 2
        fine = march_point(drive, finer)
        track, accuracy = fine, _compare_tracks(track, fine)
    return track, accuracy


def _compare_tracks(coarse: PointTrack, fine: PointTrack) -> float:
    """Return the largest difference of judged columns, as a fraction of their range."""
    if len(coarse.rows) != len(fine.rows):
        return math.inf
    worst = 0.0
    for name, least in JUDGED.items():
        i = ROW.index(name)
        a, b = [row[i] for row in coarse.rows], [row[i] for row in fine.rows]
        apart = max(abs(x - y) for x, y in zip(a, b, strict=True))
        worst = max(worst, apart / max(max(b) - min(b), least))
    return worst if math.isfinite(worst) else math.inf


def _build_result(
    law: AbstractLaw, legs: Sequence[PathLeg], drive: PathDriver, track: PointTrack, accuracy: float | None, label: str
) -> PointResult:
    import numpy as np

    columns = dict(zip(ROW, np.array(track.rows, float).T.copy(), strict=True))
    times, temperatures = [0.0], [drive.temperature]
    for section in drive.sections:
        shares = [k / section.samples for k in range(1, section.samples + 1)]
        begin, warmer = times[-1], section.last - section.first
        times += [begin + share * section.duration for share in shares]
        temperatures += [section.first + share * warmer for share in shares]
    return PointResult(
        law=law,
        legs=tuple(legs),
        time=np.array(times),
        temperature=np.array(temperatures),
        stress=columns["stress"],
        strain=columns["strain"],
        martensite=columns["martensite"],
        oriented=columns["oriented"],
        ends=list(accumulate((section.samples for section in drive.sections), initial=0)),
        status=track.status,
        residual=track.residual,
        steps=track.steps,
        accuracy=accuracy,
        label=label,
    )
