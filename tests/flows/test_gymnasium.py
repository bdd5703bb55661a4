"""Environments for learners: Gymnasium's own checker, and one environment against many.

Source of truth: `simulate` of the same bench under the same signals, the environments of one
lane in Gymnasium's own vector of them, and rewards by hand.
"""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from tuning_cases import wire_bench

from martensite.base.errors import InputError, ParameterError
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.export.gymnasium import SmaEnv
from martensite.export.gymnasium_vector import SmaVectorEnv
from martensite.export.learning_task import LearningTask
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate

PERIOD = 0.05
SPREADS = {"element.diameter": 0.03, "environment.temperature": 3.0}
TASK = LearningTask(output="position", low=0.0, high=5e-3, duration=1.0, preview=(0.1, 0.5), spreads=SPREADS)
PLAIN = dataclasses.replace(TASK, spreads={}, preview=())


@pytest.fixture(scope="module")
def bench() -> Bench:
    return wire_bench().with_parts(controllers=Controllers())


def actions(steps: int, count: int = 1, seed: int = 0) -> Any:
    drawn = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, count, 1))
    return drawn.astype(np.float32)


def roll(env: SmaEnv, given: Any, seed: int = 1, **options: Any) -> list[Any]:
    env.reset(seed=seed, options=options)
    return [env.step(action) for action in given]


def test_it_is_an_environment_by_its_checker(bench: Bench) -> None:
    made = gymnasium.make("martensite.export.gymnasium:martensite/Bench-v0", bench=bench, task=TASK)
    assert isinstance(made.unwrapped, SmaEnv)
    check_env(made.unwrapped)


def test_the_checker_finds_an_observation_out_of_bounds(bench: Bench) -> None:
    class Wrong(SmaEnv):
        def reset(self, **given: Any) -> Any:
            seen, info = super().reset(**given)
            return seen + np.float32(5.0), info

    with pytest.raises(AssertionError, match="observation"):
        check_env(Wrong(bench, PLAIN), skip_render_check=True)


def test_it_goes_the_way_of_a_run(bench: Bench) -> None:
    task = dataclasses.replace(PLAIN, duration=3.0)
    quiet = bench.with_values({"sensors.position.sensor.noise": 0.0})
    signals = 0.85 + 0.15 * actions(60)[:, 0, 0].astype(float)
    level = Constant(level=2e-3)
    found = roll(SmaEnv(quiet, task), 2.0 * signals[:, None] - 1.0, reference=level)
    wave = Held(values=(*signals.tolist(), 0.0), frequency=1.0 / PERIOD)
    run = simulate(quiet, {"drive": wave}, 3.0, samples=61, runtime="c")
    seen, rewards, terminated, truncated, info = (list(one) for one in zip(*found, strict=True))
    positions = [one["output"] for one in info]
    assert max(positions) > 1e-4
    np.testing.assert_allclose(positions, run["position"][1:], rtol=1e-6, atol=1e-9)
    by_hand = [-min(abs(2e-3 - y) / 5e-3, 1.0) for y in positions]  # an error counts as the range at most
    np.testing.assert_allclose(rewards, by_hand, rtol=1e-12)
    readings = np.array(run["measured.position"][1:])
    expected = np.stack([2.0 * readings / 5e-3 - 1.0, np.full(60, 2 * 0.4 - 1.0)], axis=1)
    np.testing.assert_allclose(np.array(seen), np.clip(expected, -2.0, 2.0), atol=1e-5)
    assert truncated == [False] * 59 + [True]
    assert not any(terminated)


def test_a_preview_is_what_comes_and_a_seed_says_all(bench: Bench) -> None:
    env = SmaEnv(bench, TASK)
    one, again, other = (roll(env, actions(20)[:, 0], seed) for seed in (1, 1, 2))
    seen = np.array([step[0] for step in one])
    np.testing.assert_array_equal(seen[2:, 1], seen[:-2, 2])
    np.testing.assert_array_equal(seen[10:, 1], seen[:-10, 3])
    np.testing.assert_array_equal(seen, [step[0] for step in again])
    assert np.abs(seen - [step[0] for step in other]).max() > 0.1


@pytest.mark.parametrize("kind", ["steps", "sines"])
def test_references_stay_in_their_range_and_fill_it(kind: str) -> None:
    task = dataclasses.replace(PLAIN, references=(kind,), duration=10.0)
    rng, times = np.random.default_rng(0), np.arange(0.0, 10.0, 0.01)
    drawn = np.array([task.reference(rng, times) for _ in range(200)])
    assert drawn.min() >= 0.0 and drawn.max() <= 5e-3
    assert drawn.min() < 5e-4 and drawn.max() > 4.5e-3
    moving = np.mean(np.diff(drawn, axis=1) != 0.0)
    assert moving > 0.9 if kind == "sines" else moving < 0.02


def test_plants_are_drawn_within_their_spreads(bench: Bench) -> None:
    count, nominal = 40, bench.value_of("plant.environment.temperature")
    envs = SmaVectorEnv(bench, TASK, count)
    _, info = envs.reset(seed=0)
    apart = info["hottest"] - nominal
    assert np.abs(apart).max() <= 3.0
    assert apart.std() == pytest.approx(3.0 / np.sqrt(3.0), rel=0.3)
    _, info = SmaEnv(bench, PLAIN).reset(options={"values": {"plant.environment.temperature": 301}})
    assert info["hottest"] == pytest.approx(301.0)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_many_go_as_each_of_them_alone(bench: Bench, mode: Any) -> None:
    """Longer than an episode, with limits that some exceed: every number and key is the same."""
    task = dataclasses.replace(TASK, temperature_limit=328.0)
    ours = SmaVectorEnv(bench, task, 3, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: SmaEnv(bench, task)] * 3, autoreset_mode=mode)
    for one, other in zip(ours.reset(seed=3), theirs.reset(seed=3), strict=True):
        same(one, other)
    ended, offsets = np.zeros(2), np.array([[-1.0], [0.0], [0.5]], np.float32)
    for given in np.clip(actions(45, 3) + offsets, -1.0, 1.0):
        mine, yours = ours.step(given), theirs.step(given)
        ended += np.sum(mine[2]), np.sum(mine[3])
        for one, other in zip(mine, yours, strict=True):
            same(one, other)
    assert ended.min() >= 1


def same(one: Any, other: Any) -> None:
    """Raise unless arrays, or dictionaries of them, are the same."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            same(one[name], other[name])
    elif np.asarray(one).dtype == object:
        for a, b in zip(one, other, strict=True):
            assert (a is None) == (b is None)
            if a is not None:
                same(a, b)
    else:
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


def test_some_are_reset_by_a_mask_and_the_others_go_on(bench: Bench) -> None:
    envs = SmaVectorEnv(bench, PLAIN, 3, autoreset_mode="Disabled")
    seen = envs.reset(seed=0)[0]
    for given in actions(5, 3):
        seen = envs.step(given)[0]
    mask = np.array([False, True, False])
    now, _ = envs.reset(seed=[None, 1, None], options={"reset_mask": mask})
    first, _ = SmaEnv(bench, PLAIN).reset(seed=1)
    np.testing.assert_array_equal(now[~mask], seen[~mask])
    np.testing.assert_array_equal(now[1], first)


def test_a_limit_ends_an_episode_and_costs(bench: Bench) -> None:
    full = np.ones((20, 1), np.float32)
    task = dataclasses.replace(PLAIN, temperature_limit=320.0, energy_weight=0.5, penalty=7.0)
    level = Constant(level=0.0)
    found = roll(SmaEnv(bench, task), full, reference=level)
    ended = [step[2] for step in found]
    assert ended == [step[4]["hottest"] > 320.0 for step in found]
    assert 0 < ended.index(True) < 19
    for k, (_, reward, over, _, info) in enumerate(found):
        by_hand = -info["output"] / 5e-3 - 0.5 * PERIOD * info["power"] - (7.0 + 19 - k) * over
        assert reward == pytest.approx(by_hand, rel=1e-12)


def test_a_bench_keeps_the_controllers_it_has(bench: Bench) -> None:
    with pytest.raises(InputError, match="Every drive of this bench has a controller"):
        SmaEnv(wire_bench(), PLAIN)


WRONG: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"output": "positon"}, InputError, "position"),
    ({"signals": {"drve": (0.0, 1.0)}}, InputError, "free drive"),
    ({"signals": {"drive": (1.0, 1.0)}}, InputError, "range of `drive`"),
    ({"observed": {"posit": (0.0, 1.0)}}, InputError, "No reading named `posit`"),
    ({"spreads": {"diametr": 0.1}}, ParameterError, "diametr"),
    ({"spreads": {"element.diameter": 2.0}}, ParameterError, "diameter"),
    ({"spreads": {"element.diameter": -0.1}}, ParameterError, "at least 0"),
]


@pytest.mark.parametrize(("changes", "error", "said"), WRONG)
def test_what_does_not_fit_is_said(bench: Bench, changes: dict[str, Any], error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        SmaEnv(bench, dataclasses.replace(PLAIN, **changes))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"low": 1.0, "high": 0.0}, "needs a range"),
        ({"duration": 0.0}, "above 0 s"),
        ({"references": ("step",)}, "steps"),
        ({"references": ()}, "kind of reference"),
        ({"preview": (-0.1,)}, "ahead"),
    ],
)
def test_tasks_that_are_none(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        dataclasses.replace(PLAIN, **changes)


def test_options_are_known_and_seeds_are_as_many(bench: Bench) -> None:
    with pytest.raises(InputError, match="No option named `refrence`"):
        SmaEnv(bench, PLAIN).reset(options={"refrence": Sine(high=1.0, frequency=1.0)})
    with pytest.raises(InputError, match="3 environments, but 2 seeds"):
        SmaVectorEnv(bench, PLAIN, 3).reset(seed=[1, 2])
    with pytest.raises(InputError, match="NextStep"):
        SmaVectorEnv(bench, PLAIN, 3, autoreset_mode="NextStp")
    with pytest.raises(InputError, match="an environment at least"):
        SmaVectorEnv(bench, PLAIN, 0)


def test_an_action_that_is_no_number_is_refused(bench: Bench) -> None:
    for env, action in ((SmaEnv(bench, PLAIN), [np.nan]), (SmaVectorEnv(bench, PLAIN, 2), [[0.0], [np.nan]])):
        env.reset(seed=0)
        with pytest.raises(InputError, match="from -1 to 1, but holds NaN"):
            env.step(np.array(action))


def test_without_gymnasium_it_says_what_to_install(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(InputError, match=r"pip install .*\[gymnasium\]'"):
        SmaEnv(bench, PLAIN)
