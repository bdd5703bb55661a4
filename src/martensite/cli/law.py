"""`law`: one or several laws on a path of stress, strain and temperature, without a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.errors import ParameterError, UnitError, UnknownNameError
from martensite.cli.app import app
from martensite.cli.options import Figure, Force, Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.scenario.laws import Dressed
    from martensite.simulate.courses import Choices, PathRates
    from martensite.simulate.point import PointResult
    from martensite.simulate.stages import PathStage

COLUMNS = ("path", "leg", "ξ", "transforms", "starts", "half", "ends", "strain", "stress")
RATES = {"temperature": "K/s", "stress": "Pa/s", "strain": "1/s"}
"""Field of `Rates` -> its SI unit."""


@app.command()
def law(
    names: Annotated[
        list[str], typer.Argument(metavar="NAME...", help="Laws; several are drawn side by side.")
    ],
    path: Annotated[
        str,
        typer.Option(
            help="superelastic, tension, isobaric, free-recovery, shape-memory, "
            "constrained-recovery, or minor-loops."
        ),
    ] = "superelastic",
    material: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE", help="Whose numbers [default: the first that has all of them]."
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PARAMETER=VALUE",
            help='Set a number or a word of the laws, e.g. --set A_f="60 degC"; LAW.PARAMETER '
            "for one of several; repeatable.",
        ),
    ] = None,
    at: Annotated[
        str | None, typer.Option(help='Temperatures of the path, such as "40 degC, 60 degC".')
    ] = None,
    stress: Annotated[
        str | None, typer.Option(help='Stresses of the path, such as "100 MPa, 200 MPa".')
    ] = None,
    strain: Annotated[
        str | None, typer.Option(help='Largest strain of the path, such as "5 %".')
    ] = None,
    start: Annotated[
        str | None,
        typer.Option("--from", help="austenite, martensite, or twinned [default: the path's own]."),
    ] = None,
    rate: Annotated[
        str | None,
        typer.Option(help='How fast, such as "1 K/s, 10 MPa/s, 0.1 %/s", for laws with rates.'),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(help="Accepted change on halving the steps, as a share of range.")
    ] = 1e-3,
    runtime: Annotated[str, typer.Option(help="floats, or c.")] = "floats",
    figure: Figure = None,
    out: Annotated[Path | None, typer.Option(help="Table to write: .csv.")] = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Drive laws along a path: a summary, a figure, a table."""
    import_modules(modules)
    from martensite.cli.outputs import Outputs, parts
    from martensite.scenario.laws import dressed_laws
    from martensite.scenario.overrides import read_settings
    from martensite.simulate.paths import find_path, named_path

    outputs = Outputs(out, figure).check(force, data=(".csv",))
    plane = find_path(path).plane
    chosen = _choices(at, stress, strain, start, rate)
    dressed = dressed_laws(list(dict.fromkeys(names)), material, read_settings(settings or []))
    laid = [named_path(path, one.law, chosen) for one in dressed]
    results = [
        [course.follow(one.law, tolerance=tolerance, runtime=runtime) for course in courses]
        for one, courses in zip(dressed, laid, strict=True)
    ]
    with parts(outputs) as files:
        _write(files, results, plane, f"{path}: {', '.join(names)}")
    if json:
        from martensite.cli import show

        show.as_json(_report(path, dressed, results, outputs.paths()))
    else:
        _print(path, dressed, results, outputs.paths())


# ---------------------------------------------------------------- reading the options


def _choices(
    at: str | None, stress: str | None, strain: str | None, start: str | None, rate: str | None
) -> Choices:
    from martensite.simulate.courses import STARTS, Choices

    if start is not None and start not in STARTS:
        raise UnknownNameError("phase state", start, STARTS)
    strains = _quantities("--strain", strain, "1")
    if len(strains) > 1:
        raise ParameterError(f"Option `--strain` takes one strain, but is `{strain}`.")
    return Choices(
        temperatures=_quantities("--at", at, "K"),
        stresses=_quantities("--stress", stress, "Pa"),
        strain=strains[0] if strains else None,
        fractions=None if start is None else STARTS[start],
        rates=_rates(rate),
    )


def _quantities(option: str, text: str | None, unit: str) -> tuple[float, ...]:
    """Quantities separated by commas, in SI."""
    from martensite.base import units

    if text is None:
        return ()
    try:
        found = tuple(units.parse_quantity(part, unit) for part in text.split(","))
    except UnitError as error:
        raise UnitError(f"Option `{option}`: {error}") from None
    if any(value < 0.0 or (value == 0.0 and unit != "Pa") for value in found):
        least = "values of at least 0" if unit == "Pa" else "values above 0"
        raise ParameterError(f"Option `{option}` takes {least}, but is `{text}`.")
    return found


def _rates(text: str | None) -> PathRates:
    from dataclasses import replace

    from martensite.simulate.courses import PathRates

    rates = PathRates()
    for part in text.split(",") if text else ():
        name, value = _rate(part.strip())
        rates = replace(rates, **{name: value})
    return rates


def _rate(text: str) -> tuple[str, float]:
    """Field of `Rates` and value of one rate; its unit says which."""
    from martensite.base import units

    spelled = text.replace("%", " percent")
    for name, unit in RATES.items():
        try:
            value = units.parse_quantity(spelled, unit)
        except UnitError:
            continue
        if value > 0.0:
            return name, value
    raise UnitError(
        f"Option `--rate`: `{text}` is no rate above 0 of temperature, stress or strain; write for "
        "example `1 K/s, 10 MPa/s, 0.1 %/s`."
    )


# ---------------------------------------------------------------- writing


def _write(
    files: Any, results: Sequence[list[PointResult]], plane: tuple[str, str], title: str
) -> None:
    every = [result for own in results for result in own]
    if files.data is not None:
        from martensite.scenario.points import write_points

        write_points(every, files.data)
    if files.figure is not None:
        from martensite.show.figures.files import write_figure
        from martensite.show.figures.law_paths import plot_point

        write_figure(plot_point(every, title=title, plane=plane), files.figure)


# ---------------------------------------------------------------- showing


def _report(
    path: str, dressed: Sequence[Dressed], results: Sequence[list[PointResult]], files: list[Path]
) -> dict[str, Any]:
    """Everything in SI."""
    return {
        "path": path,
        "laws": [
            {
                "name": one.law.registered_name,
                "material": None if one.material is None else one.material.name,
                "cautions": one.cautions,
                "paths": [_one(result) for result in own],
            }
            for one, own in zip(dressed, results, strict=True)
        ],
        "files": [str(file) for file in files],
    }


def _one(result: PointResult) -> dict[str, Any]:
    from dataclasses import asdict

    from martensite.simulate.stages import list_stages, residual_strain

    return {
        "label": result.label,
        "status": result.status.name,
        "steps": result.steps,
        "accuracy": result.accuracy,
        "residual_strain": residual_strain(result),
        "work": result.work,
        "warnings": result.warnings,
        "legs": [asdict(stage) for stage in list_stages(result)],
    }


def _print(
    path: str, dressed: Sequence[Dressed], results: Sequence[list[PointResult]], files: list[Path]
) -> None:
    from martensite.cli import show

    for one, own in zip(dressed, results, strict=True):
        source = "" if one.material is None else f", numbers of {one.material.name}"
        show.text(f"{one.law.registered_name} on the path {path}{source}", "bold")
        show.table(COLUMNS, [row for result in own for row in _rows(result)],
                   right="ξ,starts,half,ends,strain,stress")  # fmt: skip
        for result in own:
            show.text(_left(result))
        for caution in one.cautions:
            show.text(f"Caution: {caution}", "yellow")
        for warning in [w for result in own for w in result.warnings]:
            show.text(warning, "yellow")
    for file in files:
        show.text(f"wrote {file}")


def _left(result: PointResult) -> str:
    """What a path leaves: strain, and the work lost on the way."""
    from martensite.simulate.stages import residual_strain

    accuracy = "" if result.accuracy is None else f", accuracy {result.accuracy:.1e} of range"
    return (
        f"{result.label}: residual strain {100.0 * residual_strain(result):.3f} %, work "
        f"{result.work / 1e6:.3f} MJ/m³ ({result.steps:,} steps{accuracy})"
    )


def _rows(result: PointResult) -> list[tuple[str, ...]]:
    from martensite.simulate.stages import list_stages

    return [
        (result.label if i == 0 else "", *_row(i + 1, stage))
        for i, stage in enumerate(list_stages(result))
    ]


def _row(number: int, stage: PathStage) -> tuple[str, ...]:
    spots = [_spot(stage, i) for i in range(3)]
    change = f"{stage.martensite:+.3f}" if stage.process != "orientation" else "0"
    strain, stress = f"{100.0 * stage.strain:.3f} %", f"{stage.end.stress / 1e6:.1f} MPa"
    return f"{number} {stage.kind}", change, stage.process, *spots, strain, stress


def _spot(stage: PathStage, i: int) -> str:
    """Where a transformation starts, is half done or ends: in what changes on the leg."""
    if stage.spots is None:
        return ""
    spot, parts = stage.spots[i], list[str]()
    if "temperature" in stage.varies:
        parts.append(f"{spot.temperature - 273.15:.1f} degC")
    if "stress" in stage.varies:
        parts.append(f"{spot.stress / 1e6:.1f} MPa")
    return ", ".join(parts)
