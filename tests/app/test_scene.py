"""What the page gets to draw a mechanism in space."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench

from martensite.actuators.assembly.lengths import measure_lengths as lengths_of
from martensite.actuators.mechanisms.drawing import KINDS
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.simulate.result import Result
from martensite_app.documents import FOLDER, list_standalone
from martensite_app.views.scene import LEAST, MOST, describe_scene, draw_row

EXAMPLES = Path(__file__).parents[2] / "examples"


def run(name: str, **changes: Any) -> tuple[Scenario, Result]:
    scenario = read_scenario(list_standalone()[name], FOLDER / "scenario.toml", changes or None)
    return scenario, scenario.run(runtime="floats")


@pytest.fixture(scope="module")
def finger() -> tuple[Scenario, Result]:
    return run("finger")


@pytest.fixture(scope="module")
def hand() -> tuple[Scenario, Result]:
    return run("hand", **{"run.duration": "6 s", "run.samples": 201})


def placed(found: dict[str, Any], picture: int) -> dict[str, list[list[float]]]:
    """Points of all shapes at one picture [m], from what the page gets."""
    rest = iter(found["frames"][picture])
    points: dict[str, list[list[float]]] = {}
    for shape in found["shapes"]:
        numbers = iter(shape["still"]) if shape["still"] is not None else rest
        points[shape["name"]] = [[next(numbers) * found["quantum"] for _ in range(3)] for _ in range(shape["count"])]
    assert not list(rest)
    return points


@pytest.mark.parametrize("which", ["finger", "hand"])
def test_pictures_are_the_drawings(which: str, request: pytest.FixtureRequest) -> None:
    scenario, result = request.getfixturevalue(which)
    found = describe_scene(scenario, result)
    lengths, names = lengths_of(scenario.system, result.columns), list(scenario.system.mechanism.outputs())
    for picture in (0, len(found["times"]) // 2, -1):
        row = result.times.index(found["times"][picture])
        points = placed(found, picture)
        for shape in draw_row(scenario.system, result, lengths, names, row):
            for sent, meant in zip(points[shape.name], shape.points, strict=True):
                assert sent == pytest.approx(meant, abs=0.51 * found["quantum"])


@pytest.mark.parametrize("which", ["finger", "hand"])
def test_it_is_small_and_says_what_it_is(which: str, request: pytest.FixtureRequest) -> None:
    scenario, result = request.getfixturevalue(which)
    found = describe_scene(scenario, result)
    assert LEAST <= len(found["times"]) == len(found["frames"]) == len(found["turns"]) <= MOST
    assert (found["times"][0], found["times"][-1]) == (result.times[0], result.times[-1])
    assert len(json.dumps(found)) < 500_000
    assert {shape["kind"] for shape in found["shapes"]} <= set(KINDS)
    assert 0.0 < found["quantum"] <= 1e-5 * math.dist(found["low"], found["high"])
    for port, names in found["ports"].items():
        assert len(names["slack"]) == len(found["times"])
        assert {names["temperature"], names["martensite_fraction"]} <= set(result.columns), port
    still = [shape for shape in found["shapes"] if shape["still"] is not None]
    assert 0 < len(still) < len(found["shapes"])


def test_everything_is_inside_of_the_box(finger: tuple[Scenario, Result]) -> None:
    found = describe_scene(*finger)
    for picture in range(0, len(found["times"]), 20):
        for point in (p for points in placed(found, picture).values() for p in points):
            for low, x, high in zip(found["low"], point, found["high"], strict=True):
                assert low - found["quantum"] <= x <= high + found["quantum"]


def test_a_coil_is_drawn_as_one() -> None:
    found = describe_scene(*run("platform_spring", **{"run.duration": "10 s"}))
    (element,) = [shape for shape in found["shapes"] if shape.get("port")]
    assert element["coils"] == 20
    assert element["coil"] == pytest.approx(6e-3)


def test_slack_is_told() -> None:
    scenario, result = run("antagonistic_wires", **{"mechanism.preload": "0 N"})
    found = describe_scene(scenario, result)
    rows = [result.times.index(time) for time in found["times"]]
    told = [names["slack"] for names in found["ports"].values()]
    assert {0, 1} <= {flag for flags in told for flag in flags}
    for port, flags in zip(found["ports"], told, strict=True):
        assert flags == [int(result[f"{port}.force"][row] < 1e-6) for row in rows]


def test_the_run_brings_it(bench: Bench) -> None:
    text = (EXAMPLES / "constant_power.toml").read_text("utf-8")
    found = bench.call("run", {"text": text})["scene"]
    assert [shape["kind"] for shape in found["shapes"]].count("wire") == 1
    assert found["ports"]["element"]["temperature"] == "temperature"


@pytest.mark.parametrize("name", sorted(set(list_standalone()) - {"finger", "hand", "closed_loop_beam"}))
def test_every_example_has_one(name: str) -> None:
    scenario = read_scenario(list_standalone()[name], FOLDER / "scenario.toml", {"run.duration": "0.2 s"})
    found = describe_scene(scenario, scenario.run(runtime="floats"))
    assert found["shapes"]
    assert all(len(frame) == len(found["frames"][0]) for frame in found["frames"])
