"""Summary of a structure search: verdict, records, structures, residuals and advice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.identify.ladder.ladder_result import Ladder, LadderRung, LadderTrial
from martensite.show.figures.model import plot_model, plot_model_loop, plot_model_tests

HEADINGS = (
    "step",
    "structure",
    "parameters",
    "selection fit [%]",
    "held-out fit [%]",
    "error reduction",
    "s",
    "verdict",
)
STOPPED = {
    "time box": "The search ended at its CPU time limit (--time-box)",
    "interrupted": "The search was interrupted. This is the best model so far",
}


def summarise_ladder(ladder: Ladder) -> Summary:
    """Return the summary of a structure search."""
    names = ", ".join(f"`{name}`" for name in ladder.model.input_names)
    outputs = ", ".join(f"`{name}`" for name in ladder.model.output_names)
    word = "INCONCLUSIVE" if ladder.doubts else "predicts" if ladder.predicts else "DOES NOT PREDICT"
    title = f"Model of {outputs} from {names}: {word}".replace("`", "")
    blocks = [
        *_describe_verdict(ladder),
        *_describe_climb(ladder),
        *_describe_records(ladder),
        *_describe_held(ladder),
        *_describe_next(ladder),
    ]
    return Summary(title, blocks, _collect_numbers(ladder), f"{ladder.verdict} All scores are from free runs.")


def _describe_records(ladder: Ladder) -> Iterator[Block]:
    yield Heading("Records")
    rows = [
        (
            one.record.name,
            f"{len(one.record)}",
            f"{one.record.interval:.4g}",
            f"{one.record.duration:.4g}",
            _tell_use(one.is_fitted, bool(one.chosen_by), bool(one.held_out)),
        )
        for one in ladder.blocked_records
    ]
    yield DataTable(("record", "samples", "sample time [s]", "duration [s]", "used to"), rows, right=(1, 2, 3))
    remarks = [f"`{one.record.name}`: {text}" for one in ladder.blocked_records for text in one.record.remarks]
    yield BulletList([*remarks, *ladder.tests])
    if ladder.apart:
        scores = [f"`{s.record}`, `{s.output}`: model fit {s.fit:.1f} %" for s in ladder.apart_scores]
        yield Notice("Other regime", [*ladder.apart, *scores], True)


def _tell_use(fitted: bool, chosen: bool, is_held_out: bool) -> str:
    return ", ".join(word for word, used in (("fit", fitted), ("select", chosen), ("test", is_held_out)) if used)


def _describe_climb(ladder: Ladder) -> Iterator[Block]:
    yield Heading("Structures")
    mean = ladder.baseline
    rows = [
        ("–", "mean of the output", "1", f"{mean.chosen_by.fit:.1f}", f"{mean.held_out.fit:.1f}", "–", "–", "baseline")
    ]
    rows += [("–", name, "–", "–", f"{fit:.1f}", "–", "–", "rival") for name, fit in ladder.rivals.items()]
    rows += [_write_trial(rung, rung.trials[0], ladder) for rung in ladder.rungs]
    note = (
        "The best structure of every step, with the reduction of its error and the 99 % interval of the reduction. A "
        "structure is kept if the interval is above 0. Held-out data were not used for the selection."
    )
    yield DataTable(HEADINGS, rows, right=(2, 3, 4, 6), note=note, detail=(2, 6), tones={"chosen": "good"})
    more = [_write_trial(rung, trial, ladder) for rung in ladder.rungs for trial in rung.trials[1:]]
    yield DataTable(HEADINGS, more, right=(2, 3, 4, 6), folded="All other structures")
    if ladder.stop_reason:
        yield Sentence(f"{STOPPED[ladder.stop_reason]}; more complex structures were not tried.", "caution")


def _write_trial(rung: LadderRung, trial: LadderTrial, ladder: Ladder) -> tuple[str, ...]:
    first = trial is rung.trials[0]
    verdict = (
        ("chosen" if trial is ladder.chosen_trial else "kept" if rung.is_accepted else "not better") if first else "–"
    )
    seconds = f"{trial.seconds:.1f}"
    if trial.chain is None:
        return rung.name, trial.structure, f"{trial.numbers}", "–", "–", "–", seconds, trial.fault
    scores = (f"{trial.chosen_by.fit:.1f}", f"{trial.held_out.fit:.1f}")
    return rung.name, trial.structure, f"{trial.numbers}", *scores, rung.gain.text if first else "–", seconds, verdict


def _describe_verdict(ladder: Ladder) -> Iterator[Block]:
    good = ladder.predicts and not ladder.doubts
    sentences = (
        [f"The held-out error is below the error of the mean by {ladder.gain.text} (95 %)."] if ladder.predicts else []
    )
    if items := [*sentences, *ladder.doubts, *ladder.remarks]:
        yield Notice("Result" if good else "Warning", items, not good)


def _describe_held(ladder: Ladder) -> Iterator[Block]:
    for k, one in enumerate(ladder.checks):
        yield Heading(one.record.name[:1].upper() + one.record.name[1:], detail=True)
        yield Picture(
            f"held{k}", lambda one=one: plot_model(one), "Measured and modelled held-out data, with the residual."
        )
        yield Picture(f"loop{k}", lambda one=one: plot_model_loop(one), "Output over input.")
        yield Picture(
            f"tests{k}",
            lambda one=one: plot_model_tests(one),
            "Autocorrelation of the residuals, and correlation with the inputs.",
        )
        yield BulletList(one.sentences, detail=True)


def _describe_next(ladder: Ladder) -> Iterator[Block]:
    if ladder.advice:
        yield Heading("Next recordings")
        yield BulletList(ladder.advice)


def _collect_numbers(ladder: Ladder) -> dict[str, Any]:
    return {
        "structure": ladder.model.text(),
        "numbers": dict(zip(ladder.model.names(), map(float, ladder.model.theta), strict=True)),
        "predicts": ladder.predicts,
        "verdict": ladder.verdict,
        "fit_held_out": ladder.held_out.fit,
        "fit_held_out_of_mean": ladder.baseline.held_out.fit,
        "fit_held_out_of_rivals": dict(ladder.rivals),
        "free_run": True,
        "stopped": ladder.stop_reason,
        "tests": list(ladder.tests),
        "set_apart": list(ladder.apart),
        "doubts": list(ladder.doubts),
        "advice": list(ladder.advice),
        "rungs": [
            {
                "rung": rung.name,
                "kept": rung.is_accepted,
                "gain": rung.gain.text,
                "trials": [
                    {
                        "structure": trial.structure,
                        "free_numbers": trial.numbers,
                        "fit_chosen_by": trial.chosen_by.fit,
                        "fit_held_out": trial.held_out.fit,
                        "fault": trial.fault,
                    }
                    for trial in rung.trials
                ],
            }
            for rung in ladder.rungs
        ],
        "residuals": [one.to_dict() for one in ladder.checks],
    }
