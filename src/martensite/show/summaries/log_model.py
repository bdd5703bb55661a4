"""Summary of a model of logs: experiment, predictions, parameters, next recordings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.fit.cross_validation import HeldOutError, PooledError
from martensite.fit.experiment_kinds.base import FitEvidence
from martensite.fit.fit import list_compared
from martensite.fit.fit_verdicts import format_error
from martensite.fit.log_models import UNCERTAIN, LogModel
from martensite.fit.log_trials import CLEARLY, TriedModel
from martensite.search.quantity_text import format_change, format_quantity, join_phrases
from martensite.search.rivals import BETTER, EXPLAINED
from martensite.show.figures.fit import has_loops, plot_fit, plot_fit_loops

HELD_OUT = ("record", "output", "rms", "offset_rms", "whole", "fit_percent")
"""Entries of a held-out error in machine-readable output."""


def summarise_log_model(model: LogModel, command: str = "") -> Summary:
    """Return the summary of a model of logs; `command` repeats the fit."""
    fit, rows = model.fit, list_compared(model.fit)
    names = [one.name for one in fit.problem.experiments]
    which = join_phrases(names) if len(names) <= 4 else f"{len(names)} records"
    experiment = model.experiment
    lead = f"Taken as `{experiment.name}`: {experiment.kind.meaning}, because {experiment.why} (`--experiment`)."
    figure = (plot_fit_loops, "loops") if has_loops(fit) else (plot_fit, "measured")
    samples = sum(int(row.training_rows.sum()) for row in rows)
    blocks: list[Block] = [
        _make_verdict(model),
        *([_tabulate_errors(model.chosen_model.errors)] if model.chosen_model.errors else []),
        Heading("The model"),
        Sentence(_describe_choice(model)),
        _tabulate_numbers(model),
        *_tabulate_temperatures(model),
        Sentence(f"{len(fit.problem.free)} parameters, {samples} measured values. Search: {fit.reason}."),
        *([Sentence(f"The trials ended early because of the {model.stop_reason}.")] if model.stop_reason else []),
        *_list_input_noise(model),
        Heading("Assumed and done"),
        BulletList(model.notes or ("Nothing.",)),
        Heading("Next recordings"),
        BulletList(list_next_records(model)),
        Picture(figure[1], lambda: figure[0](fit), "Measured and modelled, fitted to all records."),
    ]
    if command:
        blocks.insert(-1, Sentence(f"The scenario is saved. Repeat the fit by `{command}`"))
    return Summary(f"A model of {which}", blocks, _collect_numbers(model) | {"again": command}, lead)


def _make_verdict(model: LogModel) -> Notice:
    items = [_describe_output(one, model.chosen_model.errors) for one in model.chosen_model.pooled_errors]
    if not model.chosen_model.pooled_errors:
        return Notice("The model was not tested", ["No held-out data were predicted."], True)
    return Notice(
        f"On held-out data the model {model.chosen_model.pooled_errors[0].verdict}", items, not model.predicts
    )


def _describe_output(one: PooledError, errors: Sequence[HeldOutError]) -> str:
    own = [x for x in errors if x.output == one.output]
    what = "each record left out in turn" if own[0].whole else "held-out rows of the same records"
    claim = f"`{one.output}`: rms error {format_error(one.output, one.rms, one.unit)} in {what}"
    if math.isfinite(one.offset_rms):
        fitted = format_error(one.output, one.offset_rms, one.unit)
        claim += f", {fitted} with an offset fitted to each held-out record"
    claim += f" ({one.fit_percent:.0f} % fit)"
    rival = format_error(one.output, one.rivals[one.best_rival], one.unit)
    if one.predicts:
        return f"{claim}; the best rival ({one.best_rival}) errs by {rival}."
    if not one.beats_rivals:
        return f"{claim}. The {one.best_rival} needs no model and errs by {rival}."
    return f"{claim}; better than the best rival ({one.best_rival}, {rival}), but below {100.0 * EXPLAINED:.0f} % fit."


def _tabulate_errors(errors: Sequence[HeldOutError]) -> DataTable:
    names = list(dict.fromkeys(name for one in errors for name in one.rivals))
    offset = any(math.isfinite(one.offset_rms) for one in errors)
    head = ("held out", "output", "rms error", *(["with offset"] if offset else []), "fit", *names)
    rows = [
        (
            one.record + ("" if one.whole else " (part)"),
            one.output,
            format_error(one.output, one.rms, one.unit),
            *([format_error(one.output, one.offset_rms, one.unit)] if offset else []),
            f"{one.fit_percent:.1f} %",
            *(format_error(one.output, one.rivals[n], one.unit) if n in one.rivals else "" for n in names),
        )
        for one in errors
    ]
    note = (
        f"A model predicts if its error is below {BETTER:g} of the error of every rival on the right, and its fit is "
        f"at least {100.0 * EXPLAINED:.0f} %."
    )
    return DataTable(head, rows, right=tuple(range(2, len(head))), note=note)


def _describe_choice(model: LogModel) -> str:
    def error(one: TriedModel) -> str:
        count = f"{len(one.fit.problem.free)} parameters"
        if not one.pooled_errors:
            return f"{one.proposal.name} (not tested, {count})"
        first = one.pooled_errors[0]
        return f"{one.proposal.name} ({format_error(first.output, first.rms, first.unit)}, {count})"

    chosen = model.chosen_model.proposal.name
    if len(model.tried_models) == 1:
        return f"Model: {chosen}."
    return (
        f"Chosen: {chosen}. A model with more parameters must reduce the held-out error to {CLEARLY:g}. "
        f"Tried: {', '.join(map(error, model.tried_models))}."
    )


def _tabulate_numbers(model: LogModel) -> DataTable:
    fit = model.fit
    weak = {name for one in fit.identifiability.weak for name in one.names}
    rows: list[tuple[str, ...]] = []
    for free in fit.problem.free:
        low, high = fit.uncertainty.widen_interval(free.name)
        why = model.undetermined.get(free.name, "")
        if not why and free.name in weak:
            why = "not apart from others"
        if free.name in model.dependent:
            why = _name_assumed(model.dependent[free.name])
        is_finite = math.isfinite(high - low)
        interval = f"{format_quantity(low, free.unit)} to {format_quantity(high, free.unit)}" if is_finite else ""
        rows.append(
            (
                free.name,
                format_quantity(fit[free.name], free.unit),
                interval,
                _mark_determined(why, model.untested_assumptions),
            )
        )
    if model.time_constant is not None:
        tau, low, high = (f"{x:.4g} s" for x in model.time_constant)
        rows.insert(0, ("time constant", tau, f"{low} to {high}", "yes"))
    note = "Intervals hold for this model and are widened for autocorrelated residuals."
    return DataTable(("parameter", "value", "95 % interval", "determined"), rows, right=(1,), note=note)


def _name_assumed(paths: Sequence[str]) -> str:
    """Return `per assumed length, C_A` for the paths of assumed values."""
    return f"per assumed {_name_paths(paths)}"


def _name_paths(paths: Sequence[str]) -> str:
    return ", ".join(path.rpartition(".")[2] for path in paths)


def _mark_determined(why: str, untested: Sequence[str]) -> str:
    """Return `yes`, or why a number is not known to be determined; an untested assumption is such a reason."""
    if why:
        return why if why.startswith("per assumed") else f"no: {why}"
    return f"not tested for assumed {_name_paths(untested)}" if untested else "yes"


def _tabulate_temperatures(model: LogModel) -> Iterator[Block]:
    """Yield the transformation temperatures at zero stress and at each load."""
    temperatures = model.temperatures
    rows: list[tuple[str, ...]] = []
    for stress in dict.fromkeys(one.stress for one in temperatures):
        own = [one for one in temperatures if one.stress == stress]
        paths = list(dict.fromkeys(path for one in own for path in one.assumed))
        cells = [f"{format_quantity(one.value, 'K')} ± {format_change(one.half_width, 'K', 2)}" for one in own]
        wide = [one.name for one in own if not one.half_width <= UNCERTAIN]
        mark = _mark_determined(_name_assumed(paths) if paths else ", ".join(wide), model.untested_assumptions)
        rows.append((f"{stress / 1e6:g} MPa", *cells, mark))
    if rows:
        names = [one.name for one in temperatures if one.stress == temperatures[0].stress]
        note = "± is half of the 95 % interval, which holds for this law."
        yield DataTable(("at", *names, "determined"), rows, right=tuple(range(1, 5)), note=note)


def _list_input_noise(model: LogModel) -> Iterator[Sentence]:
    """Yield sentences about drive noise, which the intervals do not include."""
    problem = model.fit.problem
    units = {name: one.record.units[name] for one in problem.experiments for name in one.follows.values()}
    noises, notes = model.input_noise
    sizes = [f"{format_change(one.sigma, units[one.column], 2)} in `{one.column}`" for one in noises]
    if sizes:
        yield Sentence(
            f"The intervals take what drives as exact. By their rows there is noise of {join_phrases(sizes)}: a fit of "
            "the kept scenario (--scenario) counts it."
        )
    yield from map(Sentence, notes)


def list_next_records(model: LogModel) -> list[str]:
    """Return suggestions for further records, the most useful first."""
    fit = model.fit
    weak = {name for one in fit.identifiability.weak for name in one.names}
    evidence = FitEvidence(
        fit.problem.experiments, model.chosen_model.proposal.name, model.predicts, weak | set(model.undetermined)
    )
    return list(model.experiment.kind.suggest_records(evidence)) or [
        "Record a log under other conditions to test the model."
    ]


def _collect_numbers(model: LogModel) -> dict[str, Any]:
    fit = model.fit
    return {
        "experiment": {"kind": model.experiment.name, "why": model.experiment.why, "drive": model.experiment.drive},
        "predicts": model.predicts,
        "model": model.chosen_model.proposal.name,
        "held_out": [
            {name: getattr(one, name) for name in HELD_OUT} | {"rivals": dict(one.rivals)}
            for one in model.chosen_model.errors
        ],
        "tried": [
            {"model": one.proposal.name, "rms": one.pooled_errors[0].rms if one.pooled_errors else None}
            for one in model.tried_models
        ],
        "numbers": fit.numbers,
        "time_constant": model.time_constant,
        "undetermined": model.undetermined,
        "per_assumed": {name: list(paths) for name, paths in model.dependent.items()},
        "untested_assumptions": list(model.untested_assumptions),
        "temperatures": [asdict(one) for one in model.temperatures],
        "uncounted_noise": {one.column: one.sigma for one in model.input_noise[0]},
        "notes": list(model.notes),
        "next": list_next_records(model),
        "scenario": model.write_scenario(),
    }
