"""Everything registered is documented, can be built, and keeps the promises of its interface."""

import re
from itertools import pairwise
from typing import Any

import builders
import numpy as np
import pytest
from builders import REGISTRIES, examples, label, registered

from martensite import units
from martensite.electrical.base import Conductor
from martensite.elements.base import Spring
from martensite.elements.limits import Limits
from martensite.elements.lumped import AbstractLumped
from martensite.io.citations import bibliography
from martensite.laws.base import AbstractLaw, Fractions
from martensite.mechanisms.load_line import AbstractLoadLine, Assembly
from martensite.parameters import Parametrised, param
from martensite.runtimes import floats
from martensite.signals.base import DRIVE
from martensite.system import System
from martensite.thermal.base import AbstractCooling, Cylinder, Environment
from martensite.thermal.constant import ConstantCooling

CLASSES = [*registered(), System, Environment, Limits]


def undocumented(cls: type[Parametrised]) -> list[str]:
    """What a class leaves unsaid."""
    missing = [] if cls.__dict__.get("__doc__") else ["the class"]
    for name, declared in cls.declarations.items():
        if not declared.doc.strip():
            missing.append(f"`{name}`")
        if declared.kind == "parameter" and not declared.unit:
            missing.append(f"unit of `{name}`")
    return missing


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
class TestDeclarations:
    def test_everything_is_documented(self, cls):
        assert undocumented(cls) == []

    def test_units_are_units(self, cls):
        for name, declared in cls.declarations.items():
            if declared.kind == "parameter" and declared.unit != DRIVE:
                assert units.conversion(declared.unit, declared.unit) == (1.0, 0.0), name

    def test_defaults_are_allowed(self, cls):
        for name, declared in cls.declarations.items():
            if declared.kind == "parameter" and isinstance(declared.default, float):
                assert declared.convert(cls.__name__, name, declared.default) == declared.default

    def test_sources_are_in_the_bibliography(self, cls):
        assert set(cls.cites) <= set(bibliography())


@pytest.mark.parametrize("kind", REGISTRIES)
def test_names_are_lower_case_words(kind):
    names = REGISTRIES[kind].names()
    assert names
    for name in names:
        assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name)
        assert REGISTRIES[kind][name].registered_name == name


@pytest.mark.parametrize("cls", registered(), ids=lambda cls: cls.__name__)
def test_examples_survive_a_round_trip_through_their_values(cls):
    thing = builders.example(cls)
    changed = {leaf.path: leaf.value for leaf in thing.leaves()}
    assert thing.with_values(changed) == thing


def test_silence_is_noticed():
    class Silent(Parametrised):
        size: float = param("", " ")

    assert undocumented(Silent) == ["the class", "`size`", "unit of `size`"]


# ---------------------------------------------------------------- heat loss

TEMPERATURES = np.linspace(260.0, 450.0, 96)


def losses(cooling: AbstractCooling) -> np.ndarray:
    """Heat flow per surface [W/m²] at all temperatures, surroundings at 295 K."""
    films = [cooling.film(floats, t, 295.0, Cylinder(0.2e-3, 0.2)) for t in TEMPERATURES.tolist()]
    return np.array(films) * (TEMPERATURES - 295.0)


@pytest.mark.parametrize("cooling", examples("cooling"), ids=label)
def test_heat_loss_grows_with_temperature(cooling):
    assert (np.diff(losses(cooling)) > 0.0).all()
    assert np.sign(losses(cooling)) == pytest.approx(np.sign(TEMPERATURES - 295.0))


@pytest.mark.parametrize("element", examples("element"), ids=label)
def test_elements_lose_heat_to_the_colder_side_only(element):
    surroundings = builders.example_environment()
    flows = [element.heat_loss(floats, t, surroundings) for t in TEMPERATURES.tolist()]
    assert (np.diff(flows) > 0.0).all()
    assert element.heat_loss(floats, surroundings.temperature, surroundings) == 0.0
    assert element.heat_capacity_total() > 0.0
    if isinstance(element, AbstractLumped):
        assert element.latent_heat_total(floats, 50e6, 330.0) >= 0.0


def test_a_falling_heat_loss_is_noticed():
    class Falling(ConstantCooling):
        """Loses less and less."""

        def film(self, xp, temperature, ambient, shape):
            return self.h / (1.0 + (temperature - ambient) * (temperature - ambient))

    assert not (np.diff(losses(Falling(h=10.0))) > 0.0).all()


# ---------------------------------------------------------------- electrical


@pytest.mark.parametrize("model", examples("resistance"), ids=label)
def test_resistance_is_positive_and_grows_with_length(model):
    for fraction in (0.0, 0.3, 1.0):
        short, long = (
            model.resistance(floats, fraction, 0.01, 330.0, Conductor(3e-8, length))
            for length in (0.1, 0.2)
        )
        assert 0.0 < short < long


@pytest.mark.parametrize("source", examples("drive"), ids=label)
def test_sources_give_nothing_for_nothing_and_never_less_for_more(source):
    for ohms in (0.5, 5.0, 50.0):
        currents = [source.current(floats, u, ohms) for u in np.linspace(0.0, 20.0, 41).tolist()]
        assert currents[0] == 0.0
        assert (np.diff(currents) >= 0.0).all()
        if hasattr(source, "current_limit"):
            assert max(currents) <= source.current_limit
        if hasattr(source, "voltage_limit"):
            assert max(currents) * (ohms + source.series_resistance) <= source.voltage_limit + 1e-12


@pytest.mark.parametrize("source", examples("drive"), ids=label)
def test_sources_name_the_unit_of_their_signal(source):
    assert units.conversion(source.unit, source.unit) == (1.0, 0.0)
    assert source.sets_temperature == (source.unit == "K")


# ---------------------------------------------------------------- load lines

LOAD_LINES = [m for m in examples("mechanism") if isinstance(m, AbstractLoadLine)]


@pytest.mark.parametrize("mechanism", LOAD_LINES, ids=label)
class TestLoadLines:
    def test_force_is_never_negative_and_falls_with_free_length(self, mechanism):
        for compliance in (1e-6, 1e-4, 1e-2):
            frees = np.linspace(-0.05, 0.05, 101).tolist()
            forces = [
                mechanism.force(floats, Assembly(0.004), Spring(free, compliance)) for free in frees
            ]
            assert min(forces) >= 0.0
            assert (np.diff(forces) <= 0.0).all()

    def test_assembly_is_position_zero(self, mechanism):
        force = mechanism.start_force(floats)
        spring = Spring(0.003, 2e-4)
        elongation = spring.free + spring.compliance * force
        found = mechanism.force(floats, Assembly(elongation), spring)
        assert found == pytest.approx(force, rel=1e-12)
        zero = mechanism.position(floats, Assembly(elongation), found, elongation)
        assert zero == pytest.approx(0.0, abs=1e-15)

    def test_position_grows_as_the_element_shortens(self, mechanism):
        assembly, positions = Assembly(0.01), []
        for free in np.linspace(0.009, 0.001, 50).tolist():
            force = mechanism.force(floats, assembly, Spring(free, 2e-4))
            positions.append(mechanism.position(floats, assembly, force, free + 2e-4 * force))
        assert (np.diff(positions) > 0.0).all()


# ---------------------------------------------------------------- waveforms

DURATION = 3.0


def extremes(wave: Any) -> tuple[float, float]:
    """Lowest and highest level a waveform may take, from what it declares."""
    declared = [n for n, d in wave.declarations.items() if d.kind == "parameter"]
    if {"low", "high"} <= set(declared):
        return wave.low, wave.high
    return {
        "constant": lambda w: (w.level, w.level),
        "staircase": lambda w: (w.first, w.first + (w.count - 1) * w.increment),
        "table": lambda w: (min(w.values), max(w.values)),
    }.get(type(wave).registered_name, lambda w: (-np.inf, np.inf))(wave)


@pytest.mark.parametrize("wave", examples("waveform"), ids=label)
class TestWaveforms:
    def test_values_stay_within_the_declared_levels(self, wave):
        low, high = extremes(wave)
        levels = [wave.value(t) for t in np.linspace(0.0, 2 * DURATION, 6001).tolist()]
        assert np.isfinite(levels).all()
        assert low <= min(levels)
        assert max(levels) <= high

    def test_edges_ascend_inside_the_duration(self, wave):
        edges = wave.edges(DURATION)
        assert edges == sorted(set(edges))
        assert all(0.0 < t < DURATION for t in edges)

    def test_every_jump_and_bend_is_an_edge(self, wave):
        """Between edges, halving the sampling interval quarters the second difference."""
        cuts = [0.0, *wave.edges(DURATION), DURATION]
        for a, b in pairwise(cuts):
            inner = np.linspace(a, b, 1003)[1:-1]
            levels = np.array([wave.value(t) for t in inner.tolist()])
            fine = np.abs(np.diff(levels, 2)).max()
            coarse = np.abs(np.diff(levels[::2], 2)).max()
            assert fine <= 0.3 * coarse + 1e-12

    def test_the_value_at_an_edge_is_the_one_after_it(self, wave):
        for edge in wave.edges(DURATION):
            assert wave.value(edge) == pytest.approx(wave.value(edge + 1e-9), abs=1e-6)


def test_an_unlisted_jump_is_noticed():
    pwm = builders.example(REGISTRIES["waveform"]["pwm"])
    forgetful = builders.FunctionWaveform(function=pwm.value)
    with pytest.raises(AssertionError):
        TestWaveforms().test_every_jump_and_bend_is_an_edge(forgetful)


# ---------------------------------------------------------------- laws


@pytest.mark.parametrize("law", examples("law"), ids=label)
class TestLaws:
    def test_memory_starts_where_it_is_told(self, law: AbstractLaw):
        memory = law.init(floats, Fractions(0.4, 0.4), 30e6, 310.0)
        assert law.fractions(memory) == pytest.approx((0.4, 0.4), abs=1e-15)
        assert (memory.stress, memory.temperature) == (30e6, 310.0)

    def test_strain_is_affine_in_stress(self, law: AbstractLaw):
        for fraction in (0.0, 0.5, 1.0):
            frozen = Fractions(fraction, fraction)
            a, b, c = (law.strain(floats, frozen, s, 310.0) for s in (0.0, 100e6, 200e6))
            assert a == law.free_strain(floats, frozen, 310.0)
            assert c - b == pytest.approx(b - a, rel=1e-12, abs=0)
            assert b - a == pytest.approx(100e6 * law.compliance(floats, frozen), rel=1e-12, abs=0)
            assert law.compliance(floats, frozen) > 0.0
