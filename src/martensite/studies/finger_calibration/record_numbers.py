"""Numbers of the data: parameters determined by one calibration test, and by more records."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from martensite.search.identifiability import Identifiability, assess_identifiability
from martensite.search.uncertainty import Uncertainty, estimate_uncertainty
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import EVERY, JOINT, NEAR, Data
from martensite.studies.finger_calibration.searches import best_fit
from martensite.studies.tables import Printed

SURE = 2.0
"""Standard errors within which a parameter counts as recovered."""
CHOSEN_ELSE = ("E_M", "T_L", "Delta_sigma", "dsigma_dT")
"""Parameters with σ_L fixed."""


def compute_record(printed: Printed) -> dict[str, Any]:
    """Return the number of determined parameters, and the accuracy of their recovery."""
    weak, count = assess_records(NEAR, printed).weak, len(printed.searched)
    near, joint = (parameter_errors(data, printed) for data in (NEAR, JOINT))
    slopes = [one.numbers["dsigma_dT"] for one in (near, joint)]
    pair = ("Delta_sigma", "dsigma_dT")
    return {
        "count": float(count - sum(one.exact for one in weak)),
        "lost": " ".join(one.sentence for one in weak),
        "again": [row for data in EVERY for row in list_again(data, printed)],
        "joint_slope": slopes[0] / slopes[1],
        "near_slope": slopes[0] / 1e6,
        "joint_error": slopes[1] / 1e6,
        "near": near,
        "joint": joint,
        "correlation": near.correlation[pair],
        "joint_correlation": joint.correlation[pair],
    }


def table_numbers(printed: Printed) -> dict[str, float]:
    """Return the searched parameters of Table 1 [SI]."""
    return {one.name: one.value for one in printed.searched}


@dataclass(frozen=True)
class Errors:
    """Cramér–Rao bounds of standard errors, with known noise."""

    numbers: dict[str, float]
    """Standard errors [SI], with σ_L fixed."""
    ratio: float
    """Error of Δσ/(dσ/dT) [K]."""
    correlation: dict[tuple[str, str], float]


@cache
def parameter_errors(data: Data, printed: Printed) -> Errors:
    """Return the bounds from the derivatives at Table 1."""
    uncertainty = of_columns(data, CHOSEN_ELSE, printed)
    table = table_numbers(printed)
    i, j = (CHOSEN_ELSE.index(name) for name in ("Delta_sigma", "dsigma_dT"))
    width, slope = table["Delta_sigma"], table["dsigma_dT"]
    rows, a, b = uncertainty.covariance, 1.0 / slope, -width / slope**2
    variance = a * a * rows[i][i] + 2.0 * a * b * rows[i][j] + b * b * rows[j][j]
    pairs = {
        (one, other): uncertainty.correlation[m][n]
        for m, one in enumerate(CHOSEN_ELSE)
        for n, other in enumerate(CHOSEN_ELSE)
        if m < n
    }
    numbers = dict(zip(CHOSEN_ELSE, uncertainty.errors, strict=True))
    bounds = {name: error / uncertainty.noise for name, error in numbers.items()}
    return Errors(bounds, math.sqrt(variance) / uncertainty.noise, pairs)


def of_columns(data: Data, names: tuple[str, ...], printed: Printed) -> Uncertainty:
    """Return the uncertainty of some parameters, all others fixed at Table 1."""
    evaluation, free = bench.at_table(data, printed), bench.table_problem(data, printed)
    places = [free.names.index(name) for name in names]
    return estimate_uncertainty(
        evaluation.residuals,
        evaluation.jacobian[:, places],
        names,
        values=[printed.searched.column("value")[i] for i in places],
        scales=[free.free[i].slope(float(free.start[i])) for i in places],
    )


def assess_records(data: Data, printed: Printed) -> Identifiability:
    """Return the information of a set of records on the five parameters, about Table 1."""
    evaluation, problem = bench.at_table(data, printed), bench.table_problem(data, printed)
    return assess_identifiability(
        evaluation.jacobian,
        printed.searched.column("name"),
        values=printed.searched.column("value"),
        scales=[f.slope(float(u)) for f, u in zip(problem.free, problem.start, strict=True)],
        units=[f.unit for f in problem.free],
    )


def cold_temperature(numbers: dict[str, float]) -> float:
    """Return T* = T_L - σ_L/(dσ/dT), where σ_A is 0 [K]."""
    return numbers["T_L"] - numbers["sigma_L"] / numbers["dsigma_dT"]


def temperature_width(numbers: dict[str, float]) -> float:
    """Return Δσ/(dσ/dT) [K]."""
    return numbers["Delta_sigma"] / numbers["dsigma_dT"]


def list_again(data: Data, printed: Printed) -> list[dict[str, Any]]:
    """Return true values, least-squares estimates and bounds of a synthetic set."""
    fit, bound = best_fit(data, printed).fit, parameter_errors(data, printed)
    table, bounds = table_numbers(printed), bound.numbers
    slope = table["dsigma_dT"], fit["dsigma_dT"], bounds["dsigma_dT"]
    ratio = temperature_width(table), temperature_width(fit.numbers), bound.ratio
    kelvin = cold_temperature(table), cold_temperature(fit.numbers), bounds["T_L"]
    rows = (
        ("slope", "dσ/dT", slope, 1e6, "MPa/K"),
        ("ratio", "Δσ/(dσ/dT)", ratio, 1.0, "K"),
        ("T", "T_L - σ_L/(dσ/dT)", kelvin, 1.0, "K"),
        ("E_M", "E_M", (table["E_M"], fit["E_M"], bounds["E_M"]), 1e9, "GPa"),
    )
    return [
        {
            "key": data.key,
            "data": data.name,
            "name": name,
            "symbol": symbol,
            "true": true / unit,
            "found": fitted / unit,
            "error": error / unit,
            "sure": SURE * error / unit,
            "unit": words,
        }
        for name, symbol, (true, fitted, error), unit, words in rows
    ]
