"""`hardware`: boards that hold a loop, and their logs; `export firmware`: the project for one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.options import (
    FigureFile,
    Force,
    Json,
    ScenarioSource,
    Text,
    Texts,
    read_positive,
    read_quantity,
    spread_options,
)
from martensite.cli.outputs import Outputs
from martensite.cli.progress import open_bar, show_spinner
from martensite_hardware.board_log import ENDINGS

if TYPE_CHECKING:
    from martensite_hardware.board_log import BoardLog
    from martensite_hardware.firmware.project import Firmware
    from martensite_hardware.session import Session

hardware = typer.Typer(no_args_is_help=True)
boards, exports = typer.Typer(), typer.Typer()
boards.add_typer(hardware, name="hardware", help="Boards: log, run, calibrate, replay, the plant in the loop.")
"""What the command line takes in: this group, and `export firmware`."""
ProjectFolder = Annotated[Path, typer.Argument(metavar="PROJECT", help="A folder that `export firmware` wrote.")]
SHOWN = 4
"""Numbers beside a progress bar."""


@dataclass(frozen=True)
class BoardSource:
    """A board: its project, and where it is."""

    project: ProjectFolder
    port: Annotated[str, Option(help="Serial port such as /dev/ttyACM0 or COM3, or emulator.")] = "emulator"


@dataclass(frozen=True)
class LogOptions:
    """Where a log goes."""

    out: Annotated[Path | None, Option(help="Log to write: .csv, .parquet or .mcap.")] = None
    force: Force = False
    json: Json = False

    def check_file(self) -> LogOptions:
        """These options; `DataError` if the log may not be written."""
        Outputs(self.out, None).check(self.force, data=ENDINGS)
        return self


Armed = Annotated[
    Text, Option("--arm", metavar="ARM", help="Without the word ARM nothing is heated: a dry run says what would be.")
]


@exports.command("firmware")
@spread_options
def firmware(
    source: ScenarioSource,
    board: Annotated[str, Option(help="uno, mega2560, esp32 or stm32f405.")],
    out: Annotated[Path | None, Option(metavar="FOLDER", help="Where to write [default: ./SCENARIO_BOARD].")] = None,
    silence: Annotated[str, Option(help="The board disarms when it has not heard the host for so long.")] = "40 ms",
    longest: Annotated[str, Option(help="It disarms when it was armed for so long.")] = "1 h",
    most_duty: Annotated[float, Option(help="No signal is above it.")] = 1.0,
    most_current: Annotated[
        Text, Option(help="It disarms above this current [default: 1.25 times that of the full signal].")
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a complete firmware around the loop of a scenario: sketch or bare project, link, guard, wiring.

    The loop is tried in float32 over the scenario first. Nothing is armed before the host says so, and the
    board disarms by itself when the host is silent, the supply low or the current too large.
    """
    from martensite.show.terminal import print_summary
    from martensite_hardware.firmware.project import build_firmware
    from martensite_hardware.firmware.settings import Limits

    if not 0.0 < most_duty <= 1.0:
        raise InputError(f"Option `--most-duty` must be above 0 and at most 1, but is {most_duty:g}.")
    limits = Limits(
        read_positive("silence", silence, "s"),
        read_positive("longest", longest, "s"),
        most_duty,
        read_positive("most-current", most_current, "A"),
    )
    folder = out or Path(f"{source.file.stem}_{board}")
    found = build_firmware(source.load(), board, name=folder.resolve().name, limits=limits)
    if folder.exists() and any(folder.iterdir()) and not force:
        raise InputError(f"`{folder}` is not empty; use --force to write into it, or name another folder.")
    files = found.write(folder)
    print_summary(_summarise_firmware(found), json, files)


@exports.command("ros2")
def ros2(
    project: ProjectFolder,
    name: Annotated[str, Option(help="Name of the package.")] = "sma_board",
    out: Annotated[Path | None, Option(metavar="FOLDER", help="Where to write [default: ./NAME].")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a package for ROS 2 around a firmware: a ros2_control hardware interface, messages, a description."""
    from martensite.base.files import replace_together, write_file
    from martensite.show.terminal import print_summary
    from martensite_hardware.ros2.package import build_ros2_package

    texts, folder = build_ros2_package(project, name), out or Path(name)
    if folder.exists() and any(folder.iterdir()) and not force:
        raise InputError(f"`{folder}` is not empty; use --force to write into it, or name another folder.")
    for path in texts:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
    with replace_together():
        for path, text in texts.items():
            write_file(folder / path, text)
    words = "It was not built with ROS 2 here; what it stands on was compiled and run against an emulated board."
    print_summary(Summary("", [Sentence(words, "caution")], {"package": name}), json, [folder / path for path in texts])


def _summarise_firmware(found: Firmware) -> Summary:
    plan = found.plan
    count = sum(plan.core.operations["step"].values())
    rows = [
        [one.name, f"{one.value:.4g}", one.unit, "flash" if one.fixed else "host", one.about] for one in plan.settings
    ]
    data = {"board": plan.board.name, "digest": plan.digest, "tried": found.tried, "operations": plan.core.operations}
    blocks: list[Block] = [
        Sentence(f"{plan.core.description}, for {plan.board.title}"),
        Sentence(f"model: {plan.core.size:,} bytes; a step takes at most {count} operations"),
        Sentence(found.tried),
        DataTable(("setting", "value", "unit", "stands in", "about"), rows, right=(1,)),
        Sentence("Gains and offsets are nominal: calibrate the board before it arms on its own readings.", "caution"),
    ]
    return Summary("", blocks, data)


@hardware.command("ports")
def ports(json: Json = False) -> None:
    """List the serial ports that there are."""
    from serial.tools.list_ports import comports

    from martensite.show.terminal import print_summary

    found = [[one.device, one.description or ""] for one in comports()]
    block: Block = DataTable(("port", "what it is"), found) if found else Sentence("No serial port is there.")
    print_summary(Summary("", [block], {"ports": [one[0] for one in found]}), json)


@hardware.command("log")
@spread_options
def log(
    source: BoardSource, options: LogOptions, duration: Annotated[str, Option(help="How long to listen.")] = "5 s"
) -> None:
    """Log what a board measures, nothing armed."""
    options.check_file()
    seconds = read_positive("duration", duration, "s")
    with _open_session(source) as session, show_log("logging") as watch:
        found = session.listen(seconds, watch)
        _answer_log(session, found, options)


@hardware.command("run")
@spread_options
def run(
    source: BoardSource,
    options: LogOptions,
    arm: Armed = None,
    duration: Annotated[Text, Option(help="[default: that of the scenario]")] = None,
    duty: Annotated[
        Text, Option(metavar="TIME:DUTY,…", help="Play levels instead of the loop: 2 s:0.4, 5 s:0.")
    ] = None,
) -> None:
    """Run the loop of the scenario on the board, or levels of its duty, and log it.

    Without `--arm ARM` it is a dry run: the board is asked, nothing is heated, and what would be done is said.
    """
    options.check_file()
    levels = _read_levels(duty) if duty is not None else []
    with _open_session(source) as session:
        scenario = session.scenario
        seconds = read_quantity("duration", duration, "s") or (sum(t for t, _ in levels) or scenario.duration)
        if arm is None:
            with show_log("listening") as watch:
                found = session.listen(0.5, watch)
            _answer_log(session, found, options, _describe_dry_run(session, seconds, levels))
            return
        with show_log("running") as watch:
            if levels:
                found = session.play(levels, word=arm, watch=watch)
            else:
                found = session.follow(_list_references(session), seconds, word=arm, watch=watch)
        _answer_log(session, found, options)


@hardware.command("hil")
@spread_options
def hil(
    source: BoardSource,
    arm: Armed = None,
    out: Annotated[Path | None, Option(help="Table of the run to write: .csv.")] = None,
    duration: Annotated[Text, Option(help="[default: that of the scenario]")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run the plant here and its loop on the board, and compare with the run of both here.

    The board's own switches stay open, but it computes and answers as if it drove them; say `--arm ARM`.
    """
    from martensite.show.terminal import print_summary
    from martensite_hardware.hil import compare_runs, run_hil

    outputs = Outputs(out, None).check(force, data=(".csv",))
    if arm is None:
        raise InputError("Hardware in the loop arms the board, with its switches open: say `--arm ARM`.")
    seconds = read_quantity("duration", duration, "s")
    with _open_session(source) as session, open_bar("plant here, loop there", 1.0) as move:
        watch: Callable[[float], None] | None = move and (lambda share: move(completed=share))
        found = run_hil(session.scenario, session.link, session.firmware, word=arm, duration=seconds, watch=watch)
        rows = compare_runs(session.scenario, found)
    outputs.write(found.to_text)
    table = DataTable(
        ("output", "largest difference", "of range"),
        [[n, f"{d:.3g} {u}", f"{s:.2g}"] for n, u, d, s in rows],
        right=(1, 2),
    )
    words = f"{len(found.times)} samples, {found.lost} frames lost; the run here with float64 differs by:"
    data = {"samples": len(found.times), "lost": found.lost, "differences": {n: d for n, _, d, _ in rows}}
    print_summary(Summary("", [Sentence(words), table], data), json, outputs.paths())


@hardware.command("calibrate")
@spread_options
def calibrate(
    source: BoardSource,
    channel: Annotated[Text, Option(help="Channel that is at a known value, such as position.")] = None,
    value: Annotated[Text, Option("--is", help='What is there: "0 mm", "5.02 V".')] = None,
    resistor: Annotated[Text, Option(help='A known resistor in the place of the wire: "10 ohm".')] = None,
    arm: Armed = None,
    nominal: Annotated[bool, Option("--nominal", help="Take the nominal gains as they are.")] = False,
    json: Json = False,
) -> None:
    """Set gains and offsets by what is known to be there; kept in calibration.json of the project.

    A channel at 0 sets its offset, at another value its gain; with two points both.
    """
    from martensite.base import units
    from martensite.show.terminal import print_summary
    from martensite_hardware import calibration

    chosen = [channel is not None, resistor is not None, nominal]
    if sum(chosen) != 1 or (channel is None) != (value is None):
        raise InputError("Say `--channel NAME --is VALUE`, `--resistor OHMS --arm ARM`, or `--nominal`.")
    with _open_session(source) as session:
        if nominal:
            calibration.accept_nominal(session)
            words = (
                "Nominal gains and offsets are taken as they are: readings are as good as the parts of the wiring list."
            )
        elif resistor is not None:
            ohms = read_positive("resistor", resistor, "ohm")
            factor = calibration.calibrate_resistor(session, ohms, word=arm or "")
            words = f"The gain of the current is {factor:.5g} times what it was."
        else:
            name = str(channel)
            si = units.parse_quantity(str(value), calibration.find_channel_unit(session.firmware, name))
            point = calibration.add_point(session, name, si)
            words = f"{name}: {point.steps:.2f} steps, with a spread of {point.spread:.2f}, are {value}."
        settings = {row["name"]: row["value"] for row in session.firmware["settings"] if not row["fixed"]}
    rows = [[name, f"{number:.6g}"] for name, number in settings.items() if name.startswith(("gain", "offset"))]
    blocks: list[Block] = [Sentence(words), DataTable(("setting", "value"), rows, right=(1,))]
    print_summary(Summary("", blocks, settings), json, [source.project / calibration.CALIBRATION])


@hardware.command("cost")
@spread_options
def cost(
    source: ScenarioSource,
    part: Annotated[str, Option(help="loop: what a board runs; plant: the model alone.")] = "loop",
    json: Json = False,
) -> None:
    """Say what a step of a loop or a model costs on emulated processors, in float32.

    Cycles of an AVR are those of its data sheet, as simavr counts them. QEMU counts instructions of a Cortex-M4, of
    which most take a cycle and a division 14: the time that follows from them is the least.
    """
    from tempfile import TemporaryDirectory

    from martensite.show.terminal import print_summary
    from martensite_hardware.emulators.cost import measure_costs

    with TemporaryDirectory() as folder, show_spinner("counting"):
        core, found = measure_costs(source.load(), part, Path(folder))
    rows = [
        [one.processor, f"{one.most:,} {one.counted}", f"{1e6 * one.time:.4g} us", f"{one.flash:,}", f"{one.ram:,}"]
        for one in found
    ]
    head = ("processor", "dearest step", "at least" if any(one.least for one in found) else "time", "flash", "RAM")
    blocks: list[Block] = [Sentence(f"{core.description}, float32"), DataTable(head, rows, right=(1, 2, 3, 4))]
    blocks += [Sentence(f"{one.processor}: a step was not solved in float32.", "bad") for one in found if one.failed]
    print_summary(Summary("", blocks, {one.processor: vars(one) for one in found}), json)


@hardware.command("characterise")
@spread_options
def characterise(
    source: BoardSource,
    free: Annotated[str, Option(help="What is to be learnt: A_s,A_f,M_s,M_f,h.")],
    out: Annotated[Path, Option(metavar="FOLDER", help="Where logs, scenario and report are written.")],
    budget: Annotated[str, Option("--time", help="For all courses together.")] = "120 s",
    arm: Armed = None,
    emulated: Annotated[
        Texts, Option(metavar="PATH=VALUE", help="Another wire in the emulator than the model's; repeatable.")
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run the courses of a duty that tell most of a wire, and fit its numbers to them.

    Courses are chosen by the information matrix of the fit, and none heats a wire that may be at hand above its limit.
    Without `--arm ARM` it is a dry run, which says which courses these are and what they would tell.
    """
    from martensite.base.files import make_folder
    from martensite.scenario.overrides import read_settings
    from martensite.show.terminal import print_summary
    from martensite_hardware.characterise import characterise as work
    from martensite_hardware.session import Session, read_project, read_project_scenario

    seconds, firmware = read_positive("time", budget, "s"), read_project(source.project)
    if out.exists() and any(out.iterdir()) and not force:
        raise InputError(f"`{out}` is not empty; use --force to write into it, or name another folder.")
    bench = read_project_scenario(firmware).bench
    if bench is None:
        raise InputError("The firmware has no loop, and so no sensors.")
    unknown = work.list_unknown(bench, [name.strip() for name in free.split(",")], {})
    with show_spinner("choosing courses"):
        chosen = work.plan_courses(bench, unknown, seconds)
    plan = work.describe_plan(unknown, chosen)
    if arm is None:
        print_summary(Summary("", [*plan, Sentence("Dry run: nothing was armed.", "caution")], {}), json)
        return
    make_folder(out)
    logs = work.name_logs(out, chosen.courses)
    with Session.open(source.project, source.port, read_settings(emulated or [])) as session:
        for course, path in zip(chosen.courses, logs, strict=True):
            with show_log(course.name) as watch:
                session.play(course.levels, word=arm, watch=watch).write(path, session.link.reader.counts)
    with show_spinner("fitting"):
        found, files = work.fit_courses(firmware["scenario"], out, logs, unknown)
    print_summary(Summary("", [*plan, *work.describe_fit(found)], dict(found.numbers)), json, [*logs, *files])


@hardware.command("replay")
@spread_options
def replay(
    project: ProjectFolder,
    logged: Annotated[Path, typer.Argument(metavar="LOG", help="A log of its board.")],
    figure: FigureFile = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Put the readings of a log beside those of the model under the same signals."""
    from martensite_hardware.replay import replay_log
    from martensite_hardware.session import read_project, read_project_scenario

    outputs = Outputs(None, figure).check(force)
    found = replay_log(read_project_scenario(read_project(project)), logged)
    rows = [[one.name, f"{one.rms:.4g} {one.unit}", f"{100.0 * one.fit:.1f} %"] for one in found.readings]
    table = DataTable(("reading", "rms of measured - model", "fit"), rows, right=(1, 2))
    data = {one.name: {"rms": one.rms, "fit": one.fit} for one in found.readings}
    outputs.answer(Summary("", [Sentence(f"{len(found.times)} samples"), table], data), json, None, found.plot)


@contextmanager
def _open_session(source: BoardSource) -> Iterator[Session]:
    from martensite_hardware.session import Session

    with Session.open(source.project, source.port) as found:
        yield found


def _list_references(session: Session) -> dict[str, Any]:
    from martensite.control.loop.run import reference_waveforms

    bench = session.scenario.bench
    return {} if bench is None else reference_waveforms(bench)


def _read_levels(text: str) -> list[tuple[float, float]]:
    found = list[tuple[float, float]]()
    for piece in text.split(","):
        length, sign, level = piece.rpartition(":")
        try:
            duty = float(level)
        except ValueError:
            sign = ""
            duty = 0.0
        if not sign or not 0.0 <= duty <= 1.0:
            raise InputError(
                f"Option `--duty` takes times and duties such as `2 s:0.4, 5 s:0`, but `{piece.strip()}` is none."
            )
        found.append((read_positive("duty", length.strip(), "s"), duty))
    return found


def _describe_dry_run(session: Session, seconds: float, levels: list[tuple[float, float]]) -> list[Block]:
    what = f"levels of {len(levels)} steps" if levels else "the loop"
    most = max((duty for _, duty in levels), default=session.firmware["settings"][0]["value"])
    return [
        Sentence("Dry run: nothing was armed.", "caution"),
        Sentence(f"With `--arm ARM` it would run {what} for {seconds:.4g} s, with a duty of at most {most:.3g}."),
    ]


@contextmanager
def show_log(label: str) -> Iterator[Callable[[BoardLog, float], None] | None]:
    """A bar with the newest numbers of a log."""
    with open_bar(label, 1.0) as move:
        yield move and (lambda log, share: move(description=_describe_latest(label, log), completed=share))


def _describe_latest(label: str, log: BoardLog) -> str:
    names = list(log.latest.items())[3 : 3 + SHOWN]
    return f"{label}: " + ", ".join(f"{name} {value:.4g}" for name, value in names)


def _answer_log(session: Session, found: BoardLog, options: LogOptions, before: list[Block] | None = None) -> None:
    from martensite.show.terminal import print_summary

    counts = session.link.reader.counts
    if options.out is not None:
        found.write(options.out, counts)
    table = found.table()
    rows = (
        [
            [heading, f"{column.min():.5g}", f"{column.max():.5g}", f"{column[-1]:.5g}"]
            for heading, column in zip(found.headings(), table.T, strict=True)
        ]
        if len(found)
        else []
    )
    words = (
        f"{len(found)} samples; frames: {counts.good} good, {counts.lost} lost, {counts.garbled} garbled, "
        f"{counts.doubled} doubled, {counts.reordered} late"
    )
    blocks: list[Block] = [
        *(before or []),
        Sentence(words),
        DataTable(("column", "least", "largest", "last"), rows, right=(1, 2, 3)),
    ]
    data = {"samples": len(found), **vars(counts)}
    print_summary(Summary("", blocks, data), options.json, [options.out] if options.out else [])
