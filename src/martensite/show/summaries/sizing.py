"""Wires for a request: a table of them, one of them in words; and the model beside the maker's table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from martensite.base.formats import write_percent
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.design.sizing.candidates import Candidate, Sizing
from martensite.design.sizing.catalogue_check import CheckRow, RatioSpread, summarise_ratios
from martensite.design.sizing.cycle import PulseCycle
from martensite.design.sizing.remarks import COIL_DOUBT
from martensite.design.sizing.request import WireRequest
from martensite.physics.materials.base import DOUBTFUL, MaterialNumber, load_material

NEAREST = 5
"""Wires that do not do and are shown if none does."""
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
"""So narrow that the table of wires stands side by side in 80 columns."""
_SHAPE = ("\n°C", "coils", "D\nmm", "turns", "length\nmm")
COIL_COLUMNS = (*COLUMNS[:2], *_SHAPE, *COLUMNS[5:7], *COLUMNS[9:])
"""Columns of coils: mean diameter, and the length under load, hot and cold."""
CHECKED = (
    "wire\nmm",
    "alloy\n°C",
    "1 s pulse\nmA",
    "table\nmA",
    "ratio",
    "cools\ns",
    "table\ns",
    "ratio ",
    "lost\nin 1 s",
    "I²R t\n/stored",
)
DOUBT = "No number is fitted to a size. ! recalled: the original was not seen"


def summarise_sizing(sizing: Sizing, chosen: int | None, *, every: bool = False) -> Summary:
    """Everything about wires for a request, one described by its place; with `every` also those that do not do."""
    request = sizing.request
    one = [] if chosen is None else _describe_one(request, sizing.candidates[chosen])
    data = {
        "request": {name: getattr(request, name) for name in request.declarations},
        "chosen": None if chosen is None else chosen + 1,
        "changes": list(sizing.changes),
        "candidates": [candidate.to_dict() for candidate in sizing.candidates],
    }
    return Summary("", [*_describe_candidates(sizing, chosen, every), *one], data)


def _describe_candidates(sizing: Sizing, chosen: int | None, every: bool) -> Iterator[Block]:
    numbered = list(enumerate(sizing.candidates))
    good = [(i, found) for i, found in numbered if found.feasible]
    shown = numbered if every else good or numbered[:NEAREST]
    if chosen is not None and chosen not in [i for i, _ in shown]:
        shown.append(numbered[chosen])
    rows = [list_cells(i + 1, found) for i, found in shown]
    columns = choose_columns(sizing.request)
    yield DataTable(columns, rows, right=(0, *range(4, len(columns) - 1)))
    for i, found in shown:
        if not found.feasible:
            yield Sentence(f"{i + 1} does not: {found.reasons[0]}.")
    if not good:
        yield Sentence("No wire meets the request; the nearest come first.", "caution")
        yield from (Sentence(f"What would fit: {change}.") for change in sizing.changes)
        if not sizing.changes:
            yield Sentence("More strands, a lower rate or a higher voltage would not help; ask for less.")
    if sizing.request.limits == "ignore":
        yield Sentence("The limits of the material are ignored, as asked.", "caution")
    robust = sum(not found.frail for _, found in good)
    if good:
        some = "The first" if robust == 1 else f"The first {robust}" if robust else "None of them"
        who = "All of them" if robust == len(good) else some
        slow = ", with half of the heat loss," if sizing.request.element == "coil" else ""
        yield Sentence(f"{who} would also return on a day 10 K warmer{slow} and carry 20 % more load.")
    left = len(numbered) - len(shown)
    if left:
        yield Sentence(f"{left} more do not do; --all shows them with the reason.")


def _describe_one(request: WireRequest, found: Candidate) -> Iterator[Block]:
    yield Heading(write_headline(found))
    yield from map(Sentence, list_sentences(request, found))
    yield from (Sentence(f"Not met: {reason}.", "bad") for reason in found.reasons)
    yield from (Sentence(f"Warning: {warning}.", "caution") for warning in (*found.warnings, *found.frail))
    yield from (Sentence(line, "caution") for line in list_doubts(found))


def choose_columns(request: WireRequest) -> tuple[str, ...]:
    """Return the headings of the table of wires, or of coils."""
    return COIL_COLUMNS if request.element == "coil" else COLUMNS


def list_cells(number: int, found: Candidate) -> tuple[str, ...]:
    """Return the cells of a candidate below the columns of `choose_columns`; the number is the place in the list."""
    static, drive, cycle = found.statics, found.drive, found.cycle
    stress = f"{static.hot_stress / 1e6:.0f}"
    if static.cold_stress < static.hot_stress:
        stress = f"{static.cold_stress / 1e6:.0f}..{stress}"
    electric = ("", "", "")
    if drive is not None:
        electric = (f"{drive.current:.3g}", f"{drive.voltage:.3g}", f"{drive.energy:.3g}")
    times = ("", "")
    if cycle is not None:
        times = (f"{cycle.heating:.2g}", write_seconds(cycle.cooling))
    wiring = "" if found.wiring is None or static.count == 1 else f" {found.wiring.kind}"
    coil = static.strand.describe_shape(static.cold_stress, static.hot_stress)
    verdict = "does" if found.feasible else "no"
    wire, strands = strip_unit(found.size.name), f"{static.count}{wiring}"
    if coil is not None:
        lengths = f"{1e3 * coil['hot_length']:.3g}..{1e3 * coil['cold_length']:.3g}"
        shape = (f"{1e3 * coil['mean_diameter']:.3g}", f"{coil['turns']:.0f}", lengths)
        coils = f"{static.count}{wiring[:4]}"
        return (str(number), wire, found.alloy, coils, *shape, stress, electric[0], *times, verdict)
    length = f"{1e3 * static.strand.length:.1f}"
    return (str(number), wire, found.alloy, strands, length, stress, *electric, *times, verdict)


def strip_unit(size: str) -> str:
    """Return the name of a size without the unit that the heading has."""
    return size.removesuffix(" mm")


def write_seconds(time: float | None) -> str:
    """Return a time [s], or that it never comes."""
    return "never" if time is None else f"{time:.3g}"


def write_headline(found: Candidate) -> str:
    """Return the wire in one sentence."""
    static = found.statics
    each = "" if static.count == 1 else " each"
    if (coil := static.strand.describe_shape(static.cold_stress, static.hot_stress)) is not None:
        many = "" if static.count == 1 else f"{static.count} coils side by side of "
        return (
            f"{many}Flexinol {found.size.name}, {found.alloy} °C: {describe_coil(coil)}; "
            f"{static.strand.resistance:.3g} ohm{each}."
        )
    many = "" if static.count == 1 else f"{static.count} strands of "
    return (
        f"{many}Flexinol {found.size.name}, {found.alloy} °C, "
        f"{1e3 * static.strand.length:.1f} mm{each}: {write_percent(static.strain, 2)} strain over "
        f"the stroke (at most {write_percent(static.reachable, 2)}), "
        f"{static.strand.resistance:.3g} ohm{each}."
    )


def describe_coil(coil: Mapping[str, float]) -> str:
    """Turns, diameters and lengths of a coil."""
    mm = {name: f"{1e3 * value:.4g}" for name, value in coil.items()}
    return (
        f"{coil['turns']:.4g} turns of {mm['mean_diameter']} mm between centres ({mm['outer_diameter']} mm over all), "
        f"{mm['solid_length']} mm when closed; under load {mm['hot_length']} mm hot and {mm['cold_length']} mm cold, "
        f"{coil['hot_rate'] / 1e3:.3g} and {coil['cold_rate'] / 1e3:.3g} N/mm"
    )


def list_sentences(request: WireRequest, found: Candidate) -> Iterator[str]:
    """Return, margins, pulse, temperatures, life, and what the maker's table says."""
    yield _tell_return(request, found)
    yield _tell_margins(request, found)
    if found.cycle is not None:
        yield from _tell_pulse(request, found, found.cycle)
    yield f"Life: {found.life}."
    yield COIL_DOUBT if request.element == "coil" else _tell_catalogue(found)


def _tell_return(request: WireRequest, found: Candidate) -> str:
    static = found.statics
    if static.stiffness > 0.0:
        return (
            f"Return spring: preload {static.preload:.4g} N, rate {static.stiffness / 1e3:.4g} "
            f"N/mm; at the end of the stroke the wire pulls {static.work_force:.4g} N, "
            f"{request.force:.4g} N of it for the load."
        )
    extra = f", of which {static.extra:.4g} N only stretch the wire" if static.extra > 0.0 else ""
    return f"Return by a weight of {static.preload:.4g} N{extra}."


def _tell_margins(request: WireRequest, found: Candidate) -> str:
    static = found.statics
    finish = static.strand.shifted("M_f", static.cold_stress) - request.ambient
    return (
        f"Margins: stress {static.hot_stress / 1e6:.4g} MPa of {request.stress / 1e6:.4g} MPa "
        f"({write_percent(1.0 - static.hot_stress / request.stress)} left), strain "
        f"{write_percent(static.strain, 2)} of {write_percent(request.strain, 2)}, "
        f"M_f {finish:.1f} K above the ambient."
    )


def _tell_pulse(request: WireRequest, found: Candidate, cycle: PulseCycle) -> list[str]:
    drive, static = found.drive, found.statics
    if drive is None:
        return []
    each = f" ({cycle.current:.3g} A each)" if static.count > 1 else ""
    running = ""
    if cycle.running is not None:
        running = f" in the first cycle, {cycle.running - 273.15:.0f} °C when it is repeated"
    cooling = write_seconds(cycle.cooling) + ("" if cycle.cooling is None else " s")
    duty = (drive.voltage / request.supply) ** 2
    lines = [
        f"Pulse: {drive.current:.3g} A{each} at {drive.voltage:.3g} V, {drive.power:.3g} W for "
        f"{cycle.heating:.3g} s, {drive.energy:.3g} J per cycle; switched straight from "
        f"{request.supply:.4g} V it is a PWM of {write_percent(duty)} duty with peaks of "
        f"{drive.current * request.supply / drive.voltage:.3g} A.",
        f"Up to {cycle.hottest - 273.15:.0f} °C{running}; cooling {cooling}; in the "
        f"long run {found.overheating_current:.3g} A per strand bring the wire to its limit of "
        f"{found.temperature_limit - 273.15:.4g} °C.",
    ]
    if cycle.fastest is not None:
        asked = f"{request.rate:.4g} Hz are asked for"
        lines.append(f"Fastest cycle with this pulse: {cycle.fastest:.3g} Hz; {asked}.")
    return lines


def _tell_catalogue(found: Candidate) -> str:
    cooling = found.size.cooling_70 if found.alloy == "70" else found.size.cooling_90
    return (
        f"The maker's table for this size: {_write_cell(found.size.current)} for contraction in "
        f"1 s, {_write_cell(cooling)} of cooling, under its own conditions."
    )


def _write_cell(cell: MaterialNumber) -> str:
    return f"{cell.text} ({cell.kind})"


def list_doubts(found: Candidate) -> list[str]:
    """Which numbers behind it are assumed or recalled."""
    name = f"flexinol-{found.alloy}"
    numbers = load_material(name).values.items()
    doubtful = [key for key, number in numbers if number.kind in DOUBTFUL]
    lines = [f"Assumed or recalled numbers of {name}: {', '.join(doubtful)}."]
    if found.recalled:
        lines.insert(0, f"Recalled or interpolated cells of the catalogue: {', '.join(found.recalled)}.")
    return lines


def summarise_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> Summary:
    """Return the model beside the maker's table, under a stress [Pa] in still air [K]."""
    blocks = [
        Sentence(write_conditions(stress, ambient)),
        DataTable(CHECKED, [list_check_cells(row) for row in rows], right=range(2, len(CHECKED))),
        *map(Sentence, list_spreads(rows)),
        Sentence(DOUBT, "caution"),
    ]
    return Summary("", blocks, collect_check(rows, stress, ambient))


def write_conditions(stress: float, ambient: float) -> str:
    """Under which conditions [Pa, K] the model is set beside the table."""
    return (
        f"The model beside the maker's table: a weight of {stress / 1e6:.4g} MPa, still air of "
        f"{ambient - 273.15:.4g} °C, vertical wire, the last 0.5 % of deformation not counted."
    )


def collect_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> dict[str, Any]:
    """Return everything in SI."""
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
        f"{alloy} °C, {name}: model/catalogue {found.least:.2f} to {found.most:.2f}, geometric mean {found.mean:.2f}"
        for alloy in _list_alloys(rows)
        for name, found in _collect_spreads(rows, alloy).items()
        if found is not None
    ]


def list_check_cells(row: CheckRow) -> tuple[str, ...]:
    """Return the cells of a row below `COLUMNS`."""
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
