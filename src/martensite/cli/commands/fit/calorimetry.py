"""`fit dsc`: transformation temperatures and latent heat from a calorimeter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.cli.commands.fit import fit
from martensite.cli.options import NamedColumns, Text, read_positive, spread_options
from martensite.cli.outputs import AnswerOptions

if TYPE_CHECKING:
    from martensite.characterise.calorimetry import Calorimetry


@fit.command("dsc")
@spread_options
def dsc(
    logs: Annotated[
        list[str],
        Argument(
            metavar="LOG...", help="DSC exports of one sample, with temperature and heat flow; any number of ramps."
        ),
    ],
    answer: AnswerOptions,
    mass: Annotated[
        Text, Option(help='Mass of the sample, for a heat flow in watts, e.g. "12.3 mg" [default: as in the file].')
    ] = None,
    rate: Annotated[Text, Option(help='Heating rate of a file without times, e.g. "10 K/min".')] = None,
    baseline: Annotated[
        Text, Option(metavar="sigmoid|line", help="Baseline below the peaks [default: sigmoid].")
    ] = None,
    new_headings: NamedColumns = None,
    out: Annotated[Path | None, Option(metavar="MATERIAL", help="Material file to write: .toml.")] = None,
) -> None:
    """Compute transformation temperatures and latent heat from DSC.

    Tangents at the peaks give A_s, A_f, M_s, M_f, and R_s, R_f of a second peak on cooling. The area above the baseline
    gives the latent heat. Ramps of several rates are extrapolated to rate 0.
    """
    outputs = answer.check_files(out, ".toml")
    calorimetry = read_calorimetry(logs, mass, rate, baseline, new_headings)
    from martensite.show.figures.calorimetry import plot_calorimetry
    from martensite.show.summaries.calorimetry import summarise_calorimetry

    if out is not None:
        calorimetry.write_material(out)
    outputs.answer(summarise_calorimetry(calorimetry), answer.json, draw=lambda: plot_calorimetry(calorimetry))


def read_calorimetry(
    logs: list[str], mass: str | None, rate: str | None, baseline: str | None, new_headings: list[str] | None
) -> Calorimetry:
    """Return the evaluation of DSC files; a mass in a file is used if none is given."""
    from martensite.characterise.calorimetry import fit_calorimetry
    from martensite.characterise.heat_peaks import SIGMOID
    from martensite.characterise.heat_ramps import read_mass
    from martensite.logs.reader import parse_new_headings, read_parts, tell_guesses

    given, speed = read_positive("mass", mass, "kg"), read_positive("rate", rate, "K/s")
    files = [
        tell_guesses(part)
        for log in logs
        for part in read_parts(log, parse_new_headings(new_headings or ()), known=True)
    ]
    masses = [given or read_mass(one.header_entries) for one in files]
    return fit_calorimetry([one.record for one in files], mass=masses, rate=speed, baseline=baseline or SIGMOID)
