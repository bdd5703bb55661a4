"""A supply that several sources share: closed forms, a root by SciPy, and a run that loses nothing of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scipy.optimize import brentq

import martensite as ms
from martensite.base.errors import InputError, ParameterError
from martensite.export.mjcf import start_forces
from martensite.kernels import floats
from martensite.physics.electrical import (
    CurrentSource,
    HBridge,
    LinearAmplifier,
    PowerPwm,
    PowerSource,
    PwmVoltage,
    SharedSupply,
    VoltageSource,
)
from martensite.physics.electrical.shared_supply import Consumer

EXAMPLE = Path(__file__).parents[2] / "examples" / "three_rails.toml"
SWITCH = PwmVoltage(supply=12.0)


def test_switches_on_a_supply_in_closed_form() -> None:
    """Σ d_k U/R_k of switches with duties d_k: U_0/(1 + R_i G) with the internal resistance, I_max/G at the limit."""
    switches = [Consumer(SWITCH, duty, ohms) for duty, ohms in ((0.5, 4.0), (0.2, 2.0), (0.0, 1.0))]
    slope = 0.5 / 4.0 + 0.2 / 2.0
    droops = SharedSupply(voltage=12.0, internal_resistance=0.5)
    assert droops.find_voltage(floats, switches) == pytest.approx(12.0 / (1.0 + 0.5 * slope), rel=1e-12)
    holds = SharedSupply(voltage=12.0, internal_resistance=0.5, current_limit=1.0)
    volts, amperes, demand = holds.observe(floats, switches)
    assert volts == pytest.approx(1.0 / slope, rel=1e-12)
    assert amperes == pytest.approx(1.0, rel=1e-12)
    assert demand == pytest.approx(slope * 12.0 / (1.0 + 0.5 * slope), rel=1e-12)
    idle = [one._replace(drive=0.0) for one in switches]
    assert holds.find_voltage(floats, idle) == 12.0


MIXED = [
    Consumer(VoltageSource(series_resistance=0.3), 5.0, 4.0),
    Consumer(CurrentSource(), 0.8, 3.0),
    Consumer(PowerSource(), 3.0, 5.0),
    Consumer(LinearAmplifier(voltage_limit=9.0, headroom=0.7, gain=2.0), 3.0, 6.0),
    Consumer(HBridge(supply=9.0, frequency=1e3), -0.4, 2.0),
    Consumer(PowerPwm(supply=9.0), 2.0, 2.5),
]


@pytest.mark.parametrize(("internal", "limit"), [(0.0, 100.0), (0.4, 100.0), (0.4, 3.0), (0.0, 0.5)])
def test_any_sources_on_a_supply_against_a_root_by_bisection(internal: float, limit: float) -> None:
    supply = SharedSupply(voltage=9.0, internal_resistance=internal, current_limit=limit)

    def excess(volts: float) -> float:
        amperes = supply.sum_currents(floats, MIXED, volts)
        return max(volts - 9.0 + internal * amperes, amperes - limit)

    wanted = 9.0 if excess(9.0) <= 0.0 else brentq(excess, 0.01, 9.0, xtol=1e-13)
    found, amperes, _ = supply.observe(floats, MIXED)
    assert found == pytest.approx(wanted, rel=1e-9)
    assert amperes <= limit * (1.0 + 1e-9)
    parts = [one.limit_voltage(floats, found).supply_current(floats, one.drive, one.resistance) for one in MIXED]
    assert sum(parts) == pytest.approx(amperes, rel=1e-12)


def run(changes: dict[str, Any], **given: Any) -> Any:
    return ms.run(ms.load(EXAMPLE, changes), **given)


def test_a_supply_that_has_enough_changes_nothing(tmp_path: Path) -> None:
    text = EXAMPLE.read_text()
    alone = tmp_path / "alone.toml"
    alone.write_text(text[: text.index("[supply]")] + text[text.index("[run]") :])
    ample = run({"supply.internal_resistance": "0 ohm", "supply.current_limit": "100 A"}, step=0.02)
    without = ms.run(ms.load(alone), step=0.02)
    assert ample["third.temperature"] == pytest.approx(without["third.temperature"], rel=1e-12)
    assert "supply_current" not in without.columns
    assert not [one for one in ample.alarms if one.kind == "rig"]


def test_a_limit_is_kept_said_and_shared_and_steps_are_of_second_order() -> None:
    found = run({})
    assert max(found["supply_current"]) == pytest.approx(3.0, rel=1e-9)
    (alarm,) = [one for one in found.alarms if one.kind == "rig"]
    assert alarm.worst == found.extremes["supply_demand"][1] >= max(found["supply_demand"]) > 4.0
    assert alarm.sentence in found.warnings
    assert alarm.first == pytest.approx(1.5, abs=0.01)
    enough = run({"supply.current_limit": "6 A"})
    assert max(found["first.temperature"]) < max(enough["first.temperature"]) - 10.0
    heat = found.energy["heat"]
    assert (heat.residual or 1.0) < 1e-5
    coarse, fine, exact = (run({"run.samples": 81}, step=step) for step in (0.1, 0.05, 0.003125))
    for name in ("supply_voltage", "second_position", "third.temperature"):
        assert abs(coarse[name][32] - exact[name][32]) > 3.5 * abs(fine[name][32] - exact[name][32]) > 0.0


def test_a_supply_is_for_several_sources() -> None:
    with pytest.raises(InputError, match="not known to a model of MuJoCo"):
        start_forces(ms.load(EXAMPLE).system)
    with pytest.raises(ParameterError, match="takes one element"):
        ms.load(EXAMPLE, {"mechanism": {"kind": "dead-weight", "mass": "1 kg"}})
