"""What the page draws of a mechanism in space, made by its own TypeScript."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from page_runs import PageRuns, draw_row

from martensite.actuators.mechanisms.drawing import KINDS, DrawingShape, DrawingState
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.app.documents import FOLDER, list_standalone
from martensite.app.views.page import describe_page
from martensite.app.views.scene import describe_shapes
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.result import Result

MOST, LEAST = 241, 61


def run(name: str, runtime: str | None = None, **changes: Any) -> tuple[Scenario, Result]:
    scenario = read_scenario(list_standalone()[name], FOLDER / "scenario.toml", changes or None)
    return scenario, scenario.run(runtime=runtime)


def draw(page_runs: PageRuns, *ran: tuple[Scenario, Result]) -> list[dict[str, Any]]:
    return [one["scene"] for one in page_runs.describe(*((*pair, describe_page(*pair)) for pair in ran))]


Drawn = tuple[Scenario, Result, dict[str, Any]]


@pytest.fixture(scope="module")
def drawn(page_runs: PageRuns) -> dict[str, Drawn]:
    ran = {
        "finger": run("finger"),
        "hand": run("hand", **{"run.duration": "6 s", "run.samples": 201}),
        "coil": run("platform_spring", **{"run.duration": "10 s"}),
        "slack": run("antagonistic_wires", **{"mechanism.preload": "0 N"}),
    }
    return {name: (*pair, one) for (name, pair), one in zip(ran.items(), draw(page_runs, *ran.values()), strict=True)}


def placed(found: dict[str, Any], picture: int) -> dict[str, list[list[float]]]:
    """Points of all shapes at one picture [m], from what the page draws."""
    rest = iter(found["frames"][picture])
    points: dict[str, list[list[float]]] = {}
    for shape in found["shapes"]:
        numbers = iter(shape["still"]) if shape["still"] is not None else rest
        points[shape["name"]] = [[next(numbers) * found["quantum"] for _ in range(3)] for _ in range(shape["count"])]
    assert not list(rest)
    return points


@pytest.mark.parametrize("which", ["finger", "hand", "coil", "slack"])
def test_pictures_are_the_drawings(which: str, drawn: dict[str, Drawn]) -> None:
    scenario, result, found = drawn[which]
    for picture in (0, len(found["times"]) // 2, -1):
        row = result.times.tolist().index(found["times"][picture])
        points = placed(found, picture)
        turns = iter(found["turns"][picture])
        for sent, shape in zip(found["shapes"], draw_row(scenario.system, result, row), strict=True):
            assert (sent["name"], sent["kind"], sent.get("port", "")) == (shape.name, shape.kind, shape.port)
            assert sent["size"] == pytest.approx(shape.size, rel=1e-9)
            if shape.kind in ("pulley", "rotor"):
                assert next(turns) == pytest.approx(shape.turn, rel=1e-9)
            for place, meant in zip(points[shape.name], shape.points, strict=True):
                assert place == pytest.approx(meant, abs=0.51 * found["quantum"])


@pytest.mark.parametrize("which", ["finger", "hand"])
def test_it_is_small_and_says_what_it_is(which: str, drawn: dict[str, Drawn]) -> None:
    scenario, result, found = drawn[which]
    assert LEAST <= len(found["times"]) == len(found["frames"]) == len(found["turns"]) <= MOST
    assert (found["times"][0], found["times"][-1]) == (result.times[0], result.times[-1])
    assert len(json.dumps(describe_shapes(scenario.whole, result))) < 120_000
    assert {shape["kind"] for shape in found["shapes"]} <= set(KINDS)
    assert 0.0 < found["quantum"] <= 1e-5 * math.dist(found["low"], found["high"])
    still = [shape for shape in found["shapes"] if shape["still"] is not None]
    assert 0 < len(still) < len(found["shapes"])


def test_everything_is_inside_of_the_box(drawn: dict[str, Drawn]) -> None:
    found = drawn["finger"][2]
    for picture in range(0, len(found["times"]), 20):
        for point in (p for points in placed(found, picture).values() for p in points):
            for low, x, high in zip(found["low"], point, found["high"], strict=True):
                assert low - found["quantum"] <= x <= high + found["quantum"]


def test_the_page_knows_all_kinds() -> None:
    text = (Path(__file__).parents[2] / "web/src/lib/types.ts").read_text("utf-8")
    (union,) = re.findall(r"export type Kind =([^;]+);", text)
    assert re.findall(r'"(\w+)"', union) and set(re.findall(r'"(\w+)"', union)) == set(KINDS)


def test_a_weight_says_its_mass(drawn: dict[str, Drawn]) -> None:
    scenario, _, found = drawn["coil"]
    weight: Any = scenario.system.mechanism
    assert [shape["mass"] for shape in found["shapes"] if shape["kind"] == "weight"] == [weight.mass]


def test_a_coil_is_drawn_as_one(drawn: dict[str, Drawn]) -> None:
    (element,) = [shape for shape in drawn["coil"][2]["shapes"] if shape.get("port")]
    assert element["coils"] == 20
    assert element["coil"] == pytest.approx(6e-3)


def test_slack_is_told(drawn: dict[str, Drawn]) -> None:
    _, result, found = drawn["slack"]
    result = add_step_rows(result)
    rows = [result.times.tolist().index(time) for time in found["times"]]
    told = [names["slack"] for names in found["ports"].values()]
    assert {0, 1} <= {flag for flags in told for flag in flags}
    for port, flags in zip(found["ports"], told, strict=True):
        assert flags == [int(result[f"{port}.force"][row] < 1e-6) for row in rows]


class Valued(AntagonisticPulley):
    """Asks for the value of a number; not registered."""

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        return [DrawingShape("pulley", "object", ((math.cos(reading.outputs["angle"]), 0.0, 0.0),), 1.0)]


def test_a_drawing_that_cannot_be_recorded_is_told() -> None:
    scenario, result = run("antagonistic_wires", **{"run.duration": "0.1 s"})
    own = scenario.system.mechanism
    values = {name: getattr(own, name) for name in own.declarations}
    found = describe_shapes(scenario.system.with_parts(mechanism=Valued(**values)), result)
    assert found["shapes"] == []
    assert "recordable_numbers.xp" in found["sentence"]


@pytest.mark.parametrize("name", sorted(set(list_standalone()) - {"finger", "hand", "closed_loop_beam"}))
def test_every_example_has_one(name: str) -> None:
    scenario, result = run(name, **{"run.duration": "0.2 s"})
    found = describe_shapes(scenario.whole, result)
    assert found["sentence"] == ""
    assert found["shapes"]
