"""A bank of models: its probabilities against a computation by hand, and what it says of a wire that changes.

Source of truth: the interacting multiple model filter of Bar-Shalom, Li and Kirubarajan (2001), section 11.6, written
here once more with SciPy for two scalar linear models: a wire in martensite, far below its transformation, is
linear in its temperature under a given power, and so is its resistance.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a, wire_a
from scipy.linalg import expm
from scipy.stats import norm
from sensing_cases import RESISTANCE, SINE, rms, run, sensing_bench, sensing_plant

from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import ParameterError
from martensite.control.faults.mechanism import Clamped, Slack
from martensite.control.faults.plant import Draught
from martensite.control.loop.parts import FaultTable, Observers
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.observers.model_bank import ModelBank, Models
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.thermal.films import ConstantCooling

DT, TURNS, AMBIENT = 0.1, 2, 293.15
SIGMA, WALK, FIRST, SOUND, FAULT = 1e-3, 0.2, 1.0, 8.0, 4.0
POWER = 1.0
FILMS = (80.0, 240.0)
SHOWN = ("probability_as_modelled", "probability_windy", "temperature", "temperature_std")


def linear_wire(film: float) -> Any:
    """A wire that only warms up, by a given power."""
    return problem_a(
        element=wire_a().with_parts(resistance=RESISTANCE), source=PowerSource(), mechanism=DeadWeight(mass=0.5)
    ).with_parts(environment=problem_a().environment.with_parts(temperature=AMBIENT, cooling=ConstantCooling(h=film)))


def by_hand(readings: list[float]) -> np.ndarray:
    """Probabilities, mean and standard deviation of the temperature, in every sample."""
    wire = linear_wire(FILMS[0]).element
    capacity, surface = wire.heat_capacity_total(), math.pi * wire.diameter * wire.length
    expansion = -wire.law.Theta / wire.law.E_M
    cold, warm = (wire.ohms(floats, 1.0, strain() + k * expansion, AMBIENT + k) for k in (0.0, 10.0))
    slope, base = 0.1 * (warm - cold), cold - 0.1 * (warm - cold) * AMBIENT
    into = [math.exp(-DT / SOUND), math.exp(-DT / FAULT)]
    switch = np.array([[into[0], 1.0 - into[0]], [1.0 - into[1], into[1]]])
    weights = np.array([1.0 - FAULT / (SOUND + FAULT), FAULT / (SOUND + FAULT)])
    mean, variance, rows = np.full(2, AMBIENT), np.full(2, FIRST**2), []
    for reading in readings:
        ahead = weights @ switch
        share = switch * weights[:, None] / ahead
        begun = mean @ share
        spread = (variance @ share) + np.sum(share * (mean[:, None] - begun[None, :]) ** 2, axis=0)
        logs = np.empty(2)
        for j, film in enumerate(FILMS):
            rate = film * surface / capacity
            flow = expm(DT * np.array([[-rate, POWER / capacity + rate * AMBIENT], [0.0, 0.0]]))
            mean[j] = flow[0] @ [begun[j], 1.0]
            variance[j] = flow[0, 0] ** 2 * spread[j] + WALK**2 * DT
            total = slope**2 * variance[j] + SIGMA**2
            logs[j] = norm.logpdf(reading, base + slope * mean[j], math.sqrt(total))
            gain = slope * variance[j] / total
            mean[j] += gain * (reading - base - slope * mean[j])
            variance[j] *= 1.0 - gain * slope
        weights = ahead * np.exp(logs - logs.max())
        weights /= weights.sum()
        middle = weights @ mean
        rows.append([*weights, middle, math.sqrt(weights @ (variance + (mean - middle) ** 2))])
    return np.array(rows)


@cache
def strain() -> float:
    wire = linear_wire(FILMS[0])
    seen = dict(zip(wire.outputs(), wire.observe(floats, wire.init(floats, 0.0), 0.0), strict=True))
    assert seen["martensite_fraction"] == 1.0
    return seen["strain"]


def test_probabilities_and_mixture_are_those_by_hand() -> None:
    still, windy = (linear_wire(film) for film in FILMS)
    walks = {"temperature_noise": WALK, "fraction_noise": 0.0, "first_temperature": FIRST, "first_fraction": 0.0}
    noise = {"reading_noise": 0.0, "reading_deviation": SIGMA, "sound": SOUND, "fault": FAULT}
    bank = ModelBank(model=still, models=Models(windy=windy), **walks, **noise)
    rng, drives, state = np.random.default_rng(5), {"drive": POWER}, still.init(floats, 0.0)
    readings, found = [], []
    _, memory = bank.rest(floats, {"resistance": 0.0, "resistance.age": 0.0}, {"drive": 0.0})
    for k in range(24):
        plant = windy if 8 <= k < 16 else still
        for _ in range(TURNS):
            state, _ = plant.step(floats, state, POWER, dt=DT / TURNS)
        seen = dict(zip(plant.outputs(), plant.observe(floats, state, POWER), strict=True))
        readings.append(seen["resistance"] + SIGMA * rng.standard_normal())
        told = {"resistance": readings[-1], "resistance.age": 0.0}
        guess, memory = bank.update(floats, memory, told, drives, DT, TURNS)
        row = dict(zip(bank.estimates(), guess, strict=True))
        found.append([row[name] for name in SHOWN])
    expected = by_hand(readings)
    assert expected[7, 0] > 0.8 and expected[15, 1] > 0.9 and expected[23, 0] > 0.8, expected
    off = np.abs(np.array(found) - expected).max(axis=0)
    assert (off < [2e-4, 2e-4, 2e-3, 1e-3]).all(), off


def test_models_that_do_not_fit_are_refused() -> None:
    plant = sensing_plant()
    with pytest.raises(ParameterError, match=r"Model `warm` of a bank is driven by drive .W., not by drive .1.\."):
        ModelBank(model=plant, wanted=("position",), models=Models(warm=sensing_plant(source=PowerSource())))
    with pytest.raises(ParameterError, match=r"`usual` knows no model `fun`\. Did you mean `fan`"):
        ModelBank(model=plant, usual=("fun",))
    with pytest.raises(ParameterError, match="`controlled` is `angle`, which is not estimated"):
        ModelBank(model=plant, usual=("fan",), controlled="angle")


def test_what_drifts_is_found_behind_what_a_model_wraps() -> None:
    bank = ModelBank(model=sensing_plant(), drifting=("environment.cooling.h0", "rho_A"))
    assert {"environment.cooling.h0", "element.resistance.rho_A"} <= set(bank.estimates())


LATE = 1e6


@cache
def loop() -> Any:
    """A sensorless loop with three models, and faults that do not begin."""
    faults = FaultTable(
        fan=Draught(factor=2.5, start=LATE), slack=Slack(length=5e-3, start=LATE), clamped=Clamped(start=LATE)
    )
    bank = ModelBank(model=sensing_plant(), usual=("fan", "clamped"))
    return sensing_bench(sensing_plant(), bank, SINE, faults=faults)


def watch(seed: int, seconds: float = 32.0, **starts: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    found = run(loop().with_values({f"faults.{n}.start": t for n, t in starts.items()}), seconds, seed=seed)
    return found["times"], found


def test_trust_stays_while_the_wire_is_as_modelled(c_compiler: str) -> None:
    for seed in (701, 702):
        _, found = watch(seed, 60.0)
        assert found["estimated.confidence"].min() > 0.95
        assert set(found["estimated.most_probable"]) == {0.0}


@pytest.mark.parametrize(("fault", "index"), [("fan", 1.0), ("clamped", 2.0), ("slack", None)])
def test_trust_falls_within_two_seconds(c_compiler: str, fault: str, index: float | None) -> None:
    for seed in (701, 702):
        times, found = watch(seed, **{fault: 24.0})
        assert found["estimated.confidence"][times < 24.0].min() > 0.95
        assert found["estimated.confidence"][(times >= 24.0) & (times <= 26.0)].min() < 0.5
        if index is not None:
            assert np.mean(found["estimated.most_probable"][times > 27.0] == index) > 0.9


def test_a_single_filter_is_lost_where_a_bank_knows_better(c_compiler: str) -> None:
    """A fan from the beginning, of which the bank has a model."""
    alone = loop().with_parts(observers=Observers(wire=ExtendedKalman(model=sensing_plant())))
    errors = []
    for bench in (alone, loop()):
        found = run(bench.with_values({"faults.fan.start": 0.0}), 40.0, seed=703)
        late = found["times"] > 20.0
        errors.append(rms((found["position"] - found["estimated.position"])[late]))
    assert errors[1] < 0.1 * errors[0], errors
