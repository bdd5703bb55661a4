"""R(ξ, T) identified from run 5: the wire at the temperature that the camera read.

One row per plateau of 1.3 to 4.5 V drives the wire by that temperature, without load; compared
is the resistance of the plateau,

    R_k = (V_k - V₀)/I_k

Free are the resistivities, A_s and A_f, and temperature coefficients as far as a shape of R has
them. A_s and A_f are apparent: temperatures as this camera reads them. Every fifth plateau is
held out. The law depends on no rate, so when a row was measured does not matter.

The offset V₀ of the supply is not a parameter of the wire. As V/I = R(p) + V₀/I it is fitted from
outside: its profile holds V₀ and fits everything else (`offset_profile`), and its uncertainty is
systematic, the same for all plateaus.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import Any

from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.physics.electrical.resistances import FurstSeeleckeResistance, MixtureResistance
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.search.free_numbers import SearchRange
from martensite.search.profile import Profile, walk_profile
from martensite.signals.records import Record, table_waveform
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.studies.electrothermal import model
from martensite.studies.electrothermal.model_numbers import KEPT
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.tables import printed_numbers

LOWER, UPPER = 0.18, 0.27
"""Offsets that the record has by itself, from 1.3 to 2.2 V and to 2.0 V [V]."""
HELD = 5
"""Every so many plateaus one is kept back, …"""
PLACE = 4
"""… the one at this place of each group."""
EDGE = (2.3, 2.4)
"""Set-points of the plateaus that hold the strip, and are never kept back [V]: on the first the
wire is transforming, on the second it is austenite."""
T_RHO = 340.0
"""Temperature at which the resistivities hold, at the drop: 67 °C [K]."""
NU = 0.33
"""Poisson's ratio of the maker's sheet; of effect where there is strain."""
SHAPES = {"mixture": (), "austenite": ("a_rho_A",), "both": ("a_rho_A", "a_rho_M")}
"""Shape of R(ξ, T) -> temperature coefficients that are free; the first has none at all."""
STRAINED = "strained"
"""The geometry of the strained wire beside the resistivities: ε_L free, ν given."""
OFFSETS = (0.0, 0.6)
"""Bounds of the offset of the supply [V]."""
_STRIP = (60.0, 80.0)
_MARGIN = 0.05
_UNSTRAINED, _STRETCHED = 1e-9, (0.02, 0.06)
_ROW = 1.0
_RESISTIVITY = (4e-7, 14e-7)
_COEFFICIENT = (-1e-3, 5e-3)


@cache
def load_staircase() -> RecordStaircase:
    """Return the record."""
    return RecordStaircase(printed_numbers("electrothermal"))


@cache
def compared_places() -> list[int]:
    """Return the indices of the plateaus that are compared."""
    return load_staircase().within(*KEPT)


def compared_column(name: str) -> list[float]:
    """Return a column of the plateaus that are compared."""
    return [load_staircase().table[name][i] for i in compared_places()]


def kept_back(place: int) -> tuple[tuple[float, float], ...]:
    """Return the stretches of time around the plateaus at one place of every group [s]."""
    stay, times = load_staircase().within(*EDGE), load_staircase().table["time"]
    held = [i for i in compared_places()[place::HELD] if i not in stay]
    return tuple((times[i] - _ROW, times[i] + _ROW) for i in held)


def build_experiment(shape: str, offset: float, place: int = PLACE) -> Experiment:
    """Return the wire at the apparent temperature, with its resistance beside it.

    Args:
        shape: one of `SHAPES`, or `STRAINED`.
        offset: V₀ [V].
        place: of the plateaus that are kept back, in their groups.
    """
    resistance = [load_staircase().resistances(offset)[i] for i in compared_places()]
    columns = {"time": compared_column("time"), "temperature": compared_column("apparent_temperature")}
    record = Record(
        "run 5", columns | {"resistance": resistance}, {"time": "s", "temperature": "K", "resistance": "ohm"}
    )
    return Experiment(
        "run 5",
        _build_system(shape, offset),
        table_waveform(record, "temperature"),
        record,
        {"resistance": "resistance"},
        held=kept_back(place),
    )


def _build_system(shape: str, offset: float) -> Any:
    """Return the wire of the scenario, without load, at a prescribed temperature.

    As it was neither trained nor loaded it keeps its length, except where strain is the question;
    there the strip is that of the plain mixture.
    """
    stated, base = printed_numbers("electrothermal"), model.load_scenario().single_system
    resistivities = {"rho_A": stated.rho_A, "rho_M": stated.rho_M}
    resistance: Any = MixtureResistance(**resistivities)
    if shape != "mixture":
        resistance = FurstSeeleckeResistance(**resistivities, a_rho_A=0.0, a_rho_M=0.0, T_rho=T_RHO, nu=NU)
    values = {"eps_L": _UNSTRAINED}
    if shape == STRAINED:
        values = {name: fit_shape("mixture", offset)[name] for name in ("A_s", "A_f")}
    element = base.element.with_parts(resistance=resistance)
    return base.with_parts(element=element, source=PrescribedTemperature()).with_values(values)


def list_search_ranges(shape: str) -> list[SearchRange]:
    """Return the free parameters; the strip must contain the plateau between the phases, or end on it."""
    at = load_staircase().table["apparent_temperature"][load_staircase().within(*EDGE)[0]]
    found = [SearchRange("rho_A", *_RESISTIVITY), SearchRange("rho_M", *_RESISTIVITY)]
    if shape == STRAINED:
        return [*found, SearchRange("eps_L", *_STRETCHED)]
    low, high = (celsius + model.ZERO for celsius in _STRIP)
    found += [SearchRange("A_s", low, at - _MARGIN), SearchRange("A_f", at + _MARGIN, high)]
    return found + [SearchRange(name, *_COEFFICIENT) for name in SHAPES[shape]]


@cache
def fit_shape(shape: str, offset: float, place: int = PLACE) -> Fit:
    """Return the fit of one shape of R with one offset of the supply."""
    return solve_problem(build_problem([build_experiment(shape, offset, place)], list_search_ranges(shape)))


def fitted_resistances(fit: Fit, temperatures: Sequence[float]) -> list[float]:
    """Return the resistance of a fitted wire that is heated through temperatures [ohm]."""
    times = tuple(_ROW * k for k in range(len(temperatures)))
    waveform = Table(times=times, values=tuple(temperatures))
    run = simulate(fit.system(), waveform, times[-1], step=_ROW, samples=len(times))
    return list(run["resistance"])


# ---------------------------------------------------------------- how well


def residual_rms(fit: Fit, part: str = "training") -> float:
    """Return the RMS of the residuals on the plateaus of one part, in the unit of the compared output."""
    return next(score.rms for score in fit.scores if score.part == part)


def sum_squares(fit: Fit) -> float:
    """Return the sum of the squared residuals, in the unit of what is compared."""
    return residual_rms(fit) ** 2 * fit.uncertainty.samples


def akaike_criterion(fit: Fit) -> float:
    """Akaike's criterion for few samples, AICc = n ln(S/n) + 2 k n/(n - k - 1) (lower is better).

    Of k, one is the variance, and directions that the data do not determine do not count.
    Source: Hurvich and Tsai (1989), Biometrika 76.
    """
    n, k = fit.uncertainty.samples, fit.uncertainty.rank + 1
    return n * math.log(sum_squares(fit) / n) + 2.0 * k * n / (n - k - 1)


def predicted_rms(shape: str, offset: float) -> float:
    """RMS of what is predicted for all plateaus but those of `EDGE`, each kept back once [ohm]."""
    fits = [fit_shape(shape, offset, place) for place in range(HELD)]
    kept = [len(compared_places()) - fit.uncertainty.samples for fit in fits]
    total = sum(residual_rms(fit, "held-out") ** 2 * n for fit, n in zip(fits, kept, strict=True))
    return math.sqrt(total / sum(kept))


def count_transforming(fit: Fit) -> int:
    """Return the number of plateaus on which the fitted wire is transforming: 0.02 < ξ < 0.98."""
    strip, at = fit["A_f"] - fit["A_s"], compared_column("apparent_temperature")
    shares = [min(max((kelvin - fit["A_s"]) / strip, 0.0), 1.0) for kelvin in at]
    return sum(0.02 < 0.5 * (1.0 + math.cos(math.pi * share)) < 0.98 for share in shares)


def stretch_share(strain: float) -> float:
    """Return the share by which R rises from the shape of the stretched wire alone."""
    return (1.0 + strain) / (1.0 - NU * strain) ** 2 - 1.0


def resistivity_difference(fit: Fit) -> tuple[float, float]:
    """ρ_M - ρ_A and half of its widened 95 % interval [ohm m]."""
    unsure, half = fit.uncertainty, {}
    for name in ("rho_A", "rho_M"):
        low, high = unsure.widened(name)
        half[name] = 0.5 * (high - low)
    one, other = (unsure.names.index(name) for name in half)
    shared = 2.0 * unsure.correlation[one][other] * half["rho_A"] * half["rho_M"]
    spread = half["rho_A"] ** 2 + half["rho_M"] ** 2 - shared
    return fit["rho_M"] - fit["rho_A"], math.sqrt(spread)


# ---------------------------------------------------------------- the offset of the supply


def offset_profile(fit_at: Callable[[float], Fit]) -> Profile:
    """Return the profile of the offset V₀ [V]: everything else is fitted at each of its values."""

    def cost(offset: float) -> float:
        return sum_squares(fit_at(offset))

    found = import_module("scipy.optimize").minimize_scalar(
        cost, bounds=OFFSETS, method="bounded", options={"xatol": 1e-4}
    )
    best = float(found.x)
    unsure = fit_at(best).uncertainty
    spare = int(unsure.effective) - unsure.rank - 1
    return walk_profile(
        lambda held, start: ((held[0],), cost(held[0])),
        (best,),
        cost(best),
        0,
        low=OFFSETS[0],
        high=OFFSETS[1],
        freedom=spare,
        step=0.02,
        name="V_0",
        unit="V",
    )


@cache
def offset_of(shape: str) -> Profile:
    """Return the profile of V₀ with one shape of R."""
    return offset_profile(lambda offset: fit_shape(shape, offset))
