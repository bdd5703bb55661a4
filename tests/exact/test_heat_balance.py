"""The heat balance against closed forms, and the energy that goes in, out and stays.

Powers are integrated here, by Romberg's rule on samples of the outputs, not by the march.
"""

import math

import numpy as np
import pytest
from builders import ZERO, FunctionWaveform, hanging_wire, through, wire_a
from scipy.integrate import romb

from martensite.physics.electrical.sources import CurrentSource, PowerSource
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.ledger import integrate_effort

AMBIENT = 20 + ZERO


def surface(wire):
    return math.pi * wire.diameter * wire.length


def mass(wire):
    return wire.density * math.pi * wire.diameter**2 / 4 * wire.length


def watts_for(system, celsius, h=100.0):
    """The power [W] that holds a wire of constant h at a temperature."""
    return h * surface(system.element) * (celsius + ZERO - AMBIENT)


# ---------------------------------------------------------------- energy


def balance(system, wave, duration, samples, step):
    """Energy put in [J], and what is missing of it as a share."""
    run = simulate(system, wave, duration, step=step, samples=samples)
    width = duration / (samples - 1)
    put_in, lost = (float(romb(np.array(run[n]), width)) for n in ("power", "heat_loss"))
    wire = system.element
    stored = mass(wire) * 400.0 * (run["temperature"][-1] - run["temperature"][0])
    change = run["martensite_fraction"][-1] - run["martensite_fraction"][0]
    latent = -mass(wire) * wire.latent_heat * change
    assert min(run["martensite_fraction"]) < 0.2
    return put_in, (put_in - lost - stored - latent) / put_in


def test_latent_heat_is_what_calorimetry_would_see():
    """Very slow heating: the energy beyond storage is mass times latent heat, ξ from 1 to 0."""
    system = hanging_wire(h=0.0, initial_fraction=1.0)
    wire = system.element
    watts = 0.05
    needed = mass(wire) * (400.0 * (100.0 - 20.0) + 24e3)
    run = simulate(system, Constant(level=watts), needed / watts, step=0.05, samples=11)
    assert run["temperature"][-1] == pytest.approx(100.0 + ZERO, abs=1e-7)
    assert run["martensite_fraction"][-1] == 0.0


# ---------------------------------------------------------------- closed forms


@pytest.mark.parametrize("celsius", [40.0, 75.0, 130.0])
@pytest.mark.parametrize("h", [50.0, 100.0])
def test_steady_temperature_of_a_constant_power(celsius, h):
    system = hanging_wire(mass=0.5, h=h)
    watts = watts_for(system, celsius, h)
    run = simulate(system, Constant(level=watts), 2000.0, step=0.05, samples=3)
    assert run["temperature"][-1] == pytest.approx(celsius + ZERO, abs=1e-8)
    assert run["heat_loss"][-1] == pytest.approx(watts, rel=1e-9)


@pytest.mark.parametrize("amperes", [0.5, 1.6])
def test_steady_temperature_of_a_constant_current(amperes):
    """I² R of all martensite, or of all austenite, equals h S (T - T_a)."""
    system = hanging_wire(source=CurrentSource())
    per_metre = 8.3 * (1.15 if amperes < 1 else 1.0)
    rise = amperes**2 * per_metre * 0.25 / (100.0 * surface(system.element))
    run = simulate(system, Constant(level=amperes), 300.0, step=0.02, samples=3)
    assert run["temperature"][-1] == pytest.approx(AMBIENT + rise, rel=1e-10)


def rise_and_fall(step):
    """Times, overtemperatures, time constant and final rise: on for 5 s, then off."""
    system = hanging_wire()
    watts = watts_for(system, 60.0)  # below A_s: no transformation
    wave = FunctionWaveform(function=lambda t: watts if t < 5.0 else 0.0, kinks=(5.0,))
    run = simulate(system, wave, 15.0, step=step, samples=301)
    assert set(run["martensite_fraction"]) == {1.0}
    wire = system.element
    constant = mass(wire) * 400.0 / (100.0 * surface(wire))
    return np.array(run.times), np.array(run["temperature"]) - AMBIENT, constant


def test_exponentials_without_transformation():
    times, rise, constant = rise_and_fall(2e-3)
    top = 40.0 * -math.expm1(-5.0 / constant)
    heating = 40.0 * -np.expm1(-times / constant)
    cooling = top * np.exp(-(times - 5.0) / constant)
    assert rise == pytest.approx(np.where(times < 5.0, heating, cooling), abs=40.0 * 1e-7)


def test_every_step_of_a_linear_balance_is_a_pade_approximant():
    """Of the exponential, (1 - z/3)/(1 + 2z/3 + z²/6): third order, and a long rest is over."""
    _, rise, constant = rise_and_fall(0.05)
    z = 0.05 / constant
    factor = ((1 - z / 3) / (1 + 2 * z / 3 + z * z / 6)) ** np.arange(301)
    top = 40.0 * (1 - factor[100])
    expected = np.where(np.arange(301) <= 100, 40.0 * (1 - factor), top * factor[np.arange(301) - 100])
    assert rise == pytest.approx(expected, abs=1e-11)


# ---------------------------------------------------------------- no transformation


@pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
def test_below_M_f_nothing_transforms(xi):
    """Whatever the fraction at the start, up to A_s on heating and back down below M_f."""
    system = hanging_wire(initial_fraction=xi)
    watts = watts_for(system, 41.9)
    wave = through([0.0, watts, 0.0], 20.0)
    run = simulate(system, wave, 40.0, step=0.02, samples=201)
    assert max(run["temperature"]) > 38 + ZERO
    assert set(run["martensite_fraction"]) == {xi}


def test_power_source_delivers_what_it_is_told():
    run = simulate(hanging_wire(source=PowerSource()), Constant(level=2.5), 5.0, step=0.01)
    assert run["power"] == pytest.approx([2.5] * len(run.times), rel=1e-14)


def test_wire_geometry():
    wire = wire_a()
    assert wire.surface() == pytest.approx(2.992367e-4, rel=1e-6)
    assert wire.mass() == pytest.approx(1.838398072600609e-4, rel=1e-14)


def test_work_of_a_force_along_a_way_is_that_of_parabolas():
    """1 + 2s + 3s² along 4 + 5s + 6s² for s from 0 to 1: the integral of (1 + 2s + 3s²)(5 + 12s) is 38."""
    force, way = (lambda s: 1.0 + 2.0 * s + 3.0 * s * s), (lambda s: 4.0 + 5.0 * s + 6.0 * s * s)
    found = integrate_effort([force(s) for s in (0.0, 0.5, 1.0)], [way(s) for s in (0.0, 0.5, 1.0)])
    assert found == pytest.approx(38.0, rel=1e-14)
