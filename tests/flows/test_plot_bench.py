"""The figure of a bench shows the numbers of its result, each in the panel it belongs to.

Source of truth: the columns of the result, converted by hand.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a
from drawn_texts import check_apart, visible_texts
from matplotlib.figure import Figure

from martensite.base.errors import DataError, InputError
from martensite.control.checks.base import Checks
from martensite.control.checks.reading import Overheat
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.relay import OnOff
from martensite.control.faults.sensor import Stuck
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, FaultTable, MountedSensor, Observers, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.inverse import InverseModel
from martensite.control.sensors.position import IdealSensor, PositionSensor
from martensite.control.supervisors.guard import Guard
from martensite.physics.electrical.switches import PwmVoltage
from martensite.show.figures.bench import plot_bench
from martensite.show.figures.overview import plot_result
from martensite.signals.constant import Constant
from martensite.signals.records import Record
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

PERIOD = 0.1
REFERENCE = Constant(level=3e-3)


def bench(**parts: Any) -> Bench:
    """The benchmark wire behind a switch, with an encoder and PID control, or other parts."""
    pid = Pid(measured="position", reference=REFERENCE, Kp=300.0, Ki=200.0)
    known: dict[str, Any] = {
        "plant": problem_a().with_parts(source=PwmVoltage(supply=5.0)),
        "period": PERIOD,
        "substeps": 2,
        "sensors": Sensors(position=MountedSensor(sensor=PositionSensor(noise=2e-5), delay=0.2)),
        "controllers": Controllers(drive=pid),
    }
    return Bench(**{**known, **parts})


@cache
def guarded() -> Result:
    """A stuck sensor, and a guard that cuts at 60 °C."""
    heat = MountedSensor(sensor=IdealSensor(), of=("temperature",))
    hot = Overheat(reading="heat", limit=333.15, band=5.0)
    made = bench(
        sensors=Sensors(position=MountedSensor(sensor=PositionSensor()), heat=heat),
        supervisor=Guard(checks=Checks(**{"hot": hot}), answer="resume"),
        faults=FaultTable(dead=Stuck(sensor="position", start=0.2)),
    )
    return simulate_bench(made, 6.0, runtime="floats")


@cache
def followed() -> Result:
    return simulate_bench(bench(), 2.0, runtime="floats")


def panels(figure: Figure) -> dict[str, Any]:
    return {axes.get_title(loc="left"): axes for axes in figure.axes}


def line(axes: Any, label: str) -> Any:
    (found,) = [one for one in axes.get_lines() if one.get_label() == label]
    return np.asarray(found.get_ydata())


def test_response_shows_truth_reading_and_reference() -> None:
    result = followed()
    axes = panels(plot_bench(result))["position of the mechanism"]
    assert line(axes, "response") == pytest.approx(1e3 * np.array(result["position"]))
    assert line(axes, "measured") == pytest.approx(1e3 * np.array(result["measured.position"]))
    assert line(axes, "reference") == pytest.approx([3.0] * len(result.times))
    assert axes.get_ylabel() == "$x$ [mm]"


def test_error_is_that_of_the_truth_and_its_size_is_written() -> None:
    result = followed()
    axes = panels(plot_bench(result))["reference less response"]
    error = 3.0 - 1e3 * np.array(result["position"])
    size = f"rms {np.sqrt(np.mean(error**2)):.3g} mm"
    assert line(axes, size) == pytest.approx(error)


def test_signal_shows_what_is_wanted_and_what_the_guard_lets_pass() -> None:
    result = guarded()
    axes = panels(plot_bench(result))["signal"]
    wanted, applied = line(axes, "wanted"), line(axes, "applied")
    assert wanted == pytest.approx(np.array(result["wanted"]))
    assert applied == pytest.approx(np.array(result["drive"]))
    cut = np.array(result["alarm"]) > 0.5
    assert (wanted != applied).tolist() == cut.tolist()


def test_alarms_are_shaded_while_they_last() -> None:
    result = guarded()
    raised = np.array(result["alarm"]) > 0.5
    assert 0 < raised.sum() < len(raised)
    begins = [t for t, a, b in zip(result.times[1:], raised, raised[1:], strict=False) if b and not a]
    for axes in plot_bench(result).axes:
        shades: list[Any] = list(axes.patches)
        spans = sorted(shade.get_x() for shade in shades)
        assert spans == pytest.approx(begins)
    assert all(not axes.patches for axes in plot_bench(followed()).axes)


def test_temperatures_are_in_degrees_celsius() -> None:
    result = followed()
    (drawn,) = panels(plot_bench(result))["wire temperature"].get_lines()
    assert np.asarray(drawn.get_ydata()) == pytest.approx(np.array(result["temperature"]) - 273.15)


def test_estimates_stand_beside_the_truth() -> None:
    plant = bench().plant
    meter = MountedSensor(sensor=IdealSensor(), of=("resistance",))
    observer = InverseModel(model=plant, wanted=("temperature", "position"))
    pid = Pid(measured="estimated.position", reference=REFERENCE, Kp=300.0)
    made = bench(
        sensors=Sensors(resistance=meter), observers=Observers(model=observer), controllers=Controllers(drive=pid)
    )
    result = simulate_bench(made, 1.0, runtime="floats")
    found = panels(plot_bench(result))
    known = 1e3 * np.array(result["estimated.position"])
    assert line(found["position of the mechanism"], "estimated") == pytest.approx(known)
    warm = np.array(result["estimated.temperature"]) - 273.15
    assert line(found["wire temperature"], "estimated") == pytest.approx(warm)


def test_controller_outside_of_the_bench_is_shown_with_its_reference() -> None:
    outer = OnOff(measured="position", reference=REFERENCE, high=0.8)
    made = bench(controllers=Controllers())
    result = simulate_bench(made, 1.0, outside={"drive": outer})
    axes = panels(plot_bench(result, outside={"drive": outer}))["position of the mechanism"]
    assert line(axes, "reference") == pytest.approx([3.0] * len(result.times))
    signal = panels(plot_bench(result, outside={"drive": outer}))["signal"]
    assert line(signal, "wanted") == pytest.approx(np.array(result["wanted"]))
    bare = replace(result, columns={n: c for n, c in result.columns.items() if n in made.outputs()})
    again = panels(plot_bench(bare, outside={"drive": outer}))["position of the mechanism"]
    assert line(again, "reference") == pytest.approx([3.0] * len(result.times))
    lone = panels(plot_bench(result))
    assert "reference less response" not in lone
    assert "measured" in [one.get_label() for one in lone["position of the mechanism"].get_lines()]


def test_record_is_drawn_over_the_truth() -> None:
    result = followed()
    columns = {"time": [0.0, 1.0, 2.0], "position": [0.0, 1e-3, 2e-3]}
    record = Record("bench", columns, {"time": "s", "position": "m"})
    axes = panels(plot_bench(result, [record]))["position of the mechanism"]
    drawn = [np.asarray(one.get_ydata()) for one in axes.get_lines() if len(one.get_ydata()) == 3]
    assert drawn[0] == pytest.approx([0.0, 1.0, 2.0])
    with pytest.raises(DataError, match="no column to compare"):
        plot_bench(result, [Record("empty", {"time": [0.0]}, {"time": "s"})])


def test_standard_figure_of_a_bench_is_this_one() -> None:
    titles = list(panels(plot_result(followed())))
    assert titles == list(panels(plot_bench(followed())))
    assert titles[0] == "position of the mechanism"


def test_texts_do_not_cover_one_another() -> None:
    figure = plot_bench(guarded(), title="A stuck sensor, and a guard")
    figure.draw_without_rendering()
    check_apart(figure, visible_texts(figure))


def test_result_without_a_bench_is_refused() -> None:
    plain = simulate(problem_a(), Constant(level=1.0), 0.2, step=0.1)
    with pytest.raises(InputError, match="This figure needs a bench"):
        plot_bench(plain)
