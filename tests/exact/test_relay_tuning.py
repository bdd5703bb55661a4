"""A controller that tunes itself: the same numbers as the relay test beside it, then a PID controller with them.

Sources of truth: `run_relay_test`, which measures a finished run, and a PID controller that is given the gains.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tuning_cases import DT, linear_bench, wire_bench

from martensite.base.errors import ParameterError
from martensite.control.checks.base import Checks
from martensite.control.checks.reading import Overheat
from martensite.control.controllers.pid import PidLaw
from martensite.control.controllers.relay_tuning import RelayTuning
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.control.rules.relay import gains_by_relay, run_relay_test
from martensite.control.supervisors.guard import Guard
from martensite.signals.constant import Constant

LEVEL, BIAS, SWING = 1.3, 0.4, 0.25
GIVEN: dict[str, Any] = {"level": LEVEL, "bias": BIAS, "amplitude": SWING, "form": "pi"}


def tune(bench: Bench, **given: Any) -> Bench:
    """A bench with the controller in the place of its own."""
    ((drive, pid),) = bench.controllers.members().items()
    numbers: dict[str, Any] = {"reference": Constant(level=LEVEL), **GIVEN, **given}
    one = RelayTuning(measured=pid.measured, **numbers)
    return bench.with_parts(controllers=Controllers(**{drive: one}))


def find_gains(run: Any) -> list[float]:
    return [run[f"controller.{name}"][-1] for name in ("Kp", "Ki", "Kd")]


@pytest.mark.parametrize(
    ("rule", "form"), [("tyreus-luyben", "pi"), ("ziegler-nichols", "pid"), ("no-overshoot", "pid")]
)
@pytest.mark.parametrize(("gain", "hysteresis"), [(2.0, 0.0), (2.0, 0.1), (-2.0, 0.1)])
def test_gains_are_those_of_the_relay_test(
    gain: float, hysteresis: float, rule: str, form: str, c_compiler: str
) -> None:
    level = 0.5 + 0.4 * gain
    cycle = run_relay_test(linear_bench(gain), level, BIAS, SWING, hysteresis, reverse=gain < 0.0, duration=30.0)
    wanted = gains_by_relay(cycle, rule, form).per_second()
    action = "rising" if gain > 0.0 else "falling"
    one = tune(linear_bench(gain), level=level, hysteresis=hysteresis, rule=rule, form=form, action=action)
    run = simulate_bench(one, 30.0)
    assert run["controller.tuning"][-1] == 0.0
    np.testing.assert_allclose(find_gains(run), wanted, rtol=0.01)
    assert run["controller.ultimate_period"][-1] == pytest.approx(cycle.period, rel=0.01)


def test_gains_of_a_wire_are_those_of_the_relay_test(c_compiler: str) -> None:
    """Heating and cooling last differently, the reading is late."""
    given: dict[str, Any] = {"level": 4e-3, "bias": 0.5, "amplitude": 0.5, "hysteresis": 5e-5}
    run = simulate_bench(tune(wire_bench(), reference=Constant(level=4e-3), **given), 60.0)
    over = run.times[int(np.argmin(run["controller.tuning"]))]
    cycle = run_relay_test(wire_bench(), *given.values(), duration=over)
    np.testing.assert_allclose(find_gains(run), gains_by_relay(cycle, form="pi").per_second(), rtol=0.01)
    assert run["position"][-1] == pytest.approx(4e-3, abs=5e-5)
    assert max(run["controller.tuning"]) == 1.0 and not run.warnings


def test_it_goes_over_without_a_bump_and_goes_on_as_a_pid(c_compiler: str) -> None:
    run = simulate_bench(tune(linear_bench(), hysteresis=0.05), 30.0)
    tuning, signal = np.array(run["controller.tuning"]), np.array(run["wanted"])
    first = int(np.argmin(tuning))
    assert sorted(set(signal[:first].tolist())) == pytest.approx([BIAS - SWING, BIAS + SWING])
    assert signal[first] == pytest.approx(0.4, abs=0.03)  # that holds the level
    error = LEVEL - np.array(run[linear_bench().controllers.members()["u"].measured])
    Kp, Ki, _ = find_gains(run)
    steps = Kp * np.diff(error[first:]) + Ki * DT * error[first + 1 :]
    np.testing.assert_allclose(np.diff(signal[first:]), steps, atol=1e-9)
    assert abs(error[-1]) < 0.01


def test_a_balanced_relay_heats_as_long_as_it_cools(c_compiler: str) -> None:
    """A bias beside what holds the level: 0.5 instead of 0.4."""
    shares = {}
    for balance in ("off", "on"):
        run = simulate_bench(tune(linear_bench(), bias=0.5, balance=balance, skipped=5.0, law=PidLaw(high=2.0)), 40.0)
        tuning, signal = np.array(run["controller.tuning"]), np.array(run["wanted"])
        tail = signal[: int(np.argmin(tuning))][-200:]
        shares[balance] = float((tail > 0.5 * (tail.min() + tail.max())).mean())
    assert abs(shares["on"] - 0.5) < 0.05 < 0.1 < abs(shares["off"] - 0.5)


def test_without_a_cycle_it_gives_up_and_says_so(c_compiler: str) -> None:
    run = simulate_bench(tune(linear_bench(), level=5.0, timeout=8.0), 12.0)
    tuning, signal = np.array(run["controller.tuning"]), np.array(run["wanted"])
    times = np.array(run.times)
    assert set(tuning[times < 8.0]) == {1.0} and set(tuning[times > 8.1]) == {-1.0}
    assert set(signal[times > 8.1]) == {0.0}
    assert find_gains(run) == [0.0, 0.0, 0.0]
    assert any("no steady limit cycle in 8 s" in said for said in run.warnings)
    short = simulate_bench(tune(linear_bench()), 2.0)
    assert any("not over yet" in said for said in short.warnings)


def test_the_guard_has_the_last_word(c_compiler: str) -> None:
    """What it cuts for good makes no cycle: the test ends without one, and the wire stays cool."""
    limit = 340.0
    guard = Guard(checks=Checks(hot=Overheat(reading="temperature", limit=limit)))
    hot = tune(wire_bench(False), level=4e-3, bias=0.5, amplitude=0.5, timeout=20.0)
    run, free = (simulate_bench(one, 25.0) for one in (hot.with_parts(supervisor=guard), hot))
    assert max(free["temperature"]) > limit + 10.0 and free["controller.tuning"][-1] == 0.0
    assert max(run["temperature"]) < limit + 5.0 and run["controller.tuning"][-1] == -1.0
    assert run["alarm"][-1] == Overheat.alarm


@pytest.mark.parametrize("native", [True, False])
def test_in_real_time_it_does_the_same(native: bool, c_compiler: str) -> None:
    bench = tune(linear_bench(), hysteresis=0.05)
    run = simulate_bench(bench, 20.0)
    (measured,) = [one.measured for one in bench.controllers.members().values()]
    loop = RealtimeStep(bench, native=native)
    signals = [loop.step({measured: value})[0] for value in run[measured]]
    np.testing.assert_allclose(signals, run["wanted"], atol=1e-12)
    own = {name: run[name][-1] for name in run.columns if name.startswith("controller.")}
    assert len(own) == 6 and loop.outputs == pytest.approx(own)


@pytest.mark.parametrize(
    ("given", "said"),
    [({"rule": "no-overshoot", "form": "pi"}, "for pid only"), ({"bias": 0.9}, "goes beyond the limits of the signal")],
)
def test_what_no_relay_can_do_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        tune(linear_bench(), **given)
