"""Claims on the data: what one calibration test determines, and what more records add."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from martensite.identify.fitting.identifiability import Identifiability, identifiability
from martensite.identify.fitting.uncertainty import Uncertainty, uncertainty
from martensite.studies.base import Claim
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import EVERY, JOINT, NEAR, Data
from martensite.studies.finger_calibration.printed import METHOD, TABLE, Printed
from martensite.studies.finger_calibration.searches import best

SURE = 2.0
"""Standard errors within which a number counts as found again."""
CHOSEN_ELSE = ("E_M", "T_L", "Delta_sigma", "dsigma_dT")
"""The parameters that are left with σ_L fixed."""


def claims(printed: Printed) -> list[Claim]:
    """How many numbers the test holds, whether they are found again, and how well."""
    return [
        *_count(printed), *(c for data in EVERY for c in again(data, printed)), *_joint(printed)
    ]  # fmt: skip


@dataclass(frozen=True)
class Errors:
    """Smallest standard errors that an unbiased fit can have (Cramér and Rao), noise known."""

    numbers: dict[str, float]
    """[SI]; σ_L fixed."""
    ratio: float
    """Of Δσ/(dσ/dT) [K]."""
    correlation: dict[tuple[str, str], float]


@cache
def errors(data: Data, printed: Printed) -> Errors:
    """From the derivatives with Table 1."""
    found = of_columns(data, CHOSEN_ELSE, printed)
    table = dict(zip(printed.names, printed.table, strict=True))
    i, j = (CHOSEN_ELSE.index(name) for name in ("Delta_sigma", "dsigma_dT"))
    width, slope = table["Delta_sigma"], table["dsigma_dT"]
    rows, a, b = found.covariance, 1.0 / slope, -width / slope**2
    variance = a * a * rows[i][i] + 2.0 * a * b * rows[i][j] + b * b * rows[j][j]
    pairs = {
        (one, other): found.correlation[m][n]
        for m, one in enumerate(CHOSEN_ELSE) for n, other in enumerate(CHOSEN_ELSE) if m < n
    }  # fmt: skip
    numbers = dict(zip(CHOSEN_ELSE, found.errors, strict=True))
    known = {name: error / found.noise for name, error in numbers.items()}
    return Errors(known, math.sqrt(variance) / found.noise, pairs)


def of_columns(data: Data, names: tuple[str, ...], printed: Printed) -> Uncertainty:
    """What is uncertain about some of the parameters, all others fixed at Table 1."""
    found, free = bench.at_table(data, printed), bench.table_problem(data, printed)
    places = [free.names.index(name) for name in names]
    return uncertainty(
        found.residuals, found.jacobian[:, places], names,
        values=[printed.table[i] for i in places],
        scales=[free.free[i].slope(float(free.start[i])) for i in places],
    )  # fmt: skip


def held(data: Data, printed: Printed) -> Identifiability:
    """What a set of records holds of the five parameters, about Table 1."""
    found, problem = bench.at_table(data, printed), bench.table_problem(data, printed)
    return identifiability(
        found.jacobian, printed.names, values=printed.table,
        scales=[f.slope(float(u)) for f, u in zip(problem.free, problem.start, strict=True)],
        units=[f.unit for f in problem.free],
    )  # fmt: skip


def cold(numbers: dict[str, float]) -> float:
    """T* = T_L - σ_L/(dσ/dT), where σ_A is 0 [K]."""
    return numbers["T_L"] - numbers["sigma_L"] / numbers["dsigma_dT"]


def width(numbers: dict[str, float]) -> float:
    """Δσ/(dσ/dT) [K]."""
    return numbers["Delta_sigma"] / numbers["dsigma_dT"]


def _count(printed: Printed) -> list[Claim]:
    found = held(NEAR, printed)
    lost = [one.sentence for one in found.weak]
    count = len(printed.names)
    return [
        Claim.checked(
            "count", f"how many of the {count} searched parameters the calibration test determines",
            METHOD, float(count), float(count - sum(one.exact for one in found.weak)), "1", 0.0,
            " ".join(lost) + " Nothing but T_L - σ_L/(dσ/dT) enters the law",
        )
    ]  # fmt: skip


def again(data: Data, printed: Printed) -> list[Claim]:
    """Whether least squares find Table 1 again in records that were made with it."""
    fit, bound = best(data, printed).fit, errors(data, printed)
    table = dict(zip(printed.names, printed.table, strict=True))
    rows = (
        ("slope", "dσ/dT", table["dsigma_dT"], fit["dsigma_dT"], bound.numbers["dsigma_dT"],
         1e6, "MPa/K"),
        ("ratio", "Δσ/(dσ/dT)", width(table), width(fit.numbers), bound.ratio, 1.0, "K"),
        ("T", "T_L - σ_L/(dσ/dT)", cold(table), cold(fit.numbers), bound.numbers["T_L"],
         1.0, "K"),
        ("E_M", "E_M", table["E_M"], fit["E_M"], bound.numbers["E_M"], 1e9, "GPa"),
    )  # fmt: skip
    return [
        Claim.checked(
            f"{id}-{data.key}", f"{symbol} found again by least squares, {data.name}", TABLE,
            true / unit, value / unit, name, SURE * error / unit,
            f"standard error {error / unit:.3g} {name}; the record was made with Table 1, so that "
            "this speaks for the search and for the test, not for the table",
        )
        for id, symbol, true, value, error, unit, name in rows
    ]  # fmt: skip


def _joint(printed: Printed) -> list[Claim]:
    near, joint = (errors(data, printed) for data in (NEAR, JOINT))
    pair = ("Delta_sigma", "dsigma_dT")
    return [
        Claim.reported(
            "joint-slope", "error of dσ/dT from one calibration test over that from three r",
            METHOD, near.numbers["dsigma_dT"] / joint.numbers["dsigma_dT"], "1",
            f"{near.numbers['dsigma_dT'] / 1e6:.3f} and {joint.numbers['dsigma_dT'] / 1e6:.4f} "
            "MPa/K, the latter at a = 16 mm; tests at three r were made, one was used",
        ),
        Claim.reported(
            "correlation", "correlation of Δσ and dσ/dT, a = 8 mm", METHOD,
            near.correlation[pair], "1",
            f"their ratio is known to {near.ratio:.3f} K; of three r, "
            f"{joint.correlation[pair]:.3f} and {joint.ratio:.3f} K",
        ),
    ]  # fmt: skip
