"""What `size` prints: the candidates, one of them in words, the check of the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from martensite.cli import show

if TYPE_CHECKING:
    from martensite.materials.base import Number
    from martensite.sizing.candidates import Candidate, Sizing
    from martensite.sizing.catalogue_check import CheckRow, Spread
    from martensite.sizing.cycle import Cycle
    from martensite.sizing.request import WireRequest

COLUMNS = ("", "wire\nmm", "alloy\n°C", "strands", "length\nmm", "stress\nMPa", "pulse\nA",
           "\nV", "cycle\nJ", "heats\ns", "cools\ns", "verdict")  # fmt: skip
RIGHT = ",".join(COLUMNS[:1] + COLUMNS[4:-1])
NEAREST = 5
"""Wires that do not do and are shown if none does."""
CHECKED = ("wire\nmm", "alloy\n°C", "1 s pulse\nmA", "table\nmA", "ratio", "cools\ns", "table\ns",
           "ratio ", "lost\nin 1 s", "I²R t\n/stored")  # fmt: skip


# ---------------------------------------------------------------- candidates


def report(sizing: Sizing, chosen: int | None, files: list[str]) -> dict[str, Any]:
    """Everything in SI."""
    request = sizing.request
    return {
        "request": {name: getattr(request, name) for name in request.declarations},
        "chosen": None if chosen is None else chosen + 1,
        "candidates": [candidate.to_dict() for candidate in sizing.candidates],
        "files": files,
    }


def show_candidates(sizing: Sizing, every: bool, chosen: int | None) -> None:
    """Print the table of wires: those that do, or all, or the nearest."""
    numbered = list(enumerate(sizing.candidates))
    good = [(i, found) for i, found in numbered if found.feasible]
    shown = numbered if every else good or numbered[:NEAREST]
    if chosen is not None and chosen not in [i for i, _ in shown]:
        shown.append(numbered[chosen])
    show.table(COLUMNS, [_row(i + 1, found) for i, found in shown], right=RIGHT)
    for i, found in shown:
        if not found.feasible:
            show.text(f"{i + 1} does not: {found.reasons[0]}.")
    left = len(numbered) - len(shown)
    if not good:
        show.text("No wire meets the request; the nearest come first.", "yellow")
    if left:
        show.text(f"{left} more do not do; --all shows them with the reason.")


def _row(number: int, found: Candidate) -> tuple[str, ...]:
    static, drive, cycle = found.statics, found.drive, found.cycle
    stress = f"{static.hot_stress / 1e6:.0f}"
    if static.cold_stress < static.hot_stress:
        stress = f"{static.cold_stress / 1e6:.0f}..{stress}"
    electric = ("", "", "")
    if drive is not None:
        electric = (f"{drive.current:.3g}", f"{drive.voltage:.3g}", f"{drive.energy:.3g}")
    times = ("", "")
    if cycle is not None:
        times = (f"{cycle.heating:.2g}", _seconds(cycle.cooling))
    wiring = "" if found.wiring is None or static.count == 1 else f" {found.wiring.kind}"
    verdict = "does" if found.feasible else "no"
    wire, strands = _bare(found.size.name), f"{static.count}{wiring}"
    length = f"{1e3 * static.strand.length:.1f}"
    return (str(number), wire, found.alloy, strands, length, stress, *electric, *times, verdict)


def _bare(size: str) -> str:
    """Name of a size without the unit that the heading has."""
    return size.removesuffix(" mm")


def _seconds(time: float | None) -> str:
    return "never" if time is None else f"{time:.3g}"


def _percent(share: float, digits: int = 0) -> str:
    return f"{100.0 * share:.{digits}f} %"


def show_one(sizing: Sizing, chosen: int) -> None:
    """Print one candidate in words."""
    found, request = sizing.candidates[chosen], sizing.request
    static = found.statics
    each = "" if static.count == 1 else " each"
    many = "" if static.count == 1 else f"{static.count} strands of "
    show.text(
        f"{many}Flexinol {found.size.name}, {found.alloy} °C, "
        f"{1e3 * static.strand.length:.1f} mm{each}: {_percent(static.strain, 2)} strain over "
        f"the stroke (at most {_percent(static.reachable, 2)}), "
        f"{static.strand.resistance:.3g} ohm{each}.", "bold",
    )  # fmt: skip
    show.text(_return(request, found))
    show.text(_margins(request, found))
    if found.cycle is not None:
        for line in _electric(request, found, found.cycle):
            show.text(line)
    show.text(f"Life: {found.life}.")
    show.text(_catalogue_says(found))
    for reason in found.reasons:
        show.text(f"Not met: {reason}.", "red")
    for warning in found.warnings:
        show.text(f"Warning: {warning}.", "yellow")
    for line in _doubts(found):
        show.text(line, "yellow")


def _return(request: WireRequest, found: Candidate) -> str:
    static = found.statics
    if static.stiffness > 0.0:
        return (
            f"Return spring: preload {static.preload:.4g} N, rate {static.stiffness / 1e3:.4g} "
            f"N/mm; at the end of the stroke the wire pulls {static.work_force:.4g} N, "
            f"{request.force:.4g} N of it for the load."
        )
    extra = f", of which {static.extra:.4g} N only stretch the wire" if static.extra > 0.0 else ""
    return f"Return by a weight of {static.preload:.4g} N{extra}."


def _margins(request: WireRequest, found: Candidate) -> str:
    static = found.statics
    finish = static.strand.shifted("M_f", static.cold_stress) - request.ambient
    return (
        f"Margins: stress {static.hot_stress / 1e6:.4g} MPa of {request.stress / 1e6:.4g} MPa "
        f"({_percent(1.0 - static.hot_stress / request.stress)} left), strain "
        f"{_percent(static.strain, 2)} of {_percent(request.strain, 2)}, "
        f"M_f {finish:.1f} K above the ambient."
    )


def _electric(request: WireRequest, found: Candidate, cycle: Cycle) -> list[str]:
    drive, static = found.drive, found.statics
    if drive is None:
        return []
    each = f" ({cycle.current:.3g} A per strand)" if static.count > 1 else ""
    running = ""
    if cycle.running is not None:
        running = f" in the first cycle, {cycle.running - 273.15:.0f} °C when it is repeated"
    cooling = _seconds(cycle.cooling) + ("" if cycle.cooling is None else " s")
    duty = (drive.voltage / request.supply) ** 2
    lines = [
        f"Pulse: {drive.current:.3g} A{each} at {drive.voltage:.3g} V, {drive.power:.3g} W for "
        f"{cycle.heating:.3g} s, {drive.energy:.3g} J per cycle; switched straight from "
        f"{request.supply:.4g} V it is a PWM of {_percent(duty)} duty with peaks of "
        f"{drive.current * request.supply / drive.voltage:.3g} A.",
        f"Up to {cycle.hottest - 273.15:.0f} °C{running}; cooling {cooling}; in the "
        f"long run {found.overheating_current:.3g} A per strand bring the wire to its limit of "
        f"{found.temperature_limit - 273.15:.4g} °C.",
    ]
    if cycle.fastest is not None:
        asked = f"{request.rate:.4g} Hz are asked for"
        lines.append(f"Fastest cycle with this pulse: {cycle.fastest:.3g} Hz; {asked}.")
    return lines


def _catalogue_says(found: Candidate) -> str:
    cooling = found.size.cooling_70 if found.alloy == "70" else found.size.cooling_90
    return (
        f"The maker's table for this size: {_cell(found.size.current)} for contraction in 1 s, "
        f"{_cell(cooling)} of cooling, under its own conditions."
    )


def _cell(cell: Number) -> str:
    return f"{cell.text} ({cell.kind})"


def _doubts(found: Candidate) -> list[str]:
    from martensite.materials.base import DOUBTFUL, load_material

    name = f"flexinol-{found.alloy}"
    numbers = load_material(name).values.items()
    doubtful = [key for key, number in numbers if number.kind in DOUBTFUL]
    lines = [f"Assumed or recalled numbers of {name}: {', '.join(doubtful)}."]
    if found.recalled:
        lines.insert(0, f"Recalled cells of the catalogue: {', '.join(found.recalled)}.")
    return lines


# ---------------------------------------------------------------- the check of the catalogue


def check_report(rows: Sequence[CheckRow], stress: float, ambient: float) -> dict[str, Any]:
    """Everything in SI."""
    from dataclasses import asdict

    extra = ("current_ratio", "cooling_ratio")
    return {
        "stress": stress,
        "ambient": ambient,
        "rows": [asdict(row) | {name: getattr(row, name) for name in extra} for row in rows],
        "spread": {alloy: _spreads(rows, alloy) for alloy in _alloys(rows)},
    }


def _alloys(rows: Sequence[CheckRow]) -> list[str]:
    return list(dict.fromkeys(row.alloy for row in rows))


def _spreads(rows: Sequence[CheckRow], alloy: str) -> dict[str, Spread | None]:
    from martensite.sizing.catalogue_check import spread

    own = [row for row in rows if row.alloy == alloy]
    return {
        "current": spread([row.current_ratio for row in own]),
        "cooling": spread([row.cooling_ratio for row in own]),
    }


def show_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> None:
    """Print the model beside the maker's table."""
    show.text(
        f"The model beside the maker's table: a weight of {stress / 1e6:.4g} MPa, still air of "
        f"{ambient - 273.15:.4g} °C, vertical wire, the last 0.5 % of deformation not counted."
    )
    show.table(CHECKED, [_checked(row) for row in rows], right=",".join(CHECKED[2:]))
    for alloy in _alloys(rows):
        for name, found in _spreads(rows, alloy).items():
            if found is not None:
                show.text(
                    f"{alloy} °C, {name}: model/catalogue {found.least:.2f} to {found.most:.2f}, "
                    f"geometric mean {found.mean:.2f}"
                )
    show.text("No number is fitted to a size. ! recalled: the original was not seen", "yellow")


def _checked(row: CheckRow) -> tuple[str, ...]:
    ratio = row.cooling_ratio
    return (
        _bare(row.size), row.alloy, f"{1e3 * row.current:.0f}", _marked(row.current_cell, 1e3),
        f"{row.current_ratio:.2f}", _seconds(row.cooling), _marked(row.cooling_cell, 1.0),
        "" if ratio is None else f"{ratio:.2f}", _percent(row.loss_share),
        f"{row.stored_share:.2f}",
    )  # fmt: skip


def _marked(cell: Number, scale: float) -> str:
    from martensite.materials.base import DOUBTFUL

    return ("! " if cell.kind in DOUBTFUL else "") + f"{scale * cell.value:.4g}"
