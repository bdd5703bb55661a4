"""`hardware replay` and `hardware characterise`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.board_options import Armed, BoardSource, ProjectFolder, require_empty, show_log
from martensite.cli.commands.hardware import hardware
from martensite.cli.options import FigureFile, Force, Json, Texts, read_positive, spread_options
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_spinner


@hardware.command("replay")
@spread_options
def replay(
    project: ProjectFolder,
    logged: Annotated[Path, typer.Argument(metavar="LOG", help="Log of the board.")],
    figure: FigureFile = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Compare a log with the model under the same signals."""
    from martensite.boards.replay import replay_log
    from martensite.boards.session import read_project, read_project_scenario

    outputs = Outputs(None, figure).check(force)
    replayed = replay_log(read_project_scenario(read_project(project)), logged)
    rows = [[one.name, f"{one.rms:.4g} {one.unit}", f"{100.0 * one.fit:.1f} %"] for one in replayed.readings]
    table = DataTable(("reading", "rms of measured - model", "fit"), rows, right=(1, 2))
    data = {one.name: {"rms": one.rms, "fit": one.fit} for one in replayed.readings}
    outputs.answer(Summary("", [Sentence(f"{len(replayed.times)} samples"), table], data), json, None, replayed.plot)


@hardware.command("characterise")
@spread_options
def characterise(
    source: BoardSource,
    free: Annotated[str, Option(help="Parameters to identify, comma-separated, e.g. A_s,A_f,M_s,M_f,h.")],
    out: Annotated[Path, Option(metavar="FOLDER", help="Output folder for logs, scenario and report.")],
    budget: Annotated[str, Option("--time", help='Total duration of all excitation profiles, e.g. "120 s".')] = "120 s",
    arm: Armed = None,
    emulated: Annotated[
        Texts,
        Option(
            metavar="PATH=VALUE",
            help=('Parameter of the emulated wire that differs from the model, e.g. A_s="75 degC"; repeatable.'),
        ),
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit the parameters of a wire by designed experiments.

    Excitation profiles are selected by the information matrix of the fit. None of them heats a possible wire above
    its limit. Without `--arm ARM` the command is a dry run that reports the profiles and their information.
    """
    from martensite.base.files import make_folder
    from martensite.boards.characterise import characterise as work
    from martensite.boards.session import Session, read_project, read_project_scenario
    from martensite.scenario.overrides import read_settings
    from martensite.show.terminal import print_summary

    seconds, firmware = read_positive("time", budget, "s"), read_project(source.project)
    require_empty(out, force)
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
        courses = work.fit_courses(firmware["scenario"], out, logs, unknown)
        files = work.write_fit(courses, out)
    print_summary(Summary("", [*plan, *work.describe_fit(courses)], dict(courses.numbers)), json, [*logs, *files])
