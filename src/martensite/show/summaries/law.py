"""Laws on a path: the legs of the path, what is left in the end, and cautions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.simulate.path_stages import PathStage, list_stages, residual_strain

if TYPE_CHECKING:
    from martensite.scenario.laws import ConfiguredLaw
    from martensite.simulate.point import PointResult

COLUMNS = ("path", "leg", "ξ", "transforms", "starts", "half", "ends", "strain", "stress")


def summarise_laws(path: str, dressed: Sequence[ConfiguredLaw], results: Sequence[Sequence[PointResult]]) -> Summary:
    """Everything about laws on a path.

    Args:
        path: its name.
        dressed: the laws.
        results: what each of them did on the paths that it was given.
    """
    pairs = list(zip(dressed, results, strict=True))
    blocks = [block for one, own in pairs for block in _describe_law(path, one, own)]
    return Summary("", blocks, {"path": path, "laws": [_collect_law(*pair) for pair in pairs]})


def _describe_law(path: str, one: ConfiguredLaw, own: Sequence[PointResult]) -> Iterator[Block]:
    source = "" if one.material is None else f", numbers of {one.material.name}"
    yield Heading(f"{one.law.registered_name} on the path {path}{source}")
    rows = [row for result in own for row in _list_rows(result)]
    yield DataTable(COLUMNS, rows, right=(2, 4, 5, 6, 7, 8))
    yield from (Sentence(_tell_rest(result)) for result in own)
    yield from (Sentence(f"Caution: {caution}", "caution") for caution in one.cautions)
    yield from (Sentence(words, "caution") for result in own for words in result.warnings)


def _collect_law(one: ConfiguredLaw, own: Sequence[PointResult]) -> dict[str, Any]:
    return {
        "name": one.law.registered_name,
        "material": None if one.material is None else one.material.name,
        "cautions": one.cautions,
        "paths": [_collect_path(result) for result in own],
    }


def _collect_path(result: PointResult) -> dict[str, Any]:
    return {
        "label": result.label,
        "status": result.status.name,
        "steps": result.steps,
        "accuracy": result.accuracy,
        "residual_strain": residual_strain(result),
        "work": result.work,
        "warnings": result.warnings,
        "legs": [_describe_leg(stage) for stage in list_stages(result)],
    }


def _describe_leg(stage: PathStage) -> dict[str, Any]:
    spots = None if stage.spots is None else [one._asdict() for one in stage.spots]
    return asdict(stage) | {"spots": spots, "end": stage.end._asdict()}


def _tell_rest(result: PointResult) -> str:
    """What a path leaves: strain, and the work lost on the way."""
    accuracy = "" if result.accuracy is None else f", accuracy {result.accuracy:.1e} of range"
    return (
        f"{result.label}: residual strain {100.0 * residual_strain(result):.3f} %, work "
        f"{result.work / 1e6:.3f} MJ/m³ ({result.steps:,} steps{accuracy})"
    )


def _list_rows(result: PointResult) -> list[tuple[str, ...]]:
    return [
        (result.label if i == 0 else "", *_write_stage(i + 1, stage)) for i, stage in enumerate(list_stages(result))
    ]


def _write_stage(number: int, stage: PathStage) -> tuple[str, ...]:
    spots = [_write_spot(stage, i) for i in range(3)]
    change = f"{stage.martensite:+.3f}" if stage.process != "orientation" else "0"
    strain, stress = f"{100.0 * stage.strain:.3f} %", f"{stage.end.stress / 1e6:.1f} MPa"
    return f"{number} {stage.kind}", change, stage.process, *spots, strain, stress


def _write_spot(stage: PathStage, i: int) -> str:
    """Where a transformation starts, is half done or ends: in what changes on the leg."""
    if stage.spots is None:
        return ""
    spot, parts = stage.spots[i], list[str]()
    if "temperature" in stage.varies:
        parts.append(f"{spot.temperature - 273.15:.1f} degC")
    if "stress" in stage.varies:
        parts.append(f"{spot.stress / 1e6:.1f} MPa")
    return ", ".join(parts)
