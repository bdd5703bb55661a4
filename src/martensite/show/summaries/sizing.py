"""Candidate wires for a request, one in detail; and the model compared with the maker's table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from martensite.base.formats import show_quantity, write_percent
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.design.sizing.candidates import Candidate, Sizing
from martensite.design.sizing.catalogue_check import CheckRow, RatioSpread, summarise_ratios
from martensite.design.sizing.cycle import PulseCycle
from martensite.design.sizing.remarks import COIL_DOUBT
from martensite.design.sizing.request import WireRequest
from martensite.physics.materials.base import DOUBTFUL, MaterialNumber, load_material

NEAREST = 5
"""Number of rejected wires shown if no wire meets the request."""
NO_CHANGE = "More strands, a lower rate or a higher voltage do not help. Reduce force or stroke."
COLUMNS = (
    "",
    "wire\nmm",
    "alloy\n°C",
    "strands",
    "length\nmm",
    "stress\nMPa",
    "pulse\nA",
    "\nV",
    "\nJ",
    "heat\ns",
    "cool\ns",
    "",
)
"""Headings narrow enough for 80 columns."""
_SHAPE = ("\n°C", "coils", "D\nmm", "turns", "length\nmm")
COIL_COLUMNS = (*COLUMNS[:2], *_SHAPE, *COLUMNS[5:7], *COLUMNS[9:])
"""Columns of coils: mean diameter, and the length under load, hot and cold."""
CHECKED = (
    "wire\nmm",
    "alloy\n°C",
    "model\nmA",
    "table\nmA",
    "ratio",
    "cools\ns",
    "table\ns",
    "ratio ",
    "lost\nin 1 s",
    "I²R t\n/stored",
)
DOUBT = "No parameter is fitted to a size. ! marks recalled values, whose original was not seen."


def summarise_sizing(sizing: Sizing, chosen: int | None, *, every: bool = False) -> Summary:
    """Return the summary of wires for a request.

    Args:
        sizing: candidates, best first.
        chosen: index of the candidate to describe, or None.
        every: whether to list rejected candidates.
    """
    request = sizing.request
    one = [] if chosen is None else _describe_one(request, chosen + 1, sizing.candidates[chosen])
    data = {
        "request": {name: getattr(request, name) for name in request.declarations},
        "chosen": None if chosen is None else chosen + 1,
        "changes": list(sizing.changes),
        "candidates": [candidate.to_dict() for candidate in sizing.candidates],
    }
    return Summary("", [*_describe_candidates(sizing, chosen, every), *one], data)


def _select_candidates(sizing: Sizing, chosen: int | None, every: bool) -> list[tuple[int, Candidate]]:
    numbered = list(enumerate(sizing.candidates))
    candidates = numbered if every else [(i, one) for i, one in numbered if one.feasible] or numbered[:NEAREST]
    if chosen is not None and chosen not in [i for i, _ in candidates]:
        candidates.append(numbered[chosen])
    return candidates


def _describe_candidates(sizing: Sizing, chosen: int | None, every: bool) -> Iterator[Block]:
    good = any(one.feasible for one in sizing.candidates)
    candidates = _select_candidates(sizing, chosen, every)
    columns = choose_columns(sizing.request)[:-1]
    rows = [_mark_row(list_cells(i + 1, candidate)[:-1], candidate) for i, candidate in candidates]
    if not good:
        yield Sentence("No wire meets the request. The nearest candidates:", "bad")
    yield DataTable(columns, rows, right=(0, *range(4, len(columns))))
    yield from (Sentence(f"Wire {i + 1} rejected: {one.reasons[0]}.") for i, one in candidates if not one.feasible)
    if not good:
        changes = [f"Change that fits: {change}." for change in sizing.changes]
        yield from map(Sentence, changes or [NO_CHANGE])
    if sizing.request.limits == "ignore":
        yield Sentence("The limits of the material are ignored (--no-limits).", "caution")
    if good:
        slow = ", half of the heat loss" if sizing.request.element == "coil" else ""
        yield Sentence(f"* also works at +10 K ambient{slow} and +20 % load.")
    left = len(sizing.candidates) - len(candidates)
    if left:
        yield Sentence(f"{left} candidates rejected: --all lists them with the reasons.")


def _mark_row(cells: Sequence[str], candidate: Candidate) -> tuple[str, ...]:
    return (cells[0] + ("*" if candidate.feasible and not candidate.frail else " "), *cells[1:])


def write_count(sizing: Sizing) -> str:
    """Return the number of candidates that meet the request, and the request."""
    request = sizing.request
    good = sum(candidate.feasible for candidate in sizing.candidates)
    duty = (
        f"{request.force:.4g} N, {1e3 * request.stroke:.4g} mm, {request.rate:.4g} Hz at {request.supply:.4g} V, "
        f"{show_quantity(request.ambient, 'K')}"
    )
    return f"{good} of {len(sizing.candidates)} {request.element}s meet {duty}"


def _describe_one(request: WireRequest, number: int, candidate: Candidate) -> Iterator[Block]:
    yield Heading(f"Wire {number}: {write_headline(candidate)}")
    yield from map(Sentence, list_sentences(request, candidate))
    yield from (Sentence(f"Limit not met: {reason}.", "bad") for reason in candidate.reasons)
    yield from (Sentence(f"Warning: {warning}.", "caution") for warning in (*candidate.warnings, *candidate.frail))
    yield from (Sentence(line, "caution") for line in list_doubts(candidate))


def choose_columns(request: WireRequest) -> tuple[str, ...]:
    """Return the headings of the table of wires, or of coils."""
    return COIL_COLUMNS if request.element == "coil" else COLUMNS


def list_cells(number: int, candidate: Candidate) -> tuple[str, ...]:
    """Return the cells of a candidate under `choose_columns`; the number is its place in the list."""
    static, drive, cycle = candidate.statics, candidate.drive, candidate.cycle
    stress = f"{static.hot_stress / 1e6:.0f}"
    if static.cold_stress < static.hot_stress:
        stress = f"{static.cold_stress / 1e6:.0f}..{stress}"
    electric = ("", "", "")
    if drive is not None:
        electric = (f"{drive.current:.3g}", f"{drive.voltage:.3g}", f"{drive.energy:.3g}")
    times = ("", "")
    if cycle is not None:
        times = (f"{cycle.heating:.2g}", write_seconds(cycle.cooling))
    wiring = "" if candidate.wiring is None or static.count == 1 else f" {candidate.wiring.kind}"
    coil = static.strand.describe_shape(static.cold_stress, static.hot_stress)
    verdict = "yes" if candidate.feasible else "no"
    wire, strands = strip_unit(candidate.size.name), f"{static.count}{wiring}"
    if coil is not None:
        lengths = f"{1e3 * coil['hot_length']:.3g}..{1e3 * coil['cold_length']:.3g}"
        shape = (f"{1e3 * coil['mean_diameter']:.3g}", f"{coil['turns']:.0f}", lengths)
        coils = f"{static.count}{wiring[:4]}"
        return (str(number), wire, candidate.alloy, coils, *shape, stress, electric[0], *times, verdict)
    length = f"{1e3 * static.strand.length:.1f}"
    return (str(number), wire, candidate.alloy, strands, length, stress, *electric, *times, verdict)


def strip_unit(size: str) -> str:
    """Return the name of a size without its unit."""
    return size.removesuffix(" mm")


def write_seconds(time: float | None) -> str:
    """Return a time [s], or `never`."""
    return "never" if time is None else f"{time:.3g}"


def write_headline(candidate: Candidate) -> str:
    """Return the wire in one sentence."""
    static = candidate.statics
    each = "" if static.count == 1 else " each"
    if (coil := static.strand.describe_shape(static.cold_stress, static.hot_stress)) is not None:
        many = "" if static.count == 1 else f"{static.count} parallel coils of "
        return (
            f"{many}Flexinol {candidate.size.name}, {candidate.alloy} °C: {describe_coil(coil)}; "
            f"{static.strand.resistance:.3g} Ω{each}."
        )
    many = "" if static.count == 1 else f"{static.count} strands of "
    return (
        f"{many}Flexinol {candidate.size.name}, {candidate.alloy} °C, "
        f"{1e3 * static.strand.length:.1f} mm{each}: {write_percent(static.strain, 2)} strain over "
        f"the stroke (at most {write_percent(static.reachable, 2)}), "
        f"{static.strand.resistance:.3g} Ω{each}."
    )


def describe_coil(coil: Mapping[str, float]) -> str:
    """Return turns, diameters and lengths of a coil."""
    mm = {name: f"{1e3 * value:.4g}" for name, value in coil.items()}
    return (
        f"{coil['turns']:.4g} turns of {mm['mean_diameter']} mm mean diameter ({mm['outer_diameter']} mm outer), "
        f"{mm['solid_length']} mm solid length; under load {mm['hot_length']} mm hot and {mm['cold_length']} mm cold, "
        f"{coil['hot_rate'] / 1e3:.3g} and {coil['cold_rate'] / 1e3:.3g} N/mm"
    )


def list_sentences(request: WireRequest, candidate: Candidate) -> Iterator[str]:
    """Yield return element, margins, pulse, temperatures, life, and the maker's values."""
    yield _tell_return(request, candidate)
    yield _tell_margins(request, candidate)
    if candidate.cycle is not None:
        yield from _tell_pulse(request, candidate, candidate.cycle)
    yield f"Life: {candidate.life}."
    yield COIL_DOUBT if request.element == "coil" else _tell_catalogue(candidate)


def _tell_return(request: WireRequest, candidate: Candidate) -> str:
    static = candidate.statics
    if static.stiffness > 0.0:
        return (
            f"Return spring: preload {static.preload:.4g} N, rate {static.stiffness / 1e3:.4g} N/mm. At the end of the "
            f"stroke the wire pulls {static.work_force:.4g} N, including {request.force:.4g} N for the load."
        )
    extra = f", including {static.extra:.4g} N that only stretch the wire" if static.extra > 0.0 else ""
    return f"Return weight: {static.preload:.4g} N{extra}."


def _tell_margins(request: WireRequest, candidate: Candidate) -> str:
    static = candidate.statics
    finish = static.strand.shift_temperature("M_f", static.cold_stress) - request.ambient
    return (
        f"Margins: stress {static.hot_stress / 1e6:.4g} MPa of {request.stress / 1e6:.4g} MPa "
        f"({write_percent(1.0 - static.hot_stress / request.stress)} left), strain "
        f"{write_percent(static.strain, 2)} of {write_percent(request.strain, 2)}, "
        f"M_f {finish:.1f} K above the ambient."
    )


def _tell_pulse(request: WireRequest, candidate: Candidate, cycle: PulseCycle) -> list[str]:
    drive, static = candidate.drive, candidate.statics
    if drive is None:
        return []
    each = f" ({cycle.current:.3g} A each)" if static.count > 1 else ""
    running = ""
    if cycle.running is not None:
        running = f" in the first cycle, {cycle.running - 273.15:.0f} °C in repeated cycles"
    cooling = write_seconds(cycle.cooling) + ("" if cycle.cooling is None else " s")
    duty = (drive.voltage / request.supply) ** 2
    lines = [
        f"Pulse: {drive.current:.3g} A{each} at {drive.voltage:.3g} V, {drive.power:.3g} W for "
        f"{cycle.heating:.3g} s, {drive.energy:.3g} J per cycle. From {request.supply:.4g} V: PWM with "
        f"{write_percent(duty)} duty cycle and peaks of {drive.current * request.supply / drive.voltage:.3g} A.",
        f"Temperature: up to {cycle.hottest - 273.15:.0f} °C{running}. Cooling time: {cooling}. Continuous rating: "
        f"{candidate.overheating_current:.3g} A per strand, which heats the wire to its limit of "
        f"{candidate.temperature_limit - 273.15:.4g} °C.",
    ]
    if cycle.fastest is not None:
        lines.append(f"Maximum rate with this pulse: {cycle.fastest:.3g} Hz (requested: {request.rate:.4g} Hz).")
    return lines


def _tell_catalogue(candidate: Candidate) -> str:
    cooling = candidate.size.cooling_70 if candidate.alloy == "70" else candidate.size.cooling_90
    return (
        f"Maker's table for this size: {_write_cell(candidate.size.current)} for contraction in 1 s, "
        f"cooling time {_write_cell(cooling)}, under the maker's conditions."
    )


def _write_cell(cell: MaterialNumber) -> str:
    return f"{cell.text} ({cell.kind})"


def list_doubts(candidate: Candidate) -> list[str]:
    """Return sentences on assumed or recalled values of a candidate."""
    name = f"flexinol-{candidate.alloy}"
    numbers = load_material(name).values.items()
    doubtful = [key for key, number in numbers if number.kind in DOUBTFUL]
    lines = [f"Assumed or recalled values of {name}: {', '.join(doubtful)}."]
    if candidate.recalled:
        lines.insert(0, f"Recalled or interpolated values of the catalogue: {', '.join(candidate.recalled)}.")
    return lines


def summarise_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> Summary:
    """Return the model and the maker's table under a stress [Pa] in still air [K]."""
    blocks = [
        Sentence(write_conditions(stress, ambient)),
        DataTable(CHECKED, [list_check_cells(row) for row in rows], right=range(2, len(CHECKED))),
        *map(Sentence, list_spreads(rows)),
        Sentence(DOUBT, "caution"),
    ]
    return Summary("", blocks, collect_check(rows, stress, ambient))


def write_conditions(stress: float, ambient: float) -> str:
    """Return the conditions [Pa, K] of the comparison."""
    return (
        f"Model compared with the maker's table: load {stress / 1e6:.4g} MPa, still air at "
        f"{ambient - 273.15:.4g} °C, vertical wire, cooling until 0.5 % of the stroke is left."
    )


def collect_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> dict[str, Any]:
    """Return all results in SI."""
    extra = ("current_ratio", "cooling_ratio")
    return {
        "stress": stress,
        "ambient": ambient,
        "rows": [asdict(row) | {name: getattr(row, name) for name in extra} for row in rows],
        "spread": {alloy: _collect_spreads(rows, alloy) for alloy in _list_alloys(rows)},
    }


def _list_alloys(rows: Sequence[CheckRow]) -> list[str]:
    return list(dict.fromkeys(row.alloy for row in rows))


def _collect_spreads(rows: Sequence[CheckRow], alloy: str) -> dict[str, RatioSpread | None]:
    own = [row for row in rows if row.alloy == alloy]
    return {
        "current": summarise_ratios([row.current_ratio for row in own]),
        "cooling": summarise_ratios([row.cooling_ratio for row in own]),
    }


def list_spreads(rows: Sequence[CheckRow]) -> list[str]:
    """Return the spread of the ratios for each alloy and quantity."""
    return [
        f"{alloy} °C, {name}: model/catalogue {spread.least:.2f} to {spread.most:.2f}, geometric mean {spread.mean:.2f}"
        for alloy in _list_alloys(rows)
        for name, spread in _collect_spreads(rows, alloy).items()
        if spread is not None
    ]


def list_check_cells(row: CheckRow) -> tuple[str, ...]:
    """Return the cells of a row under `CHECKED`."""
    ratio = row.cooling_ratio
    return (
        strip_unit(row.size),
        row.alloy,
        f"{1e3 * row.current:.0f}",
        _mark_cell(row.current_cell, 1e3),
        f"{row.current_ratio:.2f}",
        write_seconds(row.cooling),
        _mark_cell(row.cooling_cell, 1.0),
        "" if ratio is None else f"{ratio:.2f}",
        write_percent(row.loss_share),
        f"{row.stored_share:.2f}",
    )


def _mark_cell(cell: MaterialNumber, scale: float) -> str:
    return ("! " if cell.kind in DOUBTFUL else "") + f"{scale * cell.value:.4g}"
