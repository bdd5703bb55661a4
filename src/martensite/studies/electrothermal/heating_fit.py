"""The electrical fit: R and an apparent h from run 5 driven by voltage.

The set-point less V₀ drives the wire, and the current is compared. Free are the resistivities and one constant film
coefficient h; A_s and A_f are given, since the balance

    I² R = h π d l (T - T_a)

determines h only by the transformation of the wire. The same balance is also solved on each plateau with the camera
temperature. Both h are apparent.
"""

from __future__ import annotations

import math
from functools import cache

from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.physics.thermal.films import ConstantCooling
from martensite.search.free_numbers import SearchRange
from martensite.search.profile import Profile
from martensite.signals.records import Record
from martensite.signals.staircase import Staircase
from martensite.studies.electrothermal import model
from martensite.studies.electrothermal.resistance_fit import (
    PLACE,
    compared_column,
    compared_places,
    fit_shape,
    list_held_out,
    load_staircase,
    offset_profile,
)

FILMS = (150.0, 450.0)
"""Range of film coefficients for the start of the search [W/(m² K)]."""
_COUNT = 61
_FILM = (20.0, 1000.0)
_STEP = 2.0


def build_experiment(offset: float) -> Experiment:
    """Return the wire driven by voltage, with its measured current."""
    base = model.load_scenario().single_system
    environment = base.environment.with_parts(cooling=ConstantCooling(h=FILMS[0]))
    fit = fit_shape("mixture", offset)
    values = {name: fit[name] for name in ("rho_A", "rho_M")}
    record = Record(
        "run 5", {"time": compared_column("time"), "current": compared_column("current")}, {"time": "s", "current": "A"}
    )
    volts = load_staircase().table["set_point"].tolist()
    waveform = Staircase(first=volts[0] - offset, increment=volts[1] - volts[0], hold=32.0, count=len(volts))
    return Experiment(
        "run 5",
        base.with_parts(environment=environment).with_values(values),
        waveform,
        record,
        {"current": "current"},
        step=_STEP,
        held_out_intervals=list_held_out(PLACE),
    )


@cache
def fit_heating(offset: float) -> Fit:
    """Return the fit for one supply offset.

    The error changes with h only while plateaus are in the transformation, and so has several minima: the search starts
    at the best of evenly spaced h, with the resistivities of the other fit.
    """
    one = build_experiment(offset)
    first = build_problem([one], ["rho_A", "rho_M", SearchRange("h", *_FILM)])
    shares = [k / (_COUNT - 1) for k in range(_COUNT)]
    films = [FILMS[0] + share * (FILMS[1] - FILMS[0]) for share in shares]
    points = [[*first.start[:2], first.free[2].share(h)] for h in films]
    costs = first.costs(points)
    best = films[min(range(_COUNT), key=lambda k: float(costs[k]))]
    return solve_problem(build_problem([one], ["rho_A", "rho_M", SearchRange("h", *_FILM, start=best)]))


@cache
def offset_found() -> Profile:
    """Return the profile of V₀ in the electrical fit."""
    return offset_profile(fit_heating)


def apparent_films(offset: float) -> list[float]:
    """Return h of the balance with the camera temperature, by plateau [W/(m² K)]."""
    element = model.get_wire()
    surface = math.pi * float(element.diameter) * float(element.length)
    ambient, resistance = (model.read_number("environment.temperature"), load_staircase().resistances(offset))
    table = load_staircase().table
    current, kelvin = table["current"].tolist(), table["apparent_temperature"].tolist()
    return [current[i] ** 2 * resistance[i] / (surface * (kelvin[i] - ambient)) for i in compared_places()]
