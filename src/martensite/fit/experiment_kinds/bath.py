"""Bath experiment: a wire or a coil at a given temperature moves a weight or a spring.

A setting of the element that only a coil has, or `element.kind = "coil-spring"`, makes it a coil. With wire diameter d,
coil diameter D and N turns, its force and travel are those of the equivalent stress and strain at the surface,

    F = π d³ σ/(8 √3 D),    y = √3 π N D² ε/d
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from martensite.characterise.isobaric_cycles import find_named_stress
from martensite.fit.experiment_kinds.base import (
    DIAMETER,
    EXPERIMENT_KINDS,
    LENGTH,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.driven import A_F, vary_loads
from martensite.fit.experiment_kinds.loops import find_column, read_loop
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LogSurvey
from martensite.fit.experiment_kinds.values import (
    EPS,
    MODULI,
    SIGMA,
    SLOPE,
    Document,
    make_loop,
    make_record,
    write_values,
)
from martensite.search.quantity_text import format_number
from martensite.signals.records import Record

_COILED = {"element.coil_diameter", "element.turns", "element.free_length"}
STRAIGHT = 0.98
"""Least squared correlation of a load with the shape that makes it the load of a spring."""
FREE = (
    "A_f=-20..200 degC",
    "A_s-A_f=-100..-0.5 K",
    "M_s-A_f=-100..-0.5 K",
    "M_f-M_s=-100..-0.5 K",
    "eps_L=0.002..0.19",
)


@EXPERIMENT_KINDS.register("bath")
class BathTest(AbstractExperimentKind):
    """Stroke over a given temperature, under a weight or against a spring."""

    order = 45.0
    meaning = "heated and cooled, as in a bath, under a weight or against a spring"
    needs = "a temperature that varies by more than 15 K and a position, without a constant stress"
    axis = "temperature"
    own_zero = True

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if shape and temperature vary, with no load (of a position) or that of a spring."""
        if survey.drives or not survey.is_heated or not survey.shapes:
            return None
        shape = survey.shapes[0]
        loads = [name for one in survey.records for name in ("stress", "force") if name in one.columns]
        named = any(find_named_stress(one) for one in survey.records)
        if shape != "strain" and not loads and not named:  # a strain is of a material test, which asks for its stress
            why = f"`{shape}` and `temperature` vary, and no load is on record"
            return RecognisedExperiment(self, why, "temperature", (shape,))
        if survey.loads and all(_is_spring(one, shape, survey.loads[0]) for one in survey.records):
            why = f"`temperature` varies, and `{survey.loads[0]}` is straight over `{shape}`, as of a spring"
            return RecognisedExperiment(self, why, "temperature", (shape, survey.loads[0]))
        return None

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield a weight and a bias spring; the spring alone if force and position are measured."""
        shape = experiment.measured[0]
        rows = [read_loop(one, "temperature", find_column(one, shape, DEFORMATIONS), assumptions) for one in records]
        stroke = max(float(np.ptp(one[shape])) for one in rows)
        coil = _COILED & assumptions.settings.keys() or assumptions.settings.get("element.kind") == "coil-spring"
        sizes, section = _take_coil(assumptions, stroke) if coil else _take_wire(assumptions, shape, stroke)
        output, sign = _name_output(rows, shape, assumptions)
        column = output if (shape, sign) == (output, 1.0) else f"{output}={shape}*{sign:g}"
        effect = "the shape within a transformation is counted from it"
        moduli = {n: assumptions.take(f"element.law.{n}", "Pa", x, effect) for n, x in MODULI.items()}
        slopes = {name: assumptions.take_slope(name, "load") for name in ("C_A", "C_M")}
        base = _describe_bath(rows, sizes, write_values("Pa", **moduli) | write_values("Pa/K", **slopes))
        if len(experiment.measured) > 1:
            loads = [("a bias spring", _read_spring(experiment, rows, (section, sign), assumptions), ())]
        else:
            loads = list(vary_loads(assumptions, SIGMA * section, stroke))
        for name, mechanism, more in loads:
            document = base | {"mechanism": mechanism}
            yield Proposal(name, document, (*FREE, *more), (column,), rows, (f"offset.{output}",))

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield another load, and the load itself."""
        yield "The same under a second load, with the load in the log: it tells C_A, C_M and zero-stress temperatures."

    def make_example(self) -> list[Record]:
        """Return a position that rises on heating."""
        loop = make_loop()
        late = np.where(np.arange(len(loop)) < len(loop) // 2, 0.5, 0.3)
        return [
            make_record({"temperature": 290.0 + 100.0 * loop, "position": 0.004 * np.clip((loop - late) / 0.2, 0, 1)})
        ]


def _take_wire(assumptions: Assumptions, shape: str, stroke: float) -> tuple[Document, float]:
    """Return the entries of a wire, and its section [m²]."""
    size = 0.1 if shape == "strain" else stroke / (0.8 * EPS)
    length = assumptions.take(LENGTH, "m", size, "the transformation strain absorbs it")
    width = assumptions.take(DIAMETER, "m", 1e-3, "the load absorbs it")
    return {"kind": "wire"} | write_values("m", diameter=width, length=length), math.pi / 4.0 * width**2


def _take_coil(assumptions: Assumptions, stroke: float) -> tuple[Document, float]:
    """Return the entries of a close-wound coil, and its force over the equivalent stress [m²]."""
    width = assumptions.take(DIAMETER, "m", 0.75e-3, "the load absorbs it")
    wide = assumptions.take("element.coil_diameter", "m", 6.0 * width, "load and transformation strain absorb it")
    per_turn = math.sqrt(3.0) * math.pi * wide**2 / width
    turns = assumptions.take(
        "element.turns", "1", stroke / (0.8 * EPS * per_turn), "the transformation strain absorbs it"
    )
    entries: Document = {"kind": "coil-spring", "coil_measure": "mean", "turns": turns}
    entries |= write_values("m", diameter=width, coil_diameter=wide, free_length=1.05 * turns * width)
    return entries, math.pi * width**3 / (8.0 * math.sqrt(3.0) * wide)


def _name_output(rows: Sequence[Record], shape: str, assumptions: Assumptions) -> tuple[str, float]:
    """Return the output of a shape, and the sign that makes it grow as the element shortens."""
    if shape == "strain":
        return "strain", 1.0
    moved, kelvin = (np.concatenate([one[name] for one in rows]) for name in (shape, "temperature"))
    if np.corrcoef(moved, kelvin)[0, 1] > 0.0:
        return "position", 1.0
    assumptions.sentences.append(f"`{shape}` falls on heating: its sign is turned.")
    return "position", -1.0


def _read_spring(
    experiment: RecognisedExperiment, rows: Sequence[Record], sizes: tuple[float, float], assumptions: Assumptions
) -> Document:
    """Return the spring of the measured load over shape; `sizes` are the section [m²] and the sign of the shape."""
    shape, load = experiment.measured
    x, y = (np.concatenate([np.asarray(one[name]) for one in rows]) for name in (shape, load))
    section, sign = sizes
    rate, zero = np.polyfit(sign * (x - x[0]), y * (section if load == "stress" else 1.0), 1)
    assumptions.sentences.append(
        f"`{load}` over `{shape}` is a spring of {format_number(float(rate))} N/m, with {format_number(float(zero))} N "
        "at the first row."
    )
    return {"kind": "bias-spring", "stiffness": f"{max(rate, 1e-3):.6g} N/m", "preload": f"{max(zero, 1e-4):.6g} N"}


def _is_spring(record: Record, shape: str, load: str) -> bool:
    """Return whether a load is straight over a shape."""
    x, y = (np.asarray(record.columns.get(name, [0.0, 0.0]), float) for name in (shape, load))
    good = np.isfinite(x) & np.isfinite(y) if len(x) == len(y) else np.zeros(0, bool)
    if good.sum() < 3 or not np.ptp(x[good]) or not np.ptp(y[good]):
        return False
    return float(np.corrcoef(x[good], y[good])[0, 1]) ** 2 > STRAIGHT


def _describe_bath(rows: Sequence[Record], sizes: Document, elastic: Document) -> Document:
    """Return an element at the logged temperature, from martensite or, if it begins hot, from austenite."""
    kelvin = list(chain.from_iterable(one["temperature"] for one in rows))
    middle = 0.5 * (min(kelvin) + max(kelvin)) if kelvin else A_F + 273.15
    zero = middle - SIGMA / SLOPE
    law = {"kind": "liang-rogers", "modulus": "mixture", "eps_L": EPS, "Theta": "0 Pa/K"}
    law |= elastic
    law |= write_values("K", A_f=zero + 14.0, A_s=zero + 2.0, M_s=zero - 2.0, M_f=zero - 14.0)
    cold = float(np.mean([one["temperature"][0] for one in rows])) <= middle
    element = sizes | {"material": "flexinol-90", "initial_fraction": 1.0 if cold else 0.0, "law": law}
    return {
        "title": "Stroke over temperature",
        "element": element,
        "drive": {"kind": "temperature", "waveform": {"kind": "log"}},
        "run": {"step": "1e3 s"},
    }
