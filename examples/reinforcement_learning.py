"""A wire as an environment for learners: a random policy, and a PI policy written by hand.

    python reinforcement_learning.py

The bench is that of closed_loop.toml without its controller. All environments run side by side in
C, each with a wire, surroundings and a reference of its own. What a learner finds should beat the
second policy. Needs `pip install martensite[gymnasium]`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from martensite import load
from martensite.control import Controllers
from martensite.export import LearningTask as Task
from martensite.export import SmaVectorEnv

HERE = Path(__file__).parent
STROKE, PERIOD = 4e-3, 0.02
TASK = Task(
    output="position",
    low=0.0,
    high=STROKE,
    duration=12.0,
    preview=(0.5,),
    signals={"drive": (0.0, 0.9)},
    temperature_limit=420.0,
    energy_weight=0.01,
    spreads={"element.diameter": 0.03, "environment.temperature": 5.0, "source.supply": 0.05},
)


class Random:
    """Any duty, drawn anew in every period."""

    def __init__(self, count: int) -> None:
        self.rng, self.count = np.random.default_rng(0), count

    def __call__(self, observations: Any) -> Any:
        return self.rng.uniform(-1.0, 1.0, (self.count, 1))


class Pi:
    """Duty from the error and its sum; the sum stands still while the duty is at a bound."""

    Kp, Ki = 150.0, 75.0  # duty per metre, and per metre and second

    def __init__(self, count: int) -> None:
        self.sum = np.zeros(count)

    def __call__(self, observations: Any) -> Any:
        reading, wanted = observations[:, 0], observations[:, 1]
        error = 0.5 * STROKE * (wanted - reading)
        duty = self.Kp * error + self.Ki * self.sum
        free = (duty > 0.0) & (duty < 0.9) | (duty * error < 0.0)
        self.sum += np.where(free, error * PERIOD, 0.0)
        return (2.0 * np.clip(duty / 0.9, 0.0, 1.0) - 1.0)[:, None]


def environments(count: int) -> SmaVectorEnv:
    """Wires side by side."""
    bench = load(HERE / "closed_loop.toml").whole.with_parts(controllers=Controllers())
    return SmaVectorEnv(bench, TASK, count)


def play(policy: Callable[[Any], Any], envs: SmaVectorEnv, seed: int = 0) -> tuple[float, float]:
    """Mean reward of a period, and rms error [m], over one episode of every environment."""
    rewards: list[Any] = []
    errors: list[Any] = []
    observations, _ = envs.reset(seed=seed)
    for _ in range(round(TASK.duration / PERIOD)):
        observations, reward, *_, info = envs.step(policy(observations))
        rewards.append(reward)
        errors.append(info["reference"] - info["output"])
    return float(np.mean(rewards)), float(np.sqrt(np.mean(np.square(errors))))


def main(count: int = 16) -> None:
    envs = environments(count)
    for policy in (Random(count), Pi(count)):
        reward, error = play(policy, envs)
        name = type(policy).__name__
        print(f"{name:8} reward {reward:7.3f} per period, error {1e3 * error:.2f} mm rms")


if __name__ == "__main__":
    main()
