"""The few numbers by which runs are compared: stroke, extremes, energy, time beyond limits."""

from __future__ import annotations

from collections.abc import Iterator

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_column
from martensite.base import units
from martensite.simulate.result import Result


def list_key_results(result: Result, energies: JsonTable) -> list[JsonTable]:
    """Rows `{key, name, value, shown, factor, offset}`; values in SI, shown as columns are.

    Args:
        result: the run.
        energies: what `energy` says of it.
    """
    return [
        *_list_strokes(result),
        *_list_peaks(result),
        *_list_energies(energies),
        _build_row(
            "beyond", "time beyond limits", sum(a.duration for a in result.alarms), "s", 1.0
        ),
    ]


def _build_row(
    key: str, name: str, value: float, unit: str, factor: float, offset: float = 0.0
) -> JsonTable:
    return {
        "key": key,
        "name": name,
        "value": value,
        "shown": unit,
        "factor": factor,
        "offset": offset,
    }


def _list_strokes(result: Result) -> Iterator[JsonTable]:
    """How far each coordinate goes that is judged."""
    judged = {result.coordinate, *result.system.mechanism.convergence_scales()}
    for name, output in result.system.mechanism.outputs().items():
        if name in judged:
            how = describe_column(result, name)
            words = f"range of {output.long_name}"
            if name == result.coordinate:
                words = f"stroke ({output.long_name})"
            yield _build_row(
                f"range {name}", words, result.range(name), how["shown"], how["factor"]
            )


def _list_peaks(result: Result) -> Iterator[JsonTable]:
    """Highest temperature, stress and force of all elements, and the lowest martensite fraction."""
    ports = list(result.system.actuators())
    for name, words, choose in (
        ("hottest", "peak temperature", max),
        ("stress", "peak stress", max),
        ("force", "peak force", max),
        ("martensite_fraction", "least martensite fraction", min),
    ):
        columns = [result.system.label(port, name) for port in ports]
        if columns:
            how = describe_column(result, columns[0])
            value = choose(choose(result.columns[column]) for column in columns)
            yield _build_row(name, words, value, how["shown"], how["factor"], how["offset"])


def _list_energies(energies: JsonTable) -> Iterator[JsonTable]:
    """Each energy at the end, and the efficiency."""
    for course in energies["courses"]:
        if course["key"] != "stored":
            yield _build_row(
                course["key"],
                course["long_name"],
                course["values"][-1],
                course["shown"],
                course["factor"],
            )
    if energies["efficiency"]:
        share = energies["efficiency"][-1]
        percent = units.from_si(1.0, "%", "1")
        yield _build_row("efficiency", "efficiency (work over electrical)", share, "%", percent)
