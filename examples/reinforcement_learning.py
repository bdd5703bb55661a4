"""Policies that learn to place a wire, beside a PID controller that is tuned for the same wires.

    python reinforcement_learning.py             all of them, on wires and references that none has seen
    python reinforcement_learning.py --train     finds the last three anew, in half a minute each

The task is `martensite/Wire-v0`: every episode has a wire, surroundings, a supply and a reference of its own. A
policy is linear in the error, its sum, the change of the reading, what the reference will be, and the mean action of
the last second, which tells on which side of the hysteresis the wire is. Its eight weights are found by the
cross-entropy method (Rubinstein (1999)): draw weights, play them all side by side in C, keep the best, draw around
those. Needs `pip install martensite[gymnasium]`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

NAME = "martensite.export.gymnasium:martensite/Wire-v0"
STROKE, PERIOD, LENGTH, DUTY = 4e-3, 0.02, 600, 0.9
POPULATION, PLANTS, BEST, ROUNDS = 64, 16, 10, 50
NUMBERS = {
    "PID, as martensite tune finds it": (1150.93, 35.314, 305.89),
    "PID, gains searched": (3689.3, 196.84, 2296.2),
    "policy without preview": (10.711, 1.6768, -0.39876, 0.0, 0.030619, -0.28657, 0.17096, 0.15192),
    "policy": (8.5295, 1.0047, -0.065604, 4.1176, 0.054509, -0.37912, 0.029462, -0.66485),
}
"""Gains and weights. Those of `martensite tune` are for the scenario of the task with its spreads, and 64 plants."""


class Pid:
    """That of the library per sample: u = Kp e + I + Kd (e - e'), the integral held while the duty is at a bound."""

    start, spread = (7.0, 3.5, 5.7), (1.0, 1.0, 1.0)  # logarithms

    def __init__(self, gains: Any, count: int) -> None:
        """Gains per metre and sample, of shape (3,) or one column for every environment."""
        self.Kp, self.Ki, self.Kd = np.asarray(gains, float)
        self.sum, self.before = np.zeros(count), None

    def __call__(self, observations: Any) -> Any:
        reading, wanted, _ = observations.T.astype(float)
        error = 0.5 * STROKE * (wanted - reading)
        change = 0.0 if self.before is None else error - self.before
        added = self.Ki * error
        duty = self.Kp * error + self.sum + added + self.Kd * change
        self.sum += np.where((duty > DUTY) & (added > 0.0) | (duty < 0.0) & (added < 0.0), 0.0, added)
        self.before = error
        return (2.0 * np.clip(duty / DUTY, 0.0, 1.0) - 1.0)[:, None]


class LinearPolicy:
    """An action from eight numbers, by weights of shape (8,) or one column for every environment."""

    start, spread = (2.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0), (2.0, 2.0, 2.0, 1.0, 0.5, 0.5, 0.5, 1.0)

    def __init__(self, weights: Any, count: int) -> None:
        self.weights = np.asarray(weights, float).reshape(8, -1)
        self.sum, self.change, self.before = np.zeros(count), np.zeros(count), None
        self.action, self.mean = np.full(count, -1.0), np.full(count, -1.0)

    def __call__(self, observations: Any) -> Any:
        reading, wanted, later = observations.T.astype(float)
        error = wanted - reading
        self.change += 0.5 * ((0.0 if self.before is None else reading - self.before) - self.change)
        self.before = reading
        self.mean += PERIOD * (self.action - self.mean)
        seen = (error, self.sum, 10.0 * self.change, later - wanted, wanted, 1.0, self.mean, error * np.abs(error))
        raw = sum(weight * one for weight, one in zip(self.weights, seen, strict=True))
        self.sum += np.where((np.abs(raw) < 1.0) | (raw * error < 0.0), PERIOD * error, 0.0)
        self.action = np.clip(raw, -1.0, 1.0)
        return self.action[:, None]


def make_wires(count: int) -> Any:
    """Wires side by side, which wait at the end of an episode."""
    return gymnasium.make_vec(NAME, num_envs=count, autoreset_mode="Disabled")


def play_episode(policy: Callable[[Any], Any], wires: Any, seed: int | list[int]) -> tuple[Any, float]:
    """Mean reward of a period in every environment, and the rms error of all [m], over one episode."""
    observations, _ = wires.reset(seed=seed)
    total, running, squares = np.zeros(wires.num_envs), np.ones(wires.num_envs, bool), []
    for _ in range(LENGTH):
        observations, reward, terminated, _, info = wires.step(policy(observations))
        total += np.where(running, reward, 0.0)
        running &= ~terminated
        squares.append((info["reference"] - info["output"]) ** 2)
    return total / LENGTH, float(np.sqrt(np.mean(squares)))


def search_numbers(
    kind: type[Pid] | type[LinearPolicy],
    used: Any = 1.0,
    rounds: int = ROUNDS,
    population: int = POPULATION,
    plants: int = PLANTS,
) -> Any:
    """Gains or weights by the cross-entropy method; a weight that is not `used` stays as it is."""
    rng, wires = np.random.default_rng(0), make_wires(population * plants)
    shape: Callable[[Any], Any] = np.exp if kind is Pid else np.asarray
    mean, wide = np.array(kind.start), np.array(kind.spread)
    least = 0.2 * wide
    for k in range(rounds):
        drawn = mean + wide * used * rng.standard_normal((population, mean.size))
        seeds = [1 + plants * k + j for j in range(plants)] * population
        rewards, _ = play_episode(kind(shape(np.repeat(drawn, plants, axis=0).T), len(seeds)), wires, seeds)
        best = drawn[np.argsort(-rewards.reshape(population, plants).mean(axis=1))[:BEST]]
        mean, wide = best.mean(axis=0), np.maximum(best.std(axis=0), least * (1.0 - (k + 1.0) / rounds))
    return shape(mean)


def train_all(rounds: int = ROUNDS) -> dict[str, Any]:
    """All numbers, found anew but for those of `martensite tune`."""
    blind = np.array([1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    tuned, searched, without, whole = NUMBERS
    return {
        tuned: NUMBERS[tuned],
        searched: search_numbers(Pid, rounds=rounds),
        without: search_numbers(LinearPolicy, blind, rounds),
        whole: search_numbers(LinearPolicy, rounds=rounds),
    }


def main(train: bool = False, count: int = 256) -> dict[str, float]:
    """Mean reward of a period of each, on wires that none has seen."""
    wires, found = make_wires(count), {}
    for name, numbers in (train_all() if train else NUMBERS).items():
        kind = Pid if len(numbers) == 3 else LinearPolicy
        rewards, error = play_episode(kind(numbers, count), wires, 1_000_000)
        found[name] = float(rewards.mean())
        print(f"{name:33} reward {found[name]:7.4f} per period, error {1e3 * error:.3f} mm rms")
        if train:
            print("   ", *(f"{one:.5g}," for one in numbers))
    return found


if __name__ == "__main__":
    main(train="--train" in sys.argv)
