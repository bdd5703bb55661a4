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


def summarise_ladder(found: Ladder) -> Summary:
    """Return the summary of a structure search."""
    names = ", ".join(f"`{name}`" for name in found.model.input_names)
    outputs = ", ".join(f"`{name}`" for name in found.model.output_names)
    word = "INCONCLUSIVE" if found.doubts else "predicts" if found.predicts else "DOES NOT PREDICT"
    title = f"Model of {outputs} from {names}: {word}".replace("`", "")
    blocks = [
        *_describe_verdict(found),
        *_describe_climb(found),
        *_describe_records(found),
        *_describe_held(found),
        *_describe_next(found),
    ]
    return Summary(title, blocks, _collect_numbers(found), f"{found.verdict} All scores are from free runs.")


def _describe_records(found: Ladder) -> Iterator[Block]:
    yield Heading("Records")
    rows = [
        (
            one.record.name,
            f"{len(one.record)}",
            f"{one.record.interval:.4g}",
            f"{one.record.duration:.4g}",
            _tell_use(one.fitted, bool(one.chosen_by), bool(one.held)),
        )
        for one in found.blocked
    ]
    yield DataTable(("record", "samples", "sample time [s]", "duration [s]", "used to"), rows, right=(1, 2, 3))
    remarks = [f"`{one.record.name}`: {text}" for one in found.blocked for text in one.record.remarks]
    yield BulletList([*remarks, *found.tests])
    if found.apart:
        scores = [f"`{s.record}`, `{s.output}`: model fit {s.fit:.1f} %" for s in found.apart_scores]
        yield Notice("Other regime", [*found.apart, *scores], True)


def _tell_use(fitted: bool, chosen: bool, held: bool) -> str:
    return ", ".join(word for word, used in (("fit", fitted), ("select", chosen), ("test", held)) if used)


def _describe_climb(found: Ladder) -> Iterator[Block]:
    yield Heading("Structures")
    mean = found.baseline
    rows = [("–", "mean of the output", "1", f"{mean.chosen_by.fit:.1f}", f"{mean.held.fit:.1f}", "–", "–", "baseline")]
    rows += [("–", name, "–", "–", f"{fit:.1f}", "–", "–", "rival") for name, fit in found.rivals.items()]
    rows += [_write_trial(rung, rung.trials[0], found) for rung in found.rungs]
    note = (
        "The best structure of every step, with the reduction of its error and the 99 % interval of the reduction. A "
        "structure is kept if the interval is above 0. Held-out data were not used for the selection."
    )
    yield DataTable(HEADINGS, rows, right=(2, 3, 4, 6), note=note, detail=(2, 6), tones={"chosen": "good"})
    more = [_write_trial(rung, trial, found) for rung in found.rungs for trial in rung.trials[1:]]
    yield DataTable(HEADINGS, more, right=(2, 3, 4, 6), folded="All other structures")
    if found.stopped:
        yield Sentence(f"{STOPPED[found.stopped]}; more complex structures were not tried.", "caution")


def _write_trial(rung: LadderRung, trial: LadderTrial, found: Ladder) -> tuple[str, ...]:
    first = trial is rung.trials[0]
    verdict = ("chosen" if trial is found.chosen else "kept" if rung.kept else "not better") if first else "–"
    seconds = f"{trial.seconds:.1f}"
    if trial.chain is None:
        return rung.name, trial.structure, f"{trial.numbers}", "–", "–", "–", seconds, trial.fault
    scores = (f"{trial.chosen_by.fit:.1f}", f"{trial.held.fit:.1f}")
    return rung.name, trial.structure, f"{trial.numbers}", *scores, rung.gain.text if first else "–", seconds, verdict


def _describe_verdict(found: Ladder) -> Iterator[Block]:
    good = found.predicts and not found.doubts
    sentences = (
        [f"The held-out error is below the error of the mean by {found.gain.text} (95 %)."] if found.predicts else []
    )
    if items := [*sentences, *found.doubts, *found.remarks]:
        yield Notice("Result" if good else "Warning", items, not good)


def _describe_held(found: Ladder) -> Iterator[Block]:
    for k, one in enumerate(found.checks):
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


def _describe_next(found: Ladder) -> Iterator[Block]:
    if found.advice:
        yield Heading("Next recordings")
        yield BulletList(found.advice)


def _collect_numbers(found: Ladder) -> dict[str, Any]:
    return {
        "structure": found.model.text(),
        "numbers": dict(zip(found.model.names(), map(float, found.model.theta), strict=True)),
        "predicts": found.predicts,
        "verdict": found.verdict,
        "fit_held_out": found.held.fit,
        "fit_held_out_of_mean": found.baseline.held.fit,
        "fit_held_out_of_rivals": dict(found.rivals),
        "free_run": True,
        "stopped": found.stopped,
        "tests": list(found.tests),
        "set_apart": list(found.apart),
        "doubts": list(found.doubts),
        "advice": list(found.advice),
        "rungs": [
            {
                "rung": rung.name,
                "kept": rung.kept,
                "gain": rung.gain.text,
                "trials": [
                    {
                        "structure": trial.structure,
                        "free_numbers": trial.numbers,
                        "fit_chosen_by": trial.chosen_by.fit,
                        "fit_held_out": trial.held.fit,
                        "fault": trial.fault,
                    }
                    for trial in rung.trials
                ],
            }
            for rung in found.rungs
        ],
        "residuals": [one.to_dict() for one in found.checks],
    }
