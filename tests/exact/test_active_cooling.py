"""Driven cooling: closed forms of fan and Peltier module, averages over a step, and energy that closes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import martensite as ms
from martensite.base.errors import ParameterError
from martensite.export.strand import TracedStrand
from martensite.kernels import floats
from martensite.physics.thermal import ChurchillBernstein, ChurchillChu, CombinedCooling, ConstantCooling, Cylinder
from martensite.physics.thermal.active_cooling import Fan, Peltier
from martensite.scenario.scenario import read_scenario
from martensite.signals.moments import Moments
from martensite.simulate.ledger import HeatBalance

EXAMPLE = Path(__file__).parents[2] / "examples" / "fan_cooled.toml"
WIRE, WARM, AROUND = Cylinder(0.25e-3, 0.2), 370.0, 295.0
PELTIER = Peltier(
    seebeck=0.01, resistance=1.5, conductance=0.02, contact=0.05, sink=0.5, pitch=0.05, still=ConstantCooling(h=60.0)
)


def film(model: Any, given: float | Moments) -> float:
    return float(model.with_signals(floats, {"fan": given}).film(floats, WARM, AROUND, WIRE))


def test_a_fan_that_stands_is_still_air_and_a_storm_is_the_correlation_of_a_stream() -> None:
    fan, still = Fan(), ChurchillChu().film(floats, WARM, AROUND, WIRE)
    assert film(fan, 0.0) == pytest.approx(still, rel=1e-12)
    assert film(fan, -3.0) == film(fan, 0.0) == fan.film(floats, WARM, AROUND, WIRE)
    assert film(Fan(highest=2.0), 9.0) == film(fan, 2.0)
    rows = [(film(fan, u), ChurchillBernstein(speed=u).film(floats, WARM, AROUND, WIRE)) for u in (1.0, 10.0, 100.0)]
    differ = [mixed / forced - 1.0 for mixed, forced in rows]
    assert 0.05 > differ[0] > differ[1] > differ[2] > 0.0
    assert differ[2] < 1e-4


def test_a_signal_is_averaged_within_a_step() -> None:
    """Exact for one switched between two levels, Simpson's rule for a ramp."""
    fan = Fan()
    switched = Moments(0.3 * 4.0, 0.3 * 16.0, 0.0, 4.0)
    assert film(fan, switched) == pytest.approx(0.3 * film(fan, 4.0) + 0.7 * film(fan, 0.0), rel=1e-12)
    ramp = Moments(3.0, 9.0 + 4.0 / 12.0, 2.0, 4.0)
    simpson = (film(fan, 2.0) + 4.0 * film(fan, 3.0) + film(fan, 4.0)) / 6.0
    assert film(fan, ramp) == pytest.approx(simpson, rel=1e-12)
    assert film(fan, Moments.constant(2.0)) == pytest.approx(film(fan, 2.0), rel=1e-14)


@pytest.mark.parametrize("current", [0.0, 1.0, 3.0])
def test_a_peltier_module_is_two_heat_balances(current: float) -> None:
    """Against a solve of both balances; without current, three conductances in series."""
    p, joule = PELTIER, 0.5 * current * current * PELTIER.resistance
    matrix = [
        [p.contact + p.seebeck * current + p.conductance, -p.conductance],
        [-p.conductance, p.sink + p.conductance - p.seebeck * current],
    ]
    cold, hot = np.linalg.solve(matrix, [p.contact * WARM + joule, p.sink * AROUND + joule])
    found = p.with_signals(floats, {"peltier": current}).pump_heat(floats, WARM, AROUND, WIRE)
    assert found is not None
    assert found == pytest.approx(WIRE.length / p.pitch * p.contact * (WARM - cold), rel=1e-10)
    if current == 0.0:
        series = 1.0 / (1.0 / p.contact + 1.0 / p.conductance + 1.0 / p.sink)
        assert found == pytest.approx(WIRE.length / p.pitch * series * (WARM - AROUND), rel=1e-10)
    else:
        assert cold < WARM and hot > AROUND


def test_a_module_that_heats_itself_without_end_is_refused() -> None:
    for change in ({"sink": 0.03}, {"reverse": 8.0}):
        with pytest.raises(ParameterError, match="heats itself without end"):
            PELTIER.with_parts(**change)


WIRE_TEXT = """
[element]
kind = "wire"
material = "flexinol-90"
diameter = "0.25 mm"
length = "200 mm"
law = "liang-rogers"
[mechanism]
kind = "dead-weight"
mass = "500 g"
[environment]
temperature = "25 degC"
"""
PULSE = """
[drive]
kind = "current"
waveform = { kind = "step", high = "0.9 A", at = "1 s", until = "4 s" }
[run]
duration = "8 s"
"""
FAN = 'cooling = { kind = "fan" }'
MODULE = """
[environment.cooling]
kind = "peltier"
seebeck = "0.01 V/K"
resistance = "1.5 ohm"
conductance = "0.02 W/K"
contact = "0.05 W/K"
sink = "0.5 W/K"
pitch = "50 mm"
still = { kind = "constant", h = "60 W/m^2/K" }
"""


def read(text: str) -> Any:
    return read_scenario(text, EXAMPLE)


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_heat_closes_though_the_loss_swings_within_steps_and_jumps(runtime: str) -> None:
    swings = '[signals.fan]\nkind = "sine"\nlow = "0 m/s"\nhigh = "5 m/s"\nfrequency = "1 Hz"'
    jumps = '[signals.peltier]\nkind = "step"\nhigh = "2 A"\nat = "4 s"'
    for cooling, signal in ((FAN, swings), (MODULE, jumps)):
        found = ms.run(read(WIRE_TEXT + cooling + PULSE + signal), runtime=runtime)
        balance = found.energy["heat"]
        assert isinstance(balance, HeatBalance)
        assert (balance.residual or 1.0) < 1e-4
        assert balance.lost > 5.0


def test_coolers_may_share_a_signal_but_not_a_name_of_something_else() -> None:
    both = CombinedCooling(convection=Fan(), radiation=Fan(still=ConstantCooling(h=5.0)))
    assert both.signals() == {"fan": "m/s"}
    for name in ("temperature", "position", "my fan"):
        with pytest.raises(ParameterError, match="must be a unique name"):
            read(WIRE_TEXT + f'cooling = {{ kind = "fan", signal = "{name}" }}' + PULSE)


LOOP = """
[drive]
kind = "power"
waveform = { kind = "constant", level = "3 W" }
[controllers.fan]
kind = "pid"
measured = "temperature"
Kp = -0.1
Ki = -2.5
low = "0 m/s"
high = "20 m/s"
[references.fan]
kind = "constant"
level = "100 degC"
[bench]
period = "20 ms"
[run]
duration = "20 s"
"""


def test_a_controller_holds_the_temperature_by_the_fan() -> None:
    """At a constant power the fan must find the film coefficient P/(S ΔT): heat balance of the steady wire."""
    found = ms.run(read(WIRE_TEXT + FAN + LOOP))
    kelvin, speed = float(found.columns["temperature"][-1]), float(found.columns["fan"][-1])
    assert kelvin == pytest.approx(373.15, abs=0.01)
    film = Fan().film_at(floats, speed, kelvin, 298.15, WIRE)
    assert film * math.pi * WIRE.diameter * WIRE.length * (kelvin - 298.15) == pytest.approx(3.0, rel=1e-3)


def test_another_simulator_is_refused_what_it_cannot_drive() -> None:
    (one,) = ms.load(EXAMPLE).system.actuators().values()
    with pytest.raises(ParameterError, match="cooled by the signal `fan`"):
        TracedStrand("element", one, 5.0, 0.0, 0.2)
