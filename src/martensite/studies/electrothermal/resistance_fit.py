"""R(ξ, T) identified from run 5: the wire at the camera temperature.

One row per plateau of 1.3 to 4.5 V drives the unloaded wire by that temperature; the resistance of the plateau is
compared,

    R_k = (V_k - V₀)/I_k

Free are the resistivities, A_s and A_f, and the temperature coefficients of a shape of R. A_s and A_f are apparent:
temperatures as read by this camera. Each fifth plateau is held out. The law is rate-independent, so the times of the
rows do not matter.

The supply offset V₀ is not a parameter of the wire. As V/I = R(p) + V₀/I, its profile is computed outside the fit
(`offset_profile`). Its uncertainty is systematic, the same for all plateaus.
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
from martensite.studies.readings import ZERO
from martensite.studies.tables import printed_numbers

LOWER, UPPER = 0.18, 0.27
"""Offsets of the record, from 1.3 to 2.2 V and to 2.0 V [V]."""
HELD = 5
"""Size of a group of plateaus with one held out."""
PLACE = 4
"""Position of the held-out plateau in its group."""
EDGE = (2.3, 2.4)
"""Set-points of the plateaus around the transformation, which are never held out [V]."""
T_RHO = 340.0
"""Reference temperature of the resistivities, at the drop: 67 °C [K]."""
NU = 0.33
"""Poisson's ratio of the maker's sheet."""
SHAPES = {"mixture": (), "austenite": ("a_rho_A",), "both": ("a_rho_A", "a_rho_M")}
"""Free temperature coefficients by shape of R(ξ, T)."""
STRAINED = "strained"
"""Shape with the geometry of the strained wire: ε_L free, ν given."""
OFFSETS = (0.0, 0.6)
"""Bounds of the supply offset [V]."""
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
    """Return the indices of the compared plateaus."""
    return load_staircase().within(*KEPT)


def compared_column(name: str) -> list[float]:
    """Return a column of the compared plateaus."""
    return load_staircase().table[name][compared_places()].tolist()


def list_held_out(place: int) -> tuple[tuple[float, float], ...]:
    """Return the time intervals of the held-out plateaus at a position in the groups [s]."""
    stay, times = load_staircase().within(*EDGE), load_staircase().table["time"].tolist()
    held_out = [i for i in compared_places()[place::HELD] if i not in stay]
    return tuple((times[i] - _ROW, times[i] + _ROW) for i in held_out)


def build_experiment(shape: str, offset: float, place: int = PLACE) -> Experiment:
    """Return the wire at the apparent temperature, with its measured resistance.

    Args:
        shape: one of `SHAPES`, or `STRAINED`.
        offset: V₀ [V].
        place: position of held-out plateaus in their groups.
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
        held_out_intervals=list_held_out(place),
    )


def _build_system(shape: str, offset: float) -> Any:
    """Return the unloaded wire of the scenario at a prescribed temperature.

    It was neither trained nor loaded and keeps its length, except for `STRAINED`, whose transformation is that of the
    plain mixture.
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
    """Return the free parameters; the transformation must contain the plateau between the phases."""
    at = load_staircase().table["apparent_temperature"][load_staircase().within(*EDGE)[0]].item()
    ranges = [SearchRange("rho_A", *_RESISTIVITY), SearchRange("rho_M", *_RESISTIVITY)]
    if shape == STRAINED:
        return [*ranges, SearchRange("eps_L", *_STRETCHED)]
    low, high = (celsius + ZERO for celsius in _STRIP)
    ranges += [SearchRange("A_s", low, at - _MARGIN), SearchRange("A_f", at + _MARGIN, high)]
    return ranges + [SearchRange(name, *_COEFFICIENT) for name in SHAPES[shape]]


@cache
def fit_shape(shape: str, offset: float, place: int = PLACE) -> Fit:
    """Return the fit of one shape of R for one supply offset."""
    return solve_problem(build_problem([build_experiment(shape, offset, place)], list_search_ranges(shape)))


def fitted_resistances(fit: Fit, temperatures: Sequence[float]) -> list[float]:
    """Return the resistance of a fitted wire heated through temperatures [ohm]."""
    times = tuple(_ROW * k for k in range(len(temperatures)))
    waveform = Table(times=times, values=tuple(temperatures))
    run = simulate(fit.system(), waveform, times[-1], step=_ROW, samples=len(times))
    return list(run["resistance"])


def residual_rms(fit: Fit, part: str = "training") -> float:
    """Return the RMS residual of the plateaus of one part, in the unit of the compared output."""
    return next(score.rms for score in fit.scores if score.part == part)


def sum_squares(fit: Fit) -> float:
    """Return the sum of squared residuals, in the squared unit of the compared output."""
    return residual_rms(fit) ** 2 * fit.uncertainty.samples


def akaike_criterion(fit: Fit) -> float:
    """Return Akaike's criterion for few samples, AICc = n ln(S/n) + 2 k n/(n - k - 1) (lower is better).

    k counts the variance and the determined directions. Source: Hurvich and Tsai (1989), Biometrika 76.
    """
    n, k = fit.uncertainty.samples, fit.uncertainty.rank + 1
    return n * math.log(sum_squares(fit) / n) + 2.0 * k * n / (n - k - 1)


def predicted_rms(shape: str, offset: float) -> float:
    """Return the cross-validated RMS error of all plateaus outside `EDGE` [ohm]."""
    fits = [fit_shape(shape, offset, place) for place in range(HELD)]
    counts = [len(compared_places()) - fit.uncertainty.samples for fit in fits]
    total = sum(residual_rms(fit, "held-out") ** 2 * n for fit, n in zip(fits, counts, strict=True))
    return math.sqrt(total / sum(counts))


def count_transforming(fit: Fit) -> int:
    """Return the number of plateaus on which the fitted wire is transforming: 0.02 < ξ < 0.98."""
    strip, at = fit["A_f"] - fit["A_s"], compared_column("apparent_temperature")
    shares = [min(max((kelvin - fit["A_s"]) / strip, 0.0), 1.0) for kelvin in at]
    return sum(0.02 < 0.5 * (1.0 + math.cos(math.pi * share)) < 0.98 for share in shares)


def stretch_share(strain: float) -> float:
    """Return the relative rise of R from the geometry of the stretched wire."""
    return (1.0 + strain) / (1.0 - NU * strain) ** 2 - 1.0


def resistivity_difference(fit: Fit) -> tuple[float, float]:
    """Return ρ_M - ρ_A and half of its widened 95 % interval [ohm m]."""
    unsure, half = fit.uncertainty, {}
    for name in ("rho_A", "rho_M"):
        low, high = unsure.widen_interval(name)
        half[name] = 0.5 * (high - low)
    one, other = (unsure.names.index(name) for name in half)
    shared = 2.0 * unsure.correlation[one][other] * half["rho_A"] * half["rho_M"]
    spread = half["rho_A"] ** 2 + half["rho_M"] ** 2 - shared
    return fit["rho_M"] - fit["rho_A"], math.sqrt(spread)


def offset_profile(fit_at: Callable[[float], Fit]) -> Profile:
    """Return the profile of the offset V₀ [V]; all else is fitted at each value."""

    def cost(offset: float) -> float:
        return sum_squares(fit_at(offset))

    minimum = import_module("scipy.optimize").minimize_scalar(
        cost, bounds=OFFSETS, method="bounded", options={"xatol": 1e-4}
    )
    best = float(minimum.x)
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
