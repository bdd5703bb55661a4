"""Scenario files of sized and rated wires, with the origin of each number."""

from __future__ import annotations

import math
from typing import Any

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.base.errors import InputError
from martensite.base.parameters import Parametrised
from martensite.base.toml_text import toml_value
from martensite.design.sizing.candidates import Candidate, Drive
from martensite.design.sizing.cycle import PulseCycle
from martensite.design.sizing.remarks import COIL_DOUBT
from martensite.design.sizing.request import WireRequest
from martensite.design.sizing.statics import CoilStrand, Strand
from martensite.design.sizing.wire_ratings import WireRatings
from martensite.physics.materials.wires import GRAVITY, Cell, WireCatalogue

CYCLES = 3
SAMPLES = 3001


def format_scenario(request: WireRequest, candidate: Candidate, catalogue: WireCatalogue) -> str:
    """Return a scenario with some cycles of a candidate at the requested rate, or its fastest.

    Raises:
        InputError: the candidate has no cycle.
    """
    cycle, drive = candidate.cycle, candidate.drive
    if cycle is None or drive is None or cycle.fastest is None:
        raise InputError(
            f"Wire of {candidate.size.name}, {candidate.alloy} °C, makes no cycle, so there is no "
            f"scenario of it: {candidate.reasons[0]}."
        )
    rate = min(request.rate, cycle.fastest)
    parts = [
        _format_head(request, candidate),
        _format_element(candidate, catalogue),
        format_environment(candidate.statics.strand),
        _format_mechanism(request, candidate),
        _format_drive(request, drive, cycle, rate),
        f'[run]\nduration = "{CYCLES / rate:.9g} s"\nsamples = {SAMPLES}\n',
    ]
    return "\n".join(parts)


def _format_head(request: WireRequest, candidate: Candidate) -> str:
    duty = (
        f"{request.force:.6g} N over {1e3 * request.stroke:.6g} mm at {request.rate:.6g} Hz from {request.supply:.6g} V"
    )
    wire = f"{_count_samples(candidate)}Flexinol {candidate.size.name}, {candidate.alloy} °C"
    lines = [f"# Sized for {duty}: {wire}."]
    lines += [f"# Not met: {reason}." for reason in candidate.reasons]
    lines += [f"# Beware: {warning}." for warning in (*candidate.warnings, *candidate.frail)]
    lines += [f"# {COIL_DOUBT}"] * (request.element == "coil")
    return "\n".join([*lines, f'title = "{wire}: {duty}"', ""])


def _count_samples(candidate: Candidate) -> str:
    wiring = candidate.wiring
    if wiring is None or wiring.count == 1:
        return ""
    return f"{wiring.count} in {wiring.kind}, "  # electrically; they pull side by side


def _format_element(candidate: Candidate, catalogue: WireCatalogue) -> str:
    static, wiring = candidate.statics, candidate.wiring
    why = f"the stroke at {100.0 * static.strain:.4g} % strain"
    if wiring is None or wiring.count == 1:
        return f'[element]\nmaterial = "flexinol-{candidate.alloy}"\n{format_strand(static.strand, catalogue, why)}'
    head = f'kind = "bundle"\ncount = {wiring.count}\nwiring = "{wiring.kind}"\nmaterial = "flexinol-{candidate.alloy}"'
    strand = format_strand(static.strand, catalogue, why, "element.strand")
    return f"[element]\n{head}\n\n[element.strand]\n{strand}"


def format_strand(strand: Strand, catalogue: WireCatalogue, why: str, own: str = "element") -> str:
    """Return the lines of a strand and the section `own`.resistance; `why` explains the length."""
    size, ohms = strand.size, strand.size.resistance.text
    lines = ['kind = "wire"']
    shape = [f'length = "{1e3 * strand.length:.12g} mm"   # computed: {why}']
    if isinstance(strand, CoilStrand):
        lines = ['kind = "coil-spring"', f"turns = {strand.turns:.9g}   # computed: {why}"]
        shape = [
            f'coil_diameter = "{1e3 * strand.coil_diameter:.9g} mm"   # index {strand.index:.4g}',
            'coil_measure = "mean"',
            f'free_length = "{1e3 * strand.solid:.12g} mm"   # hot and unloaded: closed',
            'deflection = "large"',
            'stress_factor = "wahl"   # the inner fibre drives the law, and meets the limit',
        ]
    return "\n".join(
        [
            *lines,
            f'diameter = "{size.diameter.text}"   # {_describe_origin(size.diameter, catalogue)}',
            *shape,
            'law = { kind = "liang-rogers", modulus = "mixture" }',
            "",
            f"[{own}.resistance]   # {_describe_origin(size.resistance, catalogue)}",
            'kind = "per-length"',
            f'r_A = "{ohms}"',
            f'r_M = "{ohms}"   # one value for both phases',
            "",
        ]
    )


def _describe_origin(cell: Cell, catalogue: WireCatalogue) -> str:
    """Return kind, source and note of a cell."""
    origin = f"{cell.kind}, {catalogue.sources[cell.source].cite}" if cell.source else cell.kind
    return f"{origin}: {cell.note}" if cell.note else origin


def format_environment(strand: Strand) -> str:
    """Return the section of the environment of a strand."""
    ambient, cooling = strand.ambient - 273.15, toml_value(_describe_part(strand.cooling))
    return f'[environment]\ntemperature = "{ambient:.12g} degC"\ncooling = {cooling}\n'


def _describe_part(part: Parametrised) -> dict[str, Any]:
    """Return a part as a table: kind, changed parameters, and nested parts."""
    numbers = {name: d for name, d in part.declarations.items() if d.kind == "parameter"}
    changed = {n: f"{getattr(part, n):.9g} {d.unit}" for n, d in numbers.items() if getattr(part, n) != d.default}
    inner = {name: _describe_part(child) for name, child in part.children()}
    return {"kind": part.registered_name, **changed, **inner}


def _format_mechanism(request: WireRequest, candidate: Candidate) -> str:
    static = candidate.statics
    if static.stiffness == 0.0:
        kilograms = static.preload / GRAVITY
        note = f"{request.force:.4g} N of load"
        if static.extra > 0.0:
            note += f" and {static.extra:.4g} N more, to stretch the cold wire"
        return f'[mechanism]\nkind = "dead-weight"\nmass = "{kilograms:.12g} kg"   # {note}\n'
    rate = (static.work_force - static.preload) / request.stroke
    return "\n".join(
        [
            "[mechanism]   # return spring and load in one",
            'kind = "bias-spring"',
            f'preload = "{static.preload:.12g} N"   # of the return spring',
            f'stiffness = "{rate:.12g} N/m"   # {static.stiffness:.4g} N/m of the return spring, '
            f"and the load: {request.force:.4g} N at {1e3 * request.stroke:.4g} mm",
            "",
        ]
    )


def _format_drive(request: WireRequest, drive: Drive, cycle: PulseCycle, rate: float) -> str:
    lines = [
        "[drive]   # each pulse ends when the stroke is reached for the first time",
        'kind = "current"',
        f'voltage_limit = "{request.supply:.12g} V"',
    ]
    if math.isfinite(request.current_limit):
        lines.append(f'current_limit = "{request.current_limit:.12g} A"')
    if rate < request.rate:
        lines.append(f"# {request.rate:.4g} Hz are not reached; this is the fastest cycle")
    duty = cycle.heating * rate
    wave = f'kind = "pwm", high = "{drive.current:.9g} A", frequency = "{rate:.9g} Hz"'
    return "\n".join([*lines, f"waveform = {{ {wave}, duty = {duty:.9g} }}", ""])


def format_ratings(ratings: WireRatings, catalogue: WireCatalogue) -> str:
    """Return a scenario with two pulses through an existing wire or coil, and its load."""
    wire, strand, cycle = ratings.wire, ratings.strand, ratings.cycle
    title = f"{ratings.size.name}, {wire.alloy} °C, at {wire.supply:.4g} V"
    current, heating = 0.999 * ratings.supply_current, ratings.supply_time or wire.pulse
    if cycle is not None and ratings.drivable:
        current, heating = cycle.current, cycle.heating
    period = 1.1 * heating + max(1.5 * (cycle.cooling or 0.0) if cycle else 0.0, 6.0 * strand.time_constant())
    wave = f'kind = "pwm", high = "{current:.6g} A", frequency = "{1.0 / period:.6g} Hz", duty = {heating / period:.6g}'
    note = ""
    if ratings.drawn_coil and isinstance(strand, CoilStrand):
        note = (
            f"# It closes at {1e3 * strand.solid:.4g} mm, turns times diameter, which is in the coil itself. The stop "
            f"that holds it at {1e3 * ratings.drawn_coil.length:.4g} mm when cold is in no mechanism: a run begins "
            "where the load draws it to.\n"
        )
    notes = [f"# Does not do: {fault}." for fault in ratings.faults]
    notes += [f"# {COIL_DOUBT}"] * isinstance(strand, CoilStrand)
    return "\n".join(
        [
            *notes,
            f'{note}title = "Flexinol {title}"\n',
            f'[element]\nmaterial = "flexinol-{wire.alloy}"\n{format_strand(strand, catalogue, "what was said of it")}',
            format_environment(strand),
            f"[mechanism]\n{_format_load(wire.mechanism(strand))}",
            f'[drive]\nkind = "current"\nvoltage_limit = "{wire.supply:.12g} V"\nwaveform = {{ {wave} }}\n',
            f'[run]\nduration = "{2.0 * period:.6g} s"\nsamples = {SAMPLES}\n',
        ]
    )


def _format_load(mechanism: AbstractMechanism) -> str:
    return "".join(f"{key} = {toml_value(value)}\n" for key, value in _describe_part(mechanism).items())
