"""Observers: what corrects a memory, the algebra of the filters, their slopes, and names.

Sources of truth: textbook formulas in NumPy, finite differences, the plant itself.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from builders import REGISTRIES, example, label, law_a, registered, variants, wire_a
from sensing_cases import PERIOD, run, sensing_bench, sensing_plant, shaken

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.base.errors import InputError, ParameterError
from martensite.control.loop.consistency import check_consistency
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, ObserverPeriod
from martensite.control.observers.covariance import UnknownReading
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.observers.filter import FilterMemory
from martensite.control.observers.inverse import InverseModel
from martensite.control.observers.unscented import UnscentedKalman
from martensite.kernels import floats
from martensite.kernels.nested import flatten_numbers
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.laws.base import Fractions
from martensite.signals.sine import Sine

FILTERS = [ExtendedKalman, UnscentedKalman]
PLANT = sensing_plant()
HEATING = Sine(low=0.05, high=0.35, frequency=0.2)


# ---------------------------------------------------------------- a memory put elsewhere


def histories(law: Any) -> list[Any]:
    """Memories on the way through heating, cooling and loading."""
    memory = law.init(floats, Fractions(1.0, 1.0), 60e6, 300.0)
    found = [memory]
    for stress, kelvin in ((70e6, 352.0), (90e6, 356.0), (80e6, 340.0), (70e6, 331.0)):
        memory, _ = law.kinetics(floats, memory, stress, kelvin, 0.5)
        found.append(memory)
    return found


@pytest.mark.parametrize("law", [variants(cls)[0] for cls in registered("law")], ids=label)
class TestMoved:
    def test_the_same_point_changes_nothing(self, law: Any) -> None:
        for memory in histories(law):
            at = law.fractions(memory), memory.stress, memory.temperature
            again = law.relocate(floats, memory, *at)
            assert flatten_numbers(again) == pytest.approx(flatten_numbers(memory), rel=1e-12, abs=1e-12)

    def test_it_is_where_it_was_put_and_goes_on_from_there(self, law: Any) -> None:
        shares, kelvins = (0.0, 0.3, 1.0), (-3.0, 4.0)
        for memory, x, more in itertools.product(histories(law), shares, kelvins):
            there = Fractions(x, x)
            put = law.relocate(floats, memory, there, 75e6, memory.temperature + more)
            assert law.fractions(put)[:2] == pytest.approx(there, abs=1e-12)
            assert (put.stress, put.temperature) == (75e6, memory.temperature + more)
            after, found = law.kinetics(floats, put, 80e6, put.temperature + 1.0, 0.1)
            assert np.isfinite(flatten_numbers(after)).all()
            assert -1e-12 <= found.martensite <= 1.0 + 1e-12
            assert abs(found.oriented) <= found.martensite + 1e-12


def heated(law: Any, memory: Any, kelvin: float) -> float:
    return law.kinetics(floats, memory, 60e6, memory.temperature + kelvin, 0.1)[1].martensite


def test_a_transformation_in_progress_goes_on_from_where_it_was_put() -> None:
    law = law_a()
    memory = law.init(floats, Fractions(1.0, 1.0), 60e6, 340.0)
    memory, _ = law.kinetics(floats, memory, 60e6, 351.0, 0.1)
    put = law.relocate(floats, memory, Fractions(0.5, 0.5), 60e6, 352.0)
    strip = law.strips()[1]
    left = [law.remaining_fraction(floats, strip.distance(60e6, t)) for t in (352.0, 352.5)]
    assert heated(law, put, 0.5) == pytest.approx(0.5 * left[1] / left[0], rel=1e-9)


def test_one_that_waited_waits_as_far() -> None:
    law = law_a()
    memory = law.init(floats, Fractions(1.0, 1.0), 60e6, 340.0)
    for kelvin in (351.0, 349.5):
        memory, _ = law.kinetics(floats, memory, 60e6, kelvin, 0.1)
    put = law.relocate(floats, memory, Fractions(0.5, 0.5), 60e6, 350.0)
    assert heated(law, put, 1.2) == 0.5
    assert heated(law, put, 2.5) < 0.5


# ---------------------------------------------------------------- covariances


def some_matrix(size: int) -> np.ndarray:
    root = np.random.default_rng(size).normal(size=(size, size))
    return root @ root.T


def test_readings_one_by_one_are_the_textbook_update() -> None:
    c, mean = some_matrix(4), np.array([1.0, -2.0, 0.5, 3.0])
    h, r, z = np.eye(4)[[1, 3]], np.diag([0.3, 0.7]), np.array([-1.0, 2.0])
    s = h @ c @ h.T + r
    gain, short = c @ h.T @ np.linalg.inv(s), z - h @ mean
    rows = [UnknownReading(1, -1.0, 0.3, 1.0), UnknownReading(3, 2.0, 0.7, 1.0)]
    found, matrix, nis = covariance.condition_on_readings(floats, mean.tolist(), c.tolist(), rows)
    assert found == pytest.approx(mean + gain @ short, rel=1e-12)
    assert np.allclose(matrix, c - gain @ s @ gain.T, rtol=1e-12)
    assert nis == pytest.approx(short @ np.linalg.solve(s, short), rel=1e-12)


def test_a_reading_that_does_not_count_changes_nothing() -> None:
    c, mean = some_matrix(3).tolist(), [1.0, 2.0, 3.0]
    found = covariance.condition_on_readings(floats, mean, c, [UnknownReading(0, 9.0, 0.1, 0.0)])
    assert found == (mean, c, 0.0)


def test_factor_packing_and_spread() -> None:
    c, rows = some_matrix(3), np.random.default_rng(1).normal(size=(2, 3))
    assert np.allclose(covariance.factor_cholesky(floats, c.tolist()), np.linalg.cholesky(c))
    assert covariance.unpack_matrix(covariance.pack_matrix(c.tolist())) == c.tolist()
    assert np.allclose(covariance.propagate_covariance(rows.tolist(), c.tolist()), rows @ c @ rows.T)
    nothing = covariance.factor_cholesky(floats, [[0.0, 0.0], [0.0, 4.0]])
    assert nothing == [[0.0, 0.0], [0.0, 2.0]]


def test_what_is_put_takes_the_others_along() -> None:
    assert covariance.put_unknown(floats, [0.0, 1.0], [[1.0, 0.5], [0.5, 2.0]], 1, 3.0) == [0.5, 3.0]


# ---------------------------------------------------------------- forecasts


def amid(plant: Any) -> Any:
    """A state of a plant amid its reverse transformation."""
    state = plant.init(floats, 0.3)
    for _ in range(95):
        state, _ = plant.step(floats, state, 0.3, dt=0.02)
    return state


GOING = ObserverPeriod([0.3], PERIOD, 3)
SIZES = (2.0, 0.03)


def forecast(observer: Any, scale: float) -> Any:
    """From amid the transformation, with standard deviations of that scale."""
    matrix = covariance.build_diagonal([(scale * s) ** 2 for s in SIZES])
    return observer.forecast(floats, FilterMemory(amid(PLANT), (), matrix), GOING)


def ended(at: list[float]) -> np.ndarray:
    """Everything at the end of the period, from hidden values at its start."""
    state = hidden_states.place_hidden(floats, PLANT, amid(PLANT), at, GOING.signals)
    for _ in range(GOING.turns):
        state, _ = PLANT.step(floats, state, *GOING.signals, dt=GOING.step)
    return np.array(ExtendedKalman(model=PLANT).read_model(floats, state, (), GOING.signals))


def quiet(cls: Any) -> Any:
    return cls(model=PLANT, temperature_noise=0.0, fraction_noise=0.0)


def test_slopes_are_those_of_the_model() -> None:
    start = hidden_states.read_hidden(floats, PLANT, amid(PLANT), GOING.signals)
    assert 0.2 < start[1] < 0.8
    columns = []
    for k, step in enumerate((1e-4, 1e-6)):
        ends = [[x + s * step * (i == k) for i, x in enumerate(start)] for s in (1.0, -1.0)]
        columns.append((ended(ends[0]) - ended(ends[1])) / (2.0 * step))
    slopes = np.array(columns).T
    found = np.array(forecast(quiet(ExtendedKalman), 1.0).covariance)
    meant = slopes @ np.diag(np.square(SIZES)) @ slopes.T
    assert np.abs(found - meant).max(axis=1) == pytest.approx(0.0, abs=1e-4 * np.abs(meant).max())
    size = np.sqrt(np.diag(meant))
    assert np.abs((found - meant) / np.outer(size, size)).max() < 1e-4


def test_near_the_mean_points_say_what_slopes_say() -> None:
    exact, points = (forecast(quiet(cls), 1e-4) for cls in FILTERS)
    size = np.sqrt(np.diag(exact.covariance))
    apart = np.array(points.covariance) - np.array(exact.covariance)
    assert np.abs(apart / np.outer(size, size)).max() < 1e-3
    assert points.mean == pytest.approx(exact.mean, rel=1e-7)


@pytest.mark.parametrize("cls", FILTERS)
def test_noise_adds_its_variance(cls: Any) -> None:
    noisy = cls(model=PLANT, temperature_noise=2.0, fraction_noise=0.1)
    more, less = (np.array(forecast(one, 1.0).covariance) for one in (noisy, quiet(cls)))
    assert np.diag(more - less)[:2] == pytest.approx([4.0 * PERIOD, 0.01 * PERIOD], rel=1e-9)


# ---------------------------------------------------------------- samples


@pytest.mark.parametrize("cls", FILTERS)
def test_an_old_reading_is_not_used(cls: Any) -> None:
    observer = cls(model=PLANT)
    names = list(observer.estimates())
    matrix = covariance.build_diagonal([size**2 for size in SIZES])
    memory = [*flatten_numbers(amid(PLANT)), *covariance.pack_matrix(matrix)]
    found, signals = {}, {"drive": 0.3}
    for age in (0.0, PERIOD):
        readings = {"resistance": 2.5, "resistance.age": age}
        after, _ = observer.update(floats, memory, readings, signals, PERIOD, 1)
        found[age] = dict(zip(names, after, strict=True))
    std = "martensite_fraction_std"
    assert found[0.0]["nis"] > 0.0
    assert found[PERIOD]["nis"] == 0.0
    assert found[0.0][std] < 0.95 * found[PERIOD][std]
    older = cls(model=PLANT, oldest=PERIOD)
    again, _ = older.update(floats, memory, readings, signals, PERIOD, 1)
    assert again == pytest.approx(list(found[0.0].values()), rel=1e-12)


def test_without_noise_the_inverse_model_is_exact() -> None:
    bench = sensing_bench(PLANT, InverseModel(model=PLANT), noise=0.0)
    found = run(bench, 4.0, waveforms={"drive": HEATING}, runtime="floats")
    warm = found["current"] > 0.0
    assert np.ptp(found["martensite_fraction"]) > 0.5
    for name, size in (("martensite_fraction", 1.0), ("temperature", 50.0), ("position", 0.01)):
        apart = np.abs(found[f"estimated.{name}"] - found[name])[warm]
        assert apart.max() < 1e-6 * size, name


def test_a_resistance_that_tells_nothing_leaves_the_model_alone() -> None:
    flat = PerLengthResistance(r_A=9.0, r_M=9.0)
    plant = sensing_plant(element=wire_a().with_parts(resistance=flat))
    bench = sensing_bench(plant, InverseModel(model=plant))
    found = run(bench, 2.5, waveforms={"drive": HEATING}, runtime="floats")
    assert found["estimated.martensite_fraction"] == pytest.approx(found["martensite_fraction"])
    assert np.all(found["estimated.sensitivity"] == 0.0)


def test_a_plant_that_is_shaken_by_nothing_is_the_plant() -> None:
    still = shaken(PLANT, temperature_noise=0.0, fraction_noise=0.0)
    ways = {}
    for plant in (PLANT, still):
        bench = sensing_bench(plant, None)
        ways[plant is still] = run(bench, 2.5, waveforms={"drive": HEATING}, runtime="floats", seed=None)
    for name, column in ways[False].items():
        assert ways[True][name] == pytest.approx(column, rel=1e-9, abs=1e-9), name


# ---------------------------------------------------------------- names and refusals


def machine() -> Machine:
    mechanism = example(REGISTRIES["mechanism"]["antagonistic-pulley"])
    one = Actuator(**{name: getattr(PLANT, name) for name in Actuator.declarations})
    return Machine(mechanism=mechanism, group=Group(**dict.fromkeys(mechanism.ports(), one)))


@pytest.mark.parametrize("cls", FILTERS)
def test_a_machine_has_a_pair_at_every_port(cls: Any) -> None:
    pair = machine()
    ports = pair.mechanism.ports()
    observer = cls(
        model=pair,
        measured=tuple(f"{port}.resistance" for port in ports),
        drifting=("environment.temperature",) if len(ports) == 1 else (),
    )
    signals = dict.fromkeys(ports, 0.1)
    first, memory = observer.rest(floats, {}, signals)
    readings = {f"{p}.resistance{e}": x for p in ports for e, x in (("", 2.3), (".age", 0.0))}
    after, again = observer.update(floats, memory, readings, signals, PERIOD, 1)
    assert len(first) == len(after) == len(observer.estimates())
    assert len(memory) == len(again)
    assert {f"{port}.temperature_std" for port in ports} <= set(observer.estimates())
    assert {"angle", "angle_std"} <= set(observer.estimates())


def test_drifting_parameters_are_among_the_estimates() -> None:
    observer = ExtendedKalman(model=PLANT, drifting=("diameter", "environment.temperature"))
    found = observer.estimates()
    assert found["element.diameter"].unit == found["element.diameter_std"].unit == "m"
    assert found["environment.temperature"].unit == "K"
    assert found["environment.temperature_std"].unit == found["temperature_std"].unit == "delta_degC"
    first, _ = observer.rest(floats, {}, {"drive": 0.1})
    values = dict(zip(found, first, strict=True))
    assert values["element.diameter"] == PLANT.value_of("diameter")
    assert values["element.diameter_std"] == pytest.approx(0.02 * values["element.diameter"])


def axial() -> Any:
    return PLANT.with_parts(element=example(REGISTRIES["element"]["axial-wire"]))


def moving() -> Any:
    return PLANT.with_parts(mechanism=example(REGISTRIES["mechanism"]["lever"], motion="dynamic"))


@pytest.mark.parametrize("name", ["extended-kalman", "unscented-kalman", "inverse-model"])
@pytest.mark.parametrize(
    ("model", "options", "sentence"),
    [
        (axial, {}, "`axial-wire` is not the same all over"),
        (moving, {}, "knows no inertia"),
        (lambda: shaken(PLANT), {}, "needs a `System` or a `Machine`"),
        (lambda: PLANT, {"wanted": ("positon",)}, "Did you mean `position`"),
    ],
)
def test_what_does_not_fit_is_refused(name: str, model: Any, options: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        OBSERVERS[name](model=model(), **options)


def test_more_refusals() -> None:
    with pytest.raises(ParameterError, match="for one element, but its model has 2"):
        InverseModel(model=machine(), measured="protagonist.resistance")
    with pytest.raises(ParameterError, match="no parameter `diametr`"):
        ExtendedKalman(model=PLANT, drifting=("diametr",))
    with pytest.raises(ParameterError, match=r"`mechanism.preload` cannot drift: it is 0"):
        loose = PLANT.with_values({"preload": 0.0})
        ExtendedKalman(model=loose, drifting=("preload",))
    with pytest.raises(ParameterError, match="which the plant is not"):
        ExtendedKalman(model=PLANT).rest(floats, {}, {"driv": 0.1})
    with pytest.raises(InputError, match="no Kalman filter"):
        check_consistency(sensing_bench(PLANT, InverseModel(model=PLANT)), 1.0)
