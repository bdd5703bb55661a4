"""`tune --method schedule`: gain schedules."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.base.summary import DataTable, Summary
from martensite.cli.options import read_positive
from martensite.cli.progress import show_spinner
from martensite.cli.tune_answer import TuningAnswer, judge_scenario
from martensite.cli.tune_run import draw_both_plants
from martensite.control.loop.parts import Controllers
from martensite.control.margins.linear_loop import LinearLoop
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_points import linearise_case
from martensite.control.margins.margins import compute_margins
from martensite.control.synthesis.gain_schedule import DesignedSchedule, design_gain_schedule
from martensite.control.tuning.judgement import JudgedLoop, judge_loops
from martensite.control.tuning.loop_runs import LoopRuns
from martensite.simulate.drive_waveforms import by_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.cli.commands.tune import TuneOptions
    from martensite.scenario.scenario import Scenario

HEAD = ("branch", "at", "Kp", "Ki [1/s]", "M_s", "gain margin", "phase margin")
SENSITIVITY, POINTS = 1.4, 4


def run_schedule(scenario: Scenario, options: TuneOptions) -> TuningAnswer:
    """Design a gain schedule and compare it with the present loop."""
    if scenario.bench is None:
        raise InputError("The scenario has no [controller] that could be tuned.")
    bench, waves = scenario.bench, by_name(scenario.system, scenario.waveform)
    duration = read_positive("duration", options.duration, "s")
    duration = scenario.duration if duration is None else duration
    _, judged = draw_both_plants(options.spread or [], options.plants, options.seed, scenario, bench)
    with show_spinner("linear systems on both branches"):
        wanted = SENSITIVITY if options.sensitivity is None else options.sensitivity
        schedule = design_gain_schedule(
            bench, duration, drive=options.loop, sensitivity=wanted, count=POINTS, waveforms=waves
        )
        members = {**bench.controllers.members(), schedule.drive: schedule.controller}
        after = bench.with_parts(controllers=Controllers(**members))
        others = {name: float(one.value(0.0)) for name, one in waves.items()}
        loops = linearise_case(LoopCase(after, schedule.drive, schedule.controller, duration, others), POINTS)
        before, tuned = (
            JudgedLoop(LoopRuns(one, duration, drive=schedule.drive, seed=scenario.seed, waveforms=waves), {})
            for one in (bench, after)
        )
        verdict = judge_scenario(scenario, after, judge_loops(before, tuned, judged))

    def draw() -> Figure:
        from martensite.show.figures.margins import plot_margins

        return plot_margins(loops, scenario.title)

    lead = f"# gains scheduled for a largest sensitivity of {wanted:g}\n\n"
    return TuningAnswer(
        verdict, _summarise_schedule(scenario, schedule, loops), lambda: lead + schedule.to_toml(scenario.text), draw
    )


def _summarise_schedule(scenario: Scenario, schedule: DesignedSchedule, loops: list[LinearLoop]) -> Summary:
    margins = [compute_margins(one.loop) for one in loops]
    pairs = list(zip(schedule.points, margins, strict=False))  # the last loop is the dead band
    cells = [
        (
            one.branch,
            write_quantity(one.at, schedule.unit, 3),
            f"{one.Kp:.4g}",
            f"{one.Ki:.4g}",
            f"{has.sensitivity:.3f}",
            f"{has.gain:.3g}",
            f"{np.degrees(has.phase):.0f}°",
        )
        for one, has in pairs
    ]
    rows: list[dict[str, Any]] = [vars(one) | vars(has) | {"sensitivity": has.sensitivity} for one, has in pairs]
    data = {"title": scenario.title, "method": "schedule", "drive": schedule.drive, "points": rows}
    table = DataTable(HEAD, cells, right=tuple(range(1, len(HEAD))))
    return Summary(scenario.title, [table], data)
