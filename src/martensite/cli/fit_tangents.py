"""`fit tangents`: transformation temperatures, slopes and strain of isobaric cycles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.base.errors import InputError
from martensite.cli.fit import fit
from martensite.cli.options import Texts, read_quantity, spread_options
from martensite.cli.outputs import AnswerOptions

if TYPE_CHECKING:
    from martensite.characterise.tangent_points import TangentPoints


@fit.command("tangents")
@spread_options
def tangents(
    logs: Annotated[
        list[str],
        Argument(
            metavar="LOG...",
            help="Isobaric cycles, one per file: `temperature`, `strain` and `stress`; "
            "or data:SET/FILE for files of a published data set.",
        ),
    ],
    answer: AnswerOptions,
    stress: Annotated[Texts, Option(help='Constant stress of each LOG, e.g. "100 MPa"; repeatable.')] = None,
    cycle: Annotated[int | None, Option(help="Which cycle of each LOG, from 1 on; the last if left out.")] = None,
) -> None:
    """Transformation temperatures, slopes and strain of isobaric cycles, by tangents.

    Each LOG is heated and cooled once through its whole transformation under a constant stress.
    Three straight lines per branch give A_s, A_f, M_s, M_f and the transformation strain; two and
    more stresses give C_A, C_M and the temperatures at zero stress.
    """
    outputs = answer.check_files()
    levels = read_cycles(logs, stress, cycle)
    from martensite.characterise.tangent_fit import fit_tangents
    from martensite.show.figures.laboratory import plot_tangents
    from martensite.show.summaries.laboratory import summarise_tangents

    found = fit_tangents(levels) if len(levels) > 1 else levels[0]
    title = f"Tangents of {levels[0].name if len(levels) == 1 else f'{len(levels)} cycles'}"
    summary = summarise_tangents(found)
    outputs.answer(summary, answer.json, draw=lambda: plot_tangents(found, title))


def read_cycles(logs: Sequence[str], stresses: Sequence[str] | None, cycle: int | None) -> list[TangentPoints]:
    """The tangents of each log, in the order given.

    Raises:
        InputError: stresses and logs are not equally many, or the cycle is counted from below 1.
        DataError: a log is missing, malformed, or holds no isobaric cycle.
        UnitError: a stress is none.
    """
    from martensite.characterise.tangent_points import find_tangent_points
    from martensite.scenario.tables import read_table

    if cycle is not None and cycle < 1:
        raise InputError(f"Option `--cycle` counts from 1 on, but is {cycle}.")
    if stresses and len(stresses) != len(logs):
        raise InputError(
            f"Give --stress once for every LOG, in their order; stresses: {len(stresses)}, logs: {len(logs)}."
        )
    given = [read_quantity("stress", text, "Pa") for text in stresses] if stresses else [None] * len(logs)
    which = -1 if cycle is None else cycle - 1
    return [
        find_tangent_points(read_table(log), stress=stress, cycle=which)
        for log, stress in zip(logs, given, strict=True)
    ]
