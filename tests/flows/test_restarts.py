"""Runs that go on from where another one was.

Source of truth: the whole run, to the last bit; and the closed balances of what was run.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from command import Command

from martensite.base.errors import DataError, InputError
from martensite.kernels.compiler import find_compiler
from martensite.scenario.netcdf import read_labelled, read_restarts
from martensite.scenario.running import run
from martensite.scenario.scenario import Scenario, load
from martensite.simulate.marching import MarchResult
from martensite.simulate.restarts import HOME, Relay
from martensite.simulate.result import Result

EXAMPLES = Path(__file__).parents[2] / "examples"
FOLLOWING = ("flexinol_trained", "isobaric_log", "nitihf")
"""They follow a log of the user's."""
QUICK = (("constant_power", "floats"), ("finger", "c"), ("closed_loop", "floats"), ("isobaric", "c"))
RUNNABLE = [
    path.stem
    for path in sorted(EXAMPLES.glob("*.toml"))
    if "\n[run]" in path.read_text() and path.stem not in FOLLOWING
]


class Leg(NamedTuple):
    """Fields of a plan that a relay uses."""

    times: list[float]
    start: tuple[float, ...] = ()
    extremes: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())


def test_a_pass_is_made_on_one_runtime() -> None:
    """`auto` changes to C once its library is loaded, which may be between two legs; their records differ."""
    used = iter(["floats", "C", "C", "C"])

    def march(plan: Any) -> MarchResult:
        rows = [[time] for time in plan.times]
        return MarchResult(rows, runtime=next(used), state=(0.0,), extremes=((0.0,), (0.0,)))

    relay = Relay(march, HOME, [1.0])
    plan: Any = Leg([0.0, 1.0, 2.0])
    assert relay(plan).rows == [[0.0], [1.0], [2.0]]
    assert {leg.runtime for _, legs in relay.passes for leg in legs} == {"C"} and len(relay.passes) == 1


def place_restarts(scenario: Scenario) -> list[float]:
    """Two times within a run; of a system in discrete time two of its samples, else one that is none."""
    interval = scenario.whole.sample_time()
    times = [0.3701 * scenario.duration, 0.5 * scenario.duration]
    return [round(time / interval) * interval for time in times] if interval else times


def require_same_rest(whole: Result, rest: Result, begin: float) -> None:
    """Raise `AssertionError` unless the rest of a run is that of the whole, in all bits."""
    first = next(k for k, time in enumerate(whole.times) if time > begin * (1.0 + 1e-12))
    assert np.array_equal(whole.times[first:], rest.times[1:])
    for name, column in whole.columns.items():
        assert np.array_equal(column[first:], rest.columns[name][1:], equal_nan=True), name
    assert whole.restarts[-1] == rest.restarts[-1] and whole.accuracy == rest.accuracy


@pytest.mark.parametrize(
    "name, runtime",
    [
        pytest.param(name, how, marks=() if (name, how) in QUICK else pytest.mark.slow)
        for name in RUNNABLE
        for how in ("floats", "c")
    ],
)
def test_a_run_that_goes_on_is_the_rest_of_the_whole_in_all_bits(name: str, runtime: str, tmp_path: Path) -> None:
    """Of every packaged example that runs by itself, through a file."""
    if runtime == "c" and find_compiler() is None:
        pytest.skip("there is no C compiler")
    scenario = load(EXAMPLES / f"{name}.toml")
    if scenario.bench is not None and runtime == "floats" and scenario.duration / scenario.bench.period > 5000:
        pytest.skip("the same program on floats takes long, and is tried on shorter benches")
    times = place_restarts(scenario)
    whole = run(scenario, runtime=runtime, restart_at=times)
    whole.save(tmp_path / "whole.nc")
    known, names = read_restarts(read_labelled(tmp_path / "whole.nc"))
    assert known == whole.restarts and names == whole.state_names
    for time in times:
        rest = run(scenario, runtime=runtime, restart_at=times, start=tmp_path / "whole.nc", at=time)
        require_same_rest(whole, rest, time)


def test_on_given_steps_the_whole_needs_no_restart_to_be_gone_on_with() -> None:
    """From the end of a half that ends with a sample of the whole."""
    scenario = load(EXAMPLES / "constant_power.toml", {"run.step": "20 ms"})
    whole = run(scenario, runtime="floats")
    half = run(scenario, duration=0.5 * scenario.duration, samples=501, runtime="floats")
    rest = run(scenario, start=half, runtime="floats")
    assert scenario.samples == 1001 and rest.times[0] == half.times[-1]
    for name, column in whole.columns.items():
        assert np.array_equal(column[:501], half.columns[name]) and np.array_equal(column[500:], rest.columns[name])


def test_halves_that_were_made_apart_agree_within_the_tolerance_and_balance() -> None:
    scenario = load(EXAMPLES / "finger.toml")
    whole = run(scenario)
    half = run(scenario, duration="10 s")
    rest = run(scenario, start=half)
    for name, least in scenario.system.convergence_scales().items():
        column = whole[name][-len(rest.times) :]
        assert np.abs(rest[name] - column).max() < 2e-4 * max(least, float(np.ptp(whole[name])))
    for one in (half, rest):
        assert all(balance.residual is not None and balance.residual < 1e-4 for balance in one.energy.values())
    assert half.heat and rest.heat and whole.heat
    assert half.heat.put_in + rest.heat.put_in == pytest.approx(whole.heat.put_in, rel=1e-4)


def test_a_run_goes_on_otherwise_from_a_state(tmp_path: Path) -> None:
    """With another drive and another length; from a file that the command line wrote, and goes on from."""
    out, more = str(tmp_path / "a.nc"), str(tmp_path / "b.nc")
    command, still = Command("run", str(EXAMPLES / "finger.toml")), ("--no-figure", "--no-compare")
    command.fine("--set", "run.restart=11 s", "--out", out, *still)
    cool = ("--set", "drive.waveform={kind='constant', level='0 W'}", "--set", "run.duration=30 s")
    command.fine(*cool, "--from", out, "--at", "11 s", "--out", more, *still)
    found, before = read_labelled(more), read_labelled(out)
    assert found["time"].values[0] == 11.0 and found["time"].values[-1] == 30.0
    (place,) = np.flatnonzero(before["time"].values == 11.0)
    assert found["angle"].values[0] == before["angle"].values[place] > 1.0
    assert abs(found["angle"].values[-1]) < 0.02 and found.attrs["heat_residual"] < 1e-4
    assert "nearest is at 11 s" in command.refused("--from", out, "--at", "12 s", "--out", more, "--force", *still)


@pytest.mark.parametrize(
    "how, said",
    [
        ({"at": "1 s"}, "Add the result to `start` from"),
        ({"restart_at": ["26 s"]}, "not within the run, which ends at 25 s"),
        ({"over": {"mechanism.arm": ["6 mm"]}, "initial": {"temperature": "300 K"}}, "needs a start at home"),
        ({"over": {"mechanism.arm": ["6 mm"]}, "restart_at": ["6 s"]}, "keep no states"),
    ],
)
def test_what_cannot_be_kept_or_gone_on_with_is_refused(how: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        run(EXAMPLES / "finger.toml", **how)
    assert said in str(caught.value)


def test_states_of_another_system_and_of_other_times_are_refused() -> None:
    short = run(EXAMPLES / "finger.toml", duration="1 s", samples=3)
    with pytest.raises(InputError, match=r"another system: .* differ from `elements\.0\."):
        run(EXAMPLES / "migaone.toml", start=short)
    with pytest.raises(InputError, match=r"but ends at 1 s"):
        run(EXAMPLES / "finger.toml", duration="1 s", start=short)
    with pytest.raises(InputError, match=r"No state was saved at 0\.4 s; the nearest is at 1 s"):
        run(EXAMPLES / "finger.toml", start=short, at=0.4)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("elements.0.memory.fraction", -0.5, "must be between 0 and 1, but is -0.5"),
        ("elements.0.memory.temperature", -3.0, "must be between 0 and"),
        ("elements.0.memory.stress", math.nan, "must be finite, but is nan"),
        ("mechanism.elongation", math.inf, "must be finite, but is inf"),
        ("", 0.0, "it has 7 numbers, but the system has 8"),
    ],
)
def test_a_damaged_state_is_refused(name: str, value: float, said: str) -> None:
    """Of any law and mechanism the names of phase fractions are the same (`simulate.restarts.RANGES`)."""
    scenario = load(EXAMPLES / "constant_power.toml")
    whole = run(scenario, samples=11)
    (kept,) = whole.restarts
    state = list(kept.passes[-1].state)
    if name:
        state[whole.state_names.index(name)] = value
    else:
        state.pop()
    spoilt = replace(kept, passes=(*kept.passes[:-1], kept.passes[-1]._replace(state=tuple(state))))
    with pytest.raises(InputError, match=said):
        run(scenario, start=replace(whole, restarts=[spoilt]), duration=20.0)


def test_a_damaged_number_in_a_file_is_noticed(tmp_path: Path) -> None:
    """One bit of the state is flipped where the file holds it."""
    path = tmp_path / "out.nc"
    whole = run(EXAMPLES / "constant_power.toml", samples=11)
    whole.save(path)
    raw = bytearray(path.read_bytes())
    raw[raw.index(np.array(whole.restarts[-1].state).tobytes()) + 6] ^= 1
    path.write_bytes(raw)
    with pytest.raises(DataError, match=r"`out\.nc` is damaged: its values differ from their checksums"):
        read_labelled(path)


def test_a_file_with_initial_numbers_is_checked_and_other_commands_refuse_it(tmp_path: Path) -> None:
    text = (EXAMPLES / "finger.toml").read_text() + '[initial]\ntemperature = "150 degC"\n'
    file = tmp_path / "hot.toml"
    file.write_text(text)
    assert "does not keep a martensite fraction of 1" in Command("check", str(file)).refused()
    file.write_text(text.replace('"150 degC"', "300.0"))
    assert "must be a text with a unit" in Command("check", str(file)).refused()
    file.write_text(text.replace("150", "30"))
    Command("check", str(file)).fine()
    out = str(tmp_path / "c")
    assert "needs a start at home" in Command("export", "c", str(file), "--out", out).refused()
    assert "needs a start at home" in Command("sweep", str(file), "--over", "mechanism.arm=6..7 mm:3").refused()
