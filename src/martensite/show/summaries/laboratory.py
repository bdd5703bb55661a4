"""Laboratory tests: a film coefficient, a DC motor, isobaric cycles by tangents, a free vibration."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.base.confidence import LEVEL, Interval
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.characterise.estimate import MeasuredValue, propagate_errors
from martensite.characterise.film_coefficient import FilmFit
from martensite.characterise.film_report import FilmReport
from martensite.characterise.free_vibration import LogDecrement, damping_ratio, moving_mass
from martensite.characterise.motor_constants import UNITS, MotorConstants
from martensite.characterise.spectrum import SpectralPeak
from martensite.characterise.tangent_fit import TangentFit
from martensite.characterise.tangent_points import TangentPoints

FILM = "W/m^2/K"
FILM_UNITS = (FILM, "W/m^2/K^2", "W/m^2/K^3")
SYMBOLS = {
    "resistance": "R",
    "inductance": "L",
    "constant": "K_T = K_B",
    "friction": "b",
    "dry_friction": "F_c",
    "inertia": "J",
}
ZERO = 273.15
CYCLE = ("A_s [degC]", "A_f [degC]", "M_s [degC]", "M_f [degC]", "H [%]", "residual [%]")
"""Columns of the table of all cycles."""
MOST_REMARKS = 8
"""Remarks on cycles that are listed."""
POINTS = (
    "stress [MPa]",
    "A_s [degC]",
    "A_f",
    "half",
    "M_s [degC]",
    "M_f",
    "half",
    "H [%]",
    "residual [%]",
    "stroke [%]",
    "log",
)
FOUND = ("quantity", "value", "95 % interval", "unit", "meaning")


def summarise_film(report: FilmReport, forms: Sequence[str], origin: str) -> Summary:
    """Return the summary of fits of a film coefficient."""
    title = f"h(T) from {len(report.points)} points, {origin}"
    return Summary(title, list(_describe_film(report, forms)), {"origin": origin} | report.to_dict())


def _describe_film(report: FilmReport, forms: Sequence[str]) -> Iterator[Block]:
    yield DataTable(
        ("form", *(f"h{k} [{unit}]" for k, unit in enumerate(FILM_UNITS)), "R²", "adjusted", "AICc"),
        [_form_row(form, report.fits[form], report.level) for form in forms],
        right=range(1, 7),
    )
    yield Sentence(f"T in degC; ± half the {100.0 * report.level:g} % interval.")
    yield _tabulate_ambients(report)
    for verdict in report.verdicts:
        yield Sentence(verdict.sentence, "good" if verdict.supported else "caution")


def _tabulate_ambients(report: FilmReport) -> Block:
    if report.ambient is None:
        return Sentence("The ambient temperature behind h is not given: what h owes to it is not tested.")
    rows = [
        (
            f"{shift.points.ambient:g}",
            f"{shift.points.ambient - report.points.ambient:+g}",
            ", ".join(f"{h:.1f}" for h in shift.points.h),
            write_coefficient(shift.line, 1, report.level),
            f"{shift.line.r_squared:.4f}",
        )
        for shift in report.ambient.shifts
    ]
    head = ("ambient [degC]", "shift [K]", f"h [{FILM}]", f"slope [{FILM_UNITS[1]}]", "R²")
    return DataTable(head, rows, right=range(5))


def _form_row(form: str, fit: FilmFit, level: float) -> tuple[str, ...]:
    cells = (write_coefficient(fit, k, level) if k in fit.terms else "0" for k in range(3))
    scores = (fit.r_squared, 5), (fit.adjusted, 3), (fit.aicc, 2)
    # scores without enough points are omitted
    texts = (f"{number:.{d}f}" if math.isfinite(number) else "" for number, d in scores)
    return form, *cells, *texts


def write_coefficient(fit: FilmFit, term: int, level: float) -> str:
    """Return a coefficient with half its interval."""
    value = fit.coefficients[term]
    low, high = fit.interval(term, level)
    half = 0.5 * (high - low)
    return f"{value:.5g} ± {half:.2g}" if math.isfinite(half) else f"{value:.5g}"


def summarise_motor(constants: MotorConstants, states: int) -> Summary:
    """Return the summary of a motor identified from a number of steady states."""
    rows = [
        (f"{symbol}, {name.replace('_', ' ')}", getattr(constants, name).write(), UNITS[name])
        for name, symbol in SYMBOLS.items()
        if getattr(constants, name) is not None
    ]
    blocks: list[Block] = [
        DataTable(("constant", "value", "unit"), rows, right=(1,)),
        Sentence(f"± half the {100 * LEVEL:g} % interval; a number that was given has none."),
    ]
    if constants.run_up_time is not None:
        blocks.append(Sentence(f"R J/(K_T K_B) = {constants.run_up_time:.4g} s"))
    blocks += [Sentence(remark, "caution") for remark in constants.remarks]
    return Summary(f"DC motor from {states} steady states", blocks, constants.to_dict())


def summarise_tangents(tangents: TangentFit | TangentPoints) -> Summary:
    """Return the summary of one or several cycles."""
    levels = tangents.levels if isinstance(tangents, TangentFit) else [tangents]
    title = f"Tangents of {len(levels)} isobaric cycle{'s' * (len(levels) > 1)}"
    blocks: list[Block] = [DataTable(POINTS, [_point_row(one) for one in levels], right=range(len(POINTS) - 1))]
    if isinstance(tangents, TangentFit):
        blocks.append(DataTable(FOUND, list(_estimate_rows(tangents)), right=(1, 2)))
        data = tangents.to_dict()
    else:
        hint = "C_A, C_M and temperatures at zero stress need cycles at two or more stresses."
        blocks.append(Sentence(hint))
        data = {"levels": [tangents.to_dict()]}
    blocks += [Sentence(remark, "caution") for remark in tangents.remarks]
    return Summary(title, blocks, data)


def summarise_cycles(cycles: Sequence[TangentPoints | str]) -> Summary:
    """Return one table with every cycle of a record, the median of each column, and its drift per cycle."""
    good = [one for one in cycles if not isinstance(one, str)]
    rows: list[tuple[str, ...]] = []
    for number, one in enumerate(cycles, start=1):
        rows.append((f"{number}", *[""] * len(CYCLE), one) if isinstance(one, str) else _cycle_row(number, one))
    if len(good) > 1:
        table = np.array([_list_cycle(one) for one in good])
        numbers = np.array([one.cycle.number for one in good], float)
        drift = np.polyfit(numbers, table, 1)[0]
        rows += [
            ("median", *_format_cycle(np.median(table, axis=0)), ""),
            ("drift", *_format_cycle(drift), "per cycle"),
        ]
    data = {"cycles": [{"reason": one} if isinstance(one, str) else one.to_dict() for one in cycles]}
    table = DataTable(("cycle", *CYCLE, "remark"), rows, right=range(1, 1 + len(CYCLE)))
    remarks = list(dict.fromkeys(text for one in good for text in one.remarks if not text.startswith("Cycle ")))
    title = f"Tangents of {len(good)} of {len(cycles)} isobaric cycles"
    return Summary(title, [table, *(Sentence(text, "caution") for text in remarks[:MOST_REMARKS])], data)


def _list_cycle(one: TangentPoints) -> list[float]:
    """Return the entries of a cycle in the units of `CYCLE`."""
    kelvin = [getattr(one, name) - ZERO for name in ("A_s", "A_f", "M_s", "M_f")]
    return [*kelvin, 100.0 * one.H, 100.0 * one.residual_strain]


def _format_cycle(values: Iterable[float]) -> list[str]:
    numbers = list(values)
    return [*(f"{x:.2f}" for x in numbers[:4]), *(f"{x:.3f}" for x in numbers[4:])]


def _cycle_row(number: int, one: TangentPoints) -> tuple[str, ...]:
    return (f"{number}", *_format_cycle(_list_cycle(one)), "")


def _point_row(points: TangentPoints) -> tuple[str, ...]:
    temperatures = (f"{getattr(points, name) - ZERO:.2f}" for name in ("A_s", "A_f", "A_half", "M_s", "M_f", "M_half"))
    strains = (f"{100.0 * e:.3f}" for e in (points.H, points.residual_strain, points.stroke))
    return (f"{points.stress / 1e6:.4g}", *temperatures, *strains, points.name)


def _estimate_rows(fit: TangentFit) -> Iterator[tuple[str, ...]]:
    at_zero = (
        ("A_s", "austenite start at zero stress"),
        ("A_f", "austenite finish"),
        ("M_s", "martensite start"),
        ("M_f", "martensite finish"),
    )
    for name, meaning in at_zero:
        yield _write_estimate(name, getattr(fit, name), "degC", 1.0, meaning, ZERO, ".2f")
    for name, one in (("C_A", fit.reverse), ("C_M", fit.forward)):
        numbers = _write_numbers(one.slope, one.slope_interval(), 1e6)
        yield name, *numbers, "MPa/K", f"common slope of {one.names[0]} and {one.names[1]}"
    yield _write_estimate("eps_L", fit.eps_L, "%", 0.01, "mean transformation strain")
    form = fit.strain
    if form.H_k is not None:
        yield _write_estimate("H_min", form.H_min, "%", 0.01, "H at no stress")
        yield _write_estimate("H_sat", form.H_sat, "%", 0.01, "H at high stress")
        yield _write_estimate("H_k", form.H_k, "1/MPa", 1e-6, "rate of saturation")
    if form.sigma_crit is not None:
        yield _write_estimate("sigma_crit", form.sigma_crit, "MPa", 1e6, "stress at which H begins to grow")


def _write_estimate(
    name: str, estimate: MeasuredValue, unit: str, factor: float, meaning: str, zero: float = 0.0, digits: str = ".4g"
) -> tuple[str, ...]:
    return name, *_write_numbers(estimate.value, estimate.interval(), factor, zero, digits), unit, meaning


def _write_numbers(
    value: float, interval: Interval, factor: float, zero: float = 0.0, digits: str = ".4g"
) -> tuple[str, str]:
    """Return a value and its interval in a unit; `unknown` for an interval without bounds."""
    low, high = ((end - zero) / factor for end in interval)
    bounds = f"{low:{digits}} to {high:{digits}}" if math.isfinite(high - low) else "unknown"
    return f"{(value - zero) / factor:{digits}}", bounds


@dataclass(frozen=True)
class Oscillator:
    """Stiffness or moving mass of an oscillator [SI]; at most one is given."""

    stiffness: float | None
    mass: float | None

    def derive_numbers(self, fit: LogDecrement) -> dict[str, tuple[MeasuredValue, str]]:
        """Return mass or stiffness, and damping, by name with units; empty if nothing is given."""

        def rate(period: float, delta: float) -> float:
            return math.hypot(2.0 * math.pi, delta) / period

        def damping(period: float, delta: float) -> float:
            omega = rate(period, delta)
            half = self.mass * omega if self.mass is not None else (self.stiffness or 0.0) / omega
            return 2.0 * damping_ratio(delta) * half

        c = propagate_errors(damping, fit.period, fit.decrement)
        if self.stiffness is not None:
            k = self.stiffness
            estimate = propagate_errors(lambda f: moving_mass(k, f), fit.frequency)
            return {"moving_mass": (estimate, "kg"), "damping": (c, "N*s/m")}
        if self.mass is not None:
            m = self.mass
            estimate = propagate_errors(lambda f: m * (2.0 * math.pi * f) ** 2, fit.frequency)
            return {"stiffness": (estimate, "N/m"), "damping": (c, "N*s/m")}
        return {}


def summarise_vibration(peak: SpectralPeak, fit: LogDecrement, oscillator: Oscillator, title: str) -> Summary:
    """Return the summary of a free vibration."""
    derived = oscillator.derive_numbers(fit)
    entries = [
        ("natural frequency", fit.frequency, "Hz"),
        ("damped frequency", fit.damped_frequency, "Hz"),
        ("logarithmic decrement", fit.decrement, ""),
        ("damping ratio", fit.zeta, ""),
        *((name.replace("_", " "), *one) for name, one in derived.items()),
    ]
    rows = [(name, one.write(), unit) for name, one, unit in entries]
    blocks = [
        Sentence(
            f"Spectrum: {peak.frequency:.5g} Hz, resolution {peak.resolution:.3g} Hz, "
            f"{peak.prominence:.3g} times the median of the spectrum"
        ),
        DataTable(("quantity", "value", "unit"), rows, right=(1,)),
        Sentence(f"± half the {100 * LEVEL:g} % interval; rest at {fit.offset.value:.4g}."),
    ]
    data = {
        "spectrum": peak.to_dict(),
        "decay": fit.to_dict(),
        "derived": {name: number.to_dict() for name, (number, _) in derived.items()},
    }
    return Summary(title, blocks, data)
