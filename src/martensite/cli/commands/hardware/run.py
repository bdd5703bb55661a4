"""`hardware ports`, `log`, `run` and `hil`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.board_options import (
    Armed,
    BoardSource,
    LogOptions,
    answer_log,
    open_session,
    save_interrupted,
    show_log,
)
from martensite.cli.commands.hardware import hardware
from martensite.cli.options import Force, Json, Text, read_positive, spread_options
from martensite.cli.outputs import Outputs
from martensite.cli.progress import open_bar

if TYPE_CHECKING:
    from martensite.boards.session import Session


@hardware.command("ports")
def ports(json: Json = False) -> None:
    """List the serial ports."""
    from serial.tools.list_ports import comports

    from martensite.show.terminal import print_summary

    entries = [[one.device, one.description or ""] for one in comports()]
    block: Block = DataTable(("port", "what it is"), entries) if entries else Sentence("No serial port is there.")
    print_summary(Summary("", [block], {"ports": [one[0] for one in entries]}), json)


@hardware.command("log")
@spread_options
def log(
    source: BoardSource,
    options: LogOptions,
    duration: Annotated[str, Option(help='Duration of the log, e.g. "10 s".')] = "5 s",
) -> None:
    """Log the measurements of a disarmed board."""
    options.check_file()
    seconds = read_positive("duration", duration, "s")
    with open_session(source) as session:
        with save_interrupted(session, options), show_log("logging") as watch:
            board_log = session.listen(seconds, watch)
        answer_log(session, board_log, options)


@hardware.command("run")
@spread_options
def run(
    source: BoardSource,
    options: LogOptions,
    arm: Armed = None,
    duration: Annotated[
        Text, Option(help='Duration of the run, e.g. "10 s" [default: the duration of the scenario].')
    ] = None,
    duty: Annotated[
        Text, Option(metavar="TIME:DUTY,…", help='Duty cycle over time instead of the loop, e.g. "2 s:0.4, 5 s:0".')
    ] = None,
) -> None:
    """Run the control loop or duty cycles on the board, with a log.

    Without `--arm ARM` the command is a dry run: it queries the board, heats nothing and reports the plan.
    """
    from martensite.boards.session import read_levels

    options.check_file()
    levels = read_levels(duty) if duty is not None else []
    with open_session(source) as session:
        scenario = session.scenario
        whole = sum(t for t, _ in levels) if levels else scenario.duration
        seconds = whole if duration is None else read_positive("duration", duration, "s")
        if arm is None:
            with show_log("listening") as watch:
                board_log = session.listen(0.5, watch)
            answer_log(session, board_log, options, _describe_dry_run(session, seconds, levels))
            return
        with save_interrupted(session, options), show_log("running") as watch:
            if levels:
                board_log = session.play(levels, word=arm, watch=watch)
            else:
                board_log = session.follow(session.list_references(), seconds, word=arm, watch=watch)
        answer_log(session, board_log, options)


@hardware.command("hil")
@spread_options
def hil(
    source: BoardSource,
    arm: Armed = None,
    out: Annotated[Path | None, Option(help="Table of the run to write: .csv.")] = None,
    duration: Annotated[
        Text, Option(help='Duration of the run, e.g. "10 s" [default: the duration of the scenario].')
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run the loop on the board with a simulated plant.

    The result is compared with a simulation of both. The switches of the board stay open, but the board must be
    armed with `--arm ARM`.
    """
    from martensite.boards.hil import compare_runs, run_hil
    from martensite.show.terminal import print_summary

    outputs = Outputs(out, None).check(force, data=(".csv",))
    if arm is None:
        raise InputError("Hardware in the loop arms the board, with its switches open: say `--arm ARM`.")
    seconds = read_positive("duration", duration, "s")
    with open_session(source) as session, open_bar("plant here, loop there", 1.0) as move:
        watch: Callable[[float], None] | None = move and (lambda share: move(completed=share))
        outcome = run_hil(session.scenario, session.link, session.firmware, word=arm, duration=seconds, watch=watch)
        rows = compare_runs(session.scenario, outcome)
    outputs.write(outcome.to_text)
    table = DataTable(
        ("output", "largest difference", "of range"),
        [[n, f"{d:.3g} {u}", f"{s:.2g}"] for n, u, d, s in rows],
        right=(1, 2),
    )
    words = f"{len(outcome.times)} samples, {outcome.lost_frames} frames lost; the run here with float64 differs by:"
    data = {"samples": len(outcome.times), "lost": outcome.lost_frames, "differences": {n: d for n, _, d, _ in rows}}
    print_summary(Summary("", [Sentence(words), table], data), json, outputs.paths())


def _describe_dry_run(session: Session, seconds: float, levels: list[tuple[float, float]]) -> list[Block]:
    from martensite.boards.link.host import RESETS

    what = f"levels of {len(levels)} steps" if levels else "the loop"
    most = max((duty for _, duty in levels), default=session.firmware["settings"][0]["value"])
    return [
        Sentence("Dry run: nothing was armed.", "caution"),
        Sentence(f"The last reset of the board was caused by {RESETS[session.link.reset]}."),
        Sentence(f"With `--arm ARM` it would run {what} for {seconds:.4g} s, with a duty of at most {most:.3g}."),
    ]
