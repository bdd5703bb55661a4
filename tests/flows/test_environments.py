"""The environments that come with the package: by name, drawn, and with rewards that burning loses.

Sources of truth: Gymnasium's checker and its own vector of environments, the library's PID controller in a run, and
the order of three policies that anybody can rank: full power until the wire is too hot, nothing at all, and a PI law.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from runpy import run_path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

from martensite.base.errors import InputError
from martensite.control.controllers.pid import Pid
from martensite.control.loop.run import reference_waveforms
from martensite.export.gymnasium import SmaEnv
from martensite.export.gymnasium_names import NAMES
from martensite.export.gymnasium_vector import SmaVectorEnv
from martensite.export.packaged_tasks import TASKS, load_bench
from martensite.signals.constant import Constant
from martensite.signals.staircase import Staircase
from martensite.simulate.api import simulate

ROOT = Path(__file__).parents[2]
EXAMPLE = run_path(str(ROOT / "examples" / "reinforcement_learning.py"))
CLAIMED = {
    "PID, as martensite tune finds it": -0.1011,
    "PID, gains searched": -0.0863,
    "policy without preview": -0.0883,
    "policy": -0.0711,
}
"""Mean reward of a period, as the docs say."""
HALF = 0.5 * np.sqrt(3.0)
DRIVES: dict[str, Any] = {
    "finger": np.eye(1),
    "hand": np.kron(np.eye(6), [[1.0], [-1.0]]),
    "platform": np.array([[1.0, 0.0], [-0.5, HALF], [-0.5, -HALF]]),
    "wire": np.eye(1),
}
"""What every drive adds to every output, in sign."""


def test_gymnasium_finds_them_by_their_names() -> None:
    """In a process of its own: by a name that says what to import, though the package is known; and after Gymnasium."""
    program = (
        "import sys, martensite.export, gymnasium\n"
        "assert not any('martensite' in n for n in gymnasium.registry)\n"
        "print(gymnasium.make('martensite.export.gymnasium:martensite/Wire-v0').action_space.shape)\n"
        "gymnasium.registry.clear()\n"
        "del sys.modules['martensite.export']\n"
        "import martensite.export\n"
        "print(sorted(n for n in gymnasium.registry if 'martensite' in n))\n"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)
    names = [f"martensite/{name}-v0" for name in ("Bench", *NAMES)]
    assert done.stdout.splitlines() == ["(1,)", str(names)], done.stderr


@pytest.mark.parametrize("name", NAMES)
def test_they_pass_the_checker_are_drawn_and_go_in_lanes(name: str) -> None:
    made: Any = gymnasium.make(f"martensite/{name}-v0", render_mode="rgb_array")
    check_env(made.unwrapped)
    made.reset(seed=1)
    before = np.asarray(made.render()).astype(int)
    for _ in range(30):
        made.step(np.ones(made.action_space.shape, np.float32))
    after = np.asarray(made.render()).astype(int)
    assert before.shape == after.shape and before.std() > 10.0
    assert np.abs(after - before)[: before.shape[0] // 2].max() > 30  # the wires are red, and pull
    many: Any = gymnasium.make_vec(f"martensite/{name}-v0", num_envs=2, render_mode="rgb_array")
    assert isinstance(many, SmaVectorEnv)
    alone = SyncVectorEnv([lambda: gymnasium.make(f"martensite/{name}-v0")] * 2)
    seen = [one.reset(seed=3)[0] for one in (many, alone)]
    action = np.full(many.action_space.shape, 0.2, np.float32)
    for _ in range(5):
        seen = [one.step(action)[0] for one in (many, alone)]
    np.testing.assert_allclose(seen[0], seen[1], rtol=1e-12, atol=1e-7)
    assert [np.shape(one) for one in many.render() or ()] == [before.shape] * 2


class Pi:
    """A PI law on scaled readings, for every output, by the drives that move it."""

    def __init__(self, drives: Any) -> None:
        self.drives, self.sum = drives, 0.0

    def __call__(self, seen: Any) -> Any:
        outputs = self.drives.shape[1]
        error = seen[:, outputs : 2 * outputs] - seen[:, :outputs]
        self.sum = np.clip(self.sum + 0.01 * error, -0.5, 0.5)
        return np.clip((2.0 * error + self.sum) @ self.drives.T - 0.4, -1.0, 1.0)


def score(envs: Any, policy: Any) -> Any:
    """Sum of rewards of the first episode of every environment, and where a limit ended it."""
    seen, _ = envs.reset(seed=5)
    total, running, burnt = np.zeros(envs.num_envs), np.ones(envs.num_envs, bool), np.zeros(envs.num_envs, bool)
    while running.any():
        seen, reward, terminated, truncated, _ = envs.step(policy(seen))
        total += np.where(running, reward, 0.0)
        burnt |= running & terminated
        running &= ~(terminated | truncated)
    return total, burnt


@pytest.mark.parametrize(("name", "low"), [("Platform", True), ("Wire", True), *((name, False) for name in NAMES)])
def test_burning_the_wire_never_pays(name: str, low: bool) -> None:
    """Not where the limit is so low that the PI exceeds it too, and not in the middle of an episode."""
    drives, changes = DRIVES[name.lower()], {"temperature_limit": 335.0} if low else {}
    envs = SmaVectorEnv(name.lower(), changes, 4, autoreset_mode="Disabled")
    size = envs.action_space.shape
    full, burnt = score(envs, lambda _: np.ones(size))
    idle, _ = score(envs, lambda _: -np.ones(size))
    held, lost = score(envs, Pi(drives))
    length = round(TASKS[name.lower()].duration / load_bench(name.lower()).period)
    assert burnt.all() and np.all(full < -length) and np.all(idle >= -length)
    assert np.all(full <= held) and full.mean() < held.mean()
    assert np.all(held[lost] < idle[lost])  # the PI of some hands burns a wire as well
    if not low:
        assert not lost.all() and held[~lost].mean() > idle[~lost].mean()
    begun = iter(range(length))
    late, burnt = score(envs, lambda _: np.full(size, 1.0 if next(begun) > length // 2 else -1.0))
    assert burnt.any() and np.all(late[burnt] < -length)


def test_nobody_gains_by_burning_a_wire_that_has_gone_too_far() -> None:
    """From beyond the range, where every period costs most: heating on must lose to idling from 6 K below the limit."""
    envs, length = SmaVectorEnv("wire", {}, 4, autoreset_mode="Disabled"), 600
    limit = min(envs._episodes.temperature_limits) - 6.0
    for begin in (100, 250):
        sums, burnt = np.zeros((2, 4)), np.zeros((2, 4), bool)
        for careful in (0, 1):
            envs.reset(seed=5)
            cut = np.zeros(4, bool)
            for k in range(length):
                action = np.where(cut | (k < begin), -1.0, 1.0)[:, None]
                _, reward, over, _, info = envs.step(action)
                sums[careful] += np.where(burnt[careful], 0.0, reward)
                burnt[careful] |= over
                cut |= (info["hottest"] > limit) & bool(careful)
        assert burnt[0].any() and not burnt[1].any()
        assert np.all(sums[0, burnt[0]] < sums[1, burnt[0]] - 1.0)


def test_a_task_is_changed_by_its_fields() -> None:
    made = gymnasium.make("martensite/Wire-v0", task={"duration": 0.1, "preview": ()})
    made.reset(seed=0)
    assert [made.step(np.zeros(1, np.float32))[3] for _ in range(5)] == [False] * 4 + [True]
    for changes, said in (({"duraton": 1.0}, "duration"), ({"output": "positon"}, "position")):
        with pytest.raises(InputError, match=said):
            SmaEnv("wire", changes)
    with pytest.raises(InputError, match="wire"):
        SmaEnv("wir")
    with pytest.raises(InputError, match="needs a `task`"):
        SmaEnv(load_bench("wire"))
    with pytest.raises(InputError, match="rgb_array"):
        SmaEnv("wire", render_mode="human")


def test_outputs_have_references_of_their_own() -> None:
    env = SmaEnv("platform", {"spreads": {}})
    level = {"beta": Constant(level=0.05)}
    seen, told = env.reset(seed=0, options={"reference": level})
    assert told["reference.beta"] == 0.05 != told["reference.alpha"]
    low, high = TASKS["platform"].low, TASKS["platform"].high
    wanted = 2.0 * (np.array([told["reference.alpha"], 0.05]) - low) / (high - low) - 1.0
    np.testing.assert_allclose(seen[2:4], wanted, atol=1e-6)
    with pytest.raises(InputError, match="beta"):
        env.reset(options={"reference": {"bet": Constant(level=0.0)}})


def test_the_pid_of_the_example_is_that_of_the_library() -> None:
    gains = EXAMPLE["NUMBERS"]["PID, as martensite tune finds it"]
    steps = Staircase(first=1e-3, increment=1.5e-3, hold=1.0, count=2)
    numbers: dict[str, Any] = dict(zip(("Kp", "Ki", "Kd"), gains, strict=True))
    pid = Pid(measured="position", reference=steps, gains_are="per-sample", **numbers)
    pid = pid.with_values({"law.high": 0.9})
    bench = load_bench("wire").with_values({"sensors.position.sensor.noise": 0.0})
    loop = bench.with_parts(controllers=type(bench.controllers)(drive=pid))
    run = simulate(loop, reference_waveforms(loop), 2.0, samples=101, runtime="c")
    env = SmaEnv(bench, TASKS["wire"])
    nominal = {path: bench.value_of(path) for path in ("plant.element.diameter", "plant.environment.temperature")}
    nominal |= {"plant.source.supply": bench.value_of("plant.source.supply")}
    law, reached = EXAMPLE["Pid"](gains, 1), [0.0]
    seen, _ = env.reset(seed=0, options={"reference": steps, "values": nominal})
    for _ in range(100):
        seen, *_, told = env.step(law(seen[None])[0])
        reached.append(told["output"])
    assert max(reached) > 2e-3
    np.testing.assert_allclose(reached, run["position"], atol=0.05 * 2.5e-3)


def test_who_wins_is_as_the_docs_say(capsys: pytest.CaptureFixture[str]) -> None:
    found = EXAMPLE["main"](count=64)  # of 256 for the docs
    assert found == pytest.approx(CLAIMED, abs=0.008)
    assert sorted(found, key=lambda name: -found[name])[::3] == ["policy", "PID, as martensite tune finds it"]
    page = (ROOT / "docs" / "howto" / "reinforcement-learning.md").read_text()
    for reward in CLAIMED.values():
        assert f"{reward:.3f}".replace("-", "−") in page
    assert len(capsys.readouterr().out.splitlines()) == len(CLAIMED)


def test_training_finds_a_policy_that_is_better_than_none() -> None:
    search, kind = EXAMPLE["search_numbers"], EXAMPLE["LinearPolicy"]
    wires = EXAMPLE["make_wires"](32)
    scores = [
        EXAMPLE["play_episode"](kind(w, 32), wires, 7)[0].mean()
        for w in (np.zeros(8), search(kind, rounds=3, population=16, plants=2))
    ]
    assert scores[1] > scores[0] + 0.2
