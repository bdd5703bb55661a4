"""Batches on several devices of JAX: the same numbers as on one, in order; bounds are kept."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from builders import problem_a

import martensite as ms
from martensite.base.errors import ParameterError
from martensite.simulate.arrays import AHEAD, WIDE_CHUNK, chunk_for, devices_of, march_chunks
from martensite.simulate.batch import simulate_batch

TWICE: Any = 2.0
"""Stands for the steps of a march that only multiplies."""
ON_TWO = """
import hashlib, json
from builders import problem_a
import martensite as ms
from martensite.simulate.batch import simulate_batch
from martensite.simulate.arrays import devices_of

def said(devices):
    over = {"h0": [80.0, 90.0, 100.0, 110.0, 120.0]}
    found = simulate_batch(
        problem_a(), ms.signals.Triangle(high=2.5, frequency=0.1), 2.0, over,
        step=0.02, samples=21, chunk=2, devices=devices,
    )
    return hashlib.sha256(found.columns["position"].tobytes()).hexdigest()

print(json.dumps({"devices": len(devices_of()), "one": said(1), "two": said(2), "all": said(None)}))
"""


def test_two_devices_give_the_same_bits_as_one() -> None:
    flags = "--xla_force_host_platform_device_count=2"
    paths = os.pathsep.join(path for path in sys.path if path)
    done = subprocess.run(
        [sys.executable, "-c", ON_TWO],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "XLA_FLAGS": flags, "PYTHONPATH": paths},
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["devices"] == 2
    assert said["one"] == said["two"] == said["all"]


def test_more_devices_than_there_are_are_refused() -> None:
    there = len(devices_of())
    for count in (0, there + 1):
        with pytest.raises(ParameterError, match=f"on {count} devices, but JAX has {there}"):
            devices_of(count)
    wave = ms.Step(high=2.5, at=1.0)
    with pytest.raises(ParameterError, match="devices"):
        simulate_batch(problem_a(), wave, 2.0, {"h0": [90.0]}, step=0.1, devices=there + 1, runtime="jax")


def test_few_chunks_are_under_way_and_results_keep_their_order() -> None:
    made: list[int] = []

    def chunks():
        for k in range(9):
            made.append(k)
            yield [np.full(3, float(k))]

    devices = devices_of(1)
    doubled: Any = march_chunks(lambda values, plan: values[0] * plan, chunks(), TWICE, devices)
    first: list[float] = []
    for rows in doubled:
        first.append(float(rows[0]))
        assert len(made) <= len(first) + AHEAD * len(devices)
    assert first == [2.0 * k for k in range(9)]


def test_chunks_suit_the_device() -> None:
    class Device:
        def __init__(self, platform: str) -> None:
            self.platform = platform

    assert chunk_for([Device("cpu")]) == 256
    assert chunk_for([Device("gpu")]) == WIDE_CHUNK
