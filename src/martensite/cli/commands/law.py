"""`law`: constitutive laws along a path or a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from martensite.base.errors import ParameterError, UnitError, UnknownNameError
from martensite.base.files import replace_together
from martensite.cli.app import app
from martensite.cli.options import Imports, NamedColumns, Text, Texts, import_modules, refuse_idle, spread_options
from martensite.cli.outputs import AnswerOptions, Outputs

if TYPE_CHECKING:
    from martensite.simulate.path_layout import Choices, PathRates

RATES = {"temperature": "K/s", "stress": "Pa/s", "strain": "1/s"}
"""SI units of the fields of `PathRates`."""


@app.command("law", rich_help_panel="Simulate")
@spread_options
def law(
    names: Annotated[
        list[str], Argument(metavar="NAME...", help="Constitutive laws, e.g. brinson; several are drawn in one figure.")
    ],
    answer: AnswerOptions,
    path: Annotated[
        Text,
        Option(
            help=(
                "Loading path: superelastic, tension, isobaric, free-recovery, shape-memory, "
                "constrained-recovery, or minor-loops [default: superelastic]."
            )
        ),
    ] = None,
    log: Annotated[
        Texts,
        Option(
            metavar="LOG",
            help=(
                "Log with strain, stress and temperature that replaces the path; --stress and --at replace "
                "missing columns."
            ),
        ),
    ] = None,
    new_headings: NamedColumns = None,
    material: Annotated[
        Text,
        Option(
            metavar="NAME|FILE", help="Material, e.g. flexinol-90 [default: the first material with all parameters]."
        ),
    ] = None,
    settings: Annotated[
        Texts,
        Option(
            "--set",
            metavar="PARAMETER=VALUE",
            help=(
                'Value of a parameter or option of the laws, e.g. A_f="60 degC", or LAW.PARAMETER=VALUE for one '
                "law; repeatable."
            ),
        ),
    ] = None,
    at: Annotated[Text, Option(help='Temperatures of the path, e.g. "40 degC, 60 degC".')] = None,
    stress: Annotated[Text, Option(help='Stresses of the path, e.g. "100 MPa, 200 MPa".')] = None,
    strain: Annotated[Text, Option(help='Maximum strain of the path, e.g. "5 %".')] = None,
    start: Annotated[
        Text, Option("--from", help="Initial phase: austenite, martensite, or twinned [default: that of the path].")
    ] = None,
    rate: Annotated[
        Text, Option(help='Rates of the path for rate-dependent laws, e.g. "1 K/s, 10 MPa/s, 0.1 %/s".')
    ] = None,
    tolerance: Annotated[float, Option(help="Tolerance relative to the range of each quantity, e.g. 1e-4.")] = 1e-3,
    runtime: Annotated[str, Option(help="Runtime: floats or c.")] = "floats",
    out: Annotated[Path | None, Option(help="Table to write: .csv.")] = None,
    modules: Imports = None,
) -> None:
    """Simulate constitutive laws along a path or a log."""
    import_modules(modules)
    from martensite.logs.reader import parse_new_headings
    from martensite.scenario.csv_files import write_points
    from martensite.scenario.laws import configure_laws
    from martensite.scenario.overrides import read_settings
    from martensite.show.figures.law_paths import plot_point
    from martensite.show.figures.style import write_figure
    from martensite.show.summaries.run import summarise_laws
    from martensite.show.terminal import print_summary
    from martensite.simulate.paths import build_paths, find_path

    outputs = answer.check_files(out, ".csv")
    chosen = _read_choices(at, stress, strain, start, rate)
    if log:
        for option, given in {"--path": path, "--strain": strain, "--rate": rate}.items():
            refuse_idle(option, given is not None, "laws follow the log")
        how = {
            "material": material,
            "settings": read_settings(settings or []),
            "new_headings": parse_new_headings(new_headings or []),
        }
        _follow_logs(names, log, chosen, outputs, answer.json, **how, tolerance=tolerance, runtime=runtime)
        return
    refuse_idle("--as", new_headings is not None, "there is no --log")
    path = path or "superelastic"
    plane = find_path(path).plane
    dressed = configure_laws(list(dict.fromkeys(names)), material, read_settings(settings or []))
    laid = [build_paths(path, one.law, chosen) for one in dressed]
    results = [
        [course.follow(one.law, tolerance=tolerance, runtime=runtime) for course in courses]
        for one, courses in zip(dressed, laid, strict=True)
    ]
    every = [result for own in results for result in own]
    with replace_together():
        if outputs.data is not None:
            write_points(every, outputs.data)
        if outputs.figure is not None:
            title = f"{path}: {', '.join(names)}"
            write_figure(plot_point(every, title=title, plane=plane), outputs.figure)
    print_summary(summarise_laws(path, dressed, results), answer.json, outputs.paths())


def _follow_logs(names: list[str], logs: list[str], chosen: Choices, outputs: Outputs, json: bool, **how: Any) -> None:
    from martensite.scenario.csv_files import write_points
    from martensite.scenario.law_logs import compare_laws_with_log
    from martensite.show.figures.law_logs import plot_law_log
    from martensite.show.summaries.run import summarise_law_logs

    for option, values in (("--stress", chosen.stresses), ("--at", chosen.temperatures)):
        if len(values) > 1:
            raise ParameterError(f"Option `{option}` takes one value with --log, but has {len(values)}.")
    (stress,), (temperature,) = chosen.stresses or (None,), chosen.temperatures or (None,)
    how |= {"stress": stress, "temperature": temperature, "fractions": chosen.fractions}
    entries = [one for log in logs for one in compare_laws_with_log(names, log, **how)]
    if outputs.data is not None:
        write_points([one.result for one in entries], outputs.data)
    outputs.answer(summarise_law_logs(entries), json, draw=lambda: plot_law_log(entries))


def _read_choices(
    at: str | None, stress: str | None, strain: str | None, start: str | None, rate: str | None
) -> Choices:
    from martensite.simulate.path_layout import STARTS, Choices

    if start is not None and start not in STARTS:
        raise UnknownNameError("phase state", start, STARTS)
    strains = _read_quantities("--strain", strain, "1")
    if len(strains) > 1:
        raise ParameterError(f"Option `--strain` takes one strain, but is `{strain}`.")
    return Choices(
        temperatures=_read_quantities("--at", at, "K"),
        stresses=_read_quantities("--stress", stress, "Pa"),
        strain=strains[0] if strains else None,
        fractions=None if start is None else STARTS[start],
        rates=_read_rates(rate),
    )


def _read_quantities(option: str, text: str | None, unit: str) -> tuple[float, ...]:
    from martensite.base import units

    if text is None:
        return ()
    try:
        values = tuple(units.parse_quantity(part, unit) for part in text.split(","))
    except UnitError as error:
        raise UnitError(f"Option `{option}`: {error}") from None
    if any(value < 0.0 or (value == 0.0 and unit != "Pa") for value in values):
        least = "values of at least 0" if unit == "Pa" else "values above 0"
        raise ParameterError(f"Option `{option}` takes {least}, but is `{text}`.")
    return values


def _read_rates(text: str | None) -> PathRates:
    from dataclasses import replace

    from martensite.simulate.path_layout import PathRates

    rates = PathRates()
    for part in text.split(",") if text else ():
        name, value = _read_rate(part.strip())
        rates = replace(rates, **{name: value})
    return rates


def _read_rate(text: str) -> tuple[str, float]:
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
