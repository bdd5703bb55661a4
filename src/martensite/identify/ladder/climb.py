"""Ladder of structures: from the best linear model to hysteresis, feedback and nonlinear state space.

Each rung has a few structures. The best of them on the blocks to choose by continues with more starts, and replaces the
present model if its errors there are significantly smaller; otherwise the simpler model stays. The climb ends if the
residuals are white and unrelated to the input, at the last rung, or at the end of the time box. Then the model is
fitted to all blocks except the held-out ones, and tested on these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from martensite.base.errors import MartensiteError, SolveError
from martensite.base.interrupts import accept_interrupt
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.decimation import COARSE, find_thinnest
from martensite.identify.chains.doubts import describe_copies, describe_exchange
from martensite.identify.chains.estimate import ChainEstimate, Options, estimate_chain
from martensite.identify.chains.goals import AUTO, check_informative, check_records
from martensite.identify.chains.record_starts import find_start
from martensite.identify.chains.scores import OutputScore, score_chain
from martensite.identify.chains.validation import Validation, validate_chain
from martensite.identify.ladder.blocked_records import (
    BlockedRecord,
    BlockErrors,
    compare_errors,
    describe_silence,
    describe_step,
    divide_records,
    measure_blocks,
    run_blocks,
)
from martensite.identify.ladder.ladder_result import Ladder, LadderRung, LadderTrial
from martensite.identify.ladder.ladder_rivals import score_rivals
from martensite.identify.ladder.record_tests import (
    DelayTest,
    describe_coherence,
    describe_linearity,
    describe_rest,
    find_delay,
)
from martensite.identify.ladder.regimes import set_apart
from martensite.identify.ladder.rungs import LINEAR, list_neighbours, list_rungs, write_linear
from martensite.search.quantity_text import format_number
from martensite.search.time_box import TimeBox, measure_processor_time
from martensite.signals.sampling.resampling import resample_record
from martensite.signals.sampling.sampled import Sampled

TIME_BOX = 120.0
"""Processor time of a climb [s]."""
RESERVED = 0.15
"""Fraction of it for the last fit."""
ORDERS = (1, 2, 3, 4)
LEAST_ORDER = 2
"""Smallest order of linear blocks above the linear rung."""
PROBE = Options(starts=4, refined=1, iterations=60, start=AUTO, anchor=0.1, ridge=1e-6)
"""Options of the trial of a structure."""
LIKELY = 0.84
"""Confidence level (one standard error) of differences between structures of a rung, and between orders."""
DOUBTFUL = 0.01
"""Significance level of the test of white residuals."""
Watch = Callable[[str, float], None]
Keep = Callable[[LadderTrial], None]


@dataclass(eq=False)
class _Climb:
    """State of a climb; it keeps the best model if it is stopped."""

    blocked_records: tuple[BlockedRecord, ...]
    options: Options
    clock: TimeBox
    watch: Watch
    keep: Keep
    rungs: list[LadderRung] = field(default_factory=list[LadderRung])
    best: LadderTrial | None = None
    stop_reason: str = ""

    def try_structure(self, rung: str, text: str, options: Options) -> LadderTrial:
        """Return a structure fitted without the blocks to choose by, and its errors on these."""
        started = measure_processor_time()
        visible = [one.hide(False) for one in self.blocked_records if one.is_fitted]
        numbers = len(build_untrained(parse_chain(text), visible[0]).theta)
        done = "" if self.best is None else f", so far {self.best.chosen_by.fit:.1f} %"
        tell: Watch = lambda words, share: self.watch(f"{rung}, {text}: {words}{done}", self.clock.share)  # noqa: E731
        no_errors = BlockErrors(np.nan, np.full(1, np.inf))
        try:
            with np.errstate(all="ignore"):  # a structure may grow without bound
                estimate = estimate_chain(text, visible, options, tell, self.clock.halt)
                chosen_by, held_out_errors = self._measure(estimate.chain)
        except MartensiteError as error:
            return LadderTrial(
                text, numbers, None, no_errors, no_errors, measure_processor_time() - started, str(error)
            )
        return LadderTrial(
            text, numbers, estimate.chain, chosen_by, held_out_errors, measure_processor_time() - started
        )

    def _measure(self, chain: Chain | None) -> tuple[BlockErrors, BlockErrors]:
        """Return the errors of a model, or of the mean, on the blocks to choose by and on held-out blocks."""
        runs = run_blocks(chain, self.blocked_records, False)
        return measure_blocks(self.blocked_records, runs, False), measure_blocks(self.blocked_records, runs, True)

    def _add_trial(self, trials: list[LadderTrial], name: str, text: str, options: Options) -> None:
        """Try a structure; raise `KeyboardInterrupt` afterwards if the climb must end."""
        trials.append(self.try_structure(name, text, options))
        if self.clock.halt.is_set():
            raise KeyboardInterrupt

    @contextmanager
    def _keep_stopped(self) -> Iterator[None]:
        """End the block for exceptions that end the climb, and store the reason in `stop_reason`."""
        try:
            yield
        except KeyboardInterrupt:
            accept_interrupt()
            self.stop_reason = "time box" if self.clock.over else "interrupted"
            self.clock.halt.set()

    def climb_rung(self, name: str, structures: Sequence[str], larger: LadderTrial | None = None) -> None:
        """Try the structures of a rung; the best replaces a worse model, or a `larger` one that is no better."""
        trials: list[LadderTrial] = []
        with self._keep_stopped():
            for text in structures:
                self._add_trial(trials, name, text, PROBE)
            lead = _pick_best(trials)
            if lead.chain is not None and (larger or compare_errors(self.reference, lead.chosen_by).value > 0.0):
                self._add_trial(trials, name, lead.structure, replace(self.options, begin=(lead.chain,), refined=1))
        if not trials:
            return
        lead = _pick_best(trials)
        gain = compare_errors(self.reference, lead.chosen_by)
        better = lead.chain is not None and gain.certain
        if larger is not None:
            better = lead.chain is not None and not compare_errors(lead.chosen_by, larger.chosen_by, LIKELY).certain
        others = sorted((one for one in trials if one.structure != lead.structure), key=_rank)
        self.rungs.append(LadderRung(name, (lead, *others), gain, better))
        if better:
            self.best = lead
            self.keep(lead)

    def trim_order(self) -> None:
        """Remove poles without which the model is as good."""
        while self.best is not None and not self.stop_reason and (match := LINEAR.search(self.best.structure)):
            order = int(match[1]) - 1
            if order < 1:
                return
            less = LINEAR.sub(f"oe({order + (match[2] == '0')},{order},{match[2]})", self.best.structure)
            before = self.best
            self.climb_rung("fewer poles", [less], before)
            if self.best is before:
                return

    @property
    def reference(self) -> BlockErrors:
        """Return the errors of the present model, or of the mean."""
        return self.best.chosen_by if self.best else self.measure_mean().chosen_by

    def measure_mean(self) -> LadderTrial:
        """Return the mean of the fitted outputs as a model."""
        return LadderTrial("mean", 1, None, *self._measure(None), 0.0)

    def climb_linear(self, delay: int, count: int) -> int:
        """Return the lowest order that no higher order significantly improves."""
        ins, outs = (len(names) for names in (self.record.input_names, self.record.output_names))
        trials: list[LadderTrial] = []
        with self._keep_stopped():
            for k in ORDERS[:count]:
                self._add_trial(trials, "linear", write_linear(k, delay, ins, outs), replace(PROBE, starts=2))
        if not trials:
            raise SolveError("Nothing was found yet: not even the first linear model was finished.")
        best, order = trials[0], ORDERS[0]
        for k, one in zip(ORDERS, trials, strict=False):
            if one.chain is not None and compare_errors(best.chosen_by, one.chosen_by, LIKELY).certain:
                best, order = one, k
        if best.chain is None:
            raise SolveError(f"No linear model could be found. {best.fault}".strip())
        gain = compare_errors(self.reference, best.chosen_by)
        others = [one for one in sorted(trials, key=_rank) if one is not best]
        self.rungs.append(LadderRung("linear", (best, *others), gain, gain.certain))
        self.best = best if gain.certain else None
        self.keep(best)
        return order

    @property
    def record(self) -> Sampled:
        """Return the first record."""
        return self.blocked_records[0].record

    def exhausts(self) -> bool:
        """Return whether the residuals of the model are white and unrelated to the inputs."""
        if self.best is None or self.best.chain is None:
            return False
        chain, fitted = self.best.chain, [one for one in self.blocked_records if one.is_fitted]
        # without gaps: nothing may happen in the longest stretch of a record in blocks
        checks = [validate_chain(chain, _cut_held(one), state=_run_until(chain, one, False, 0)) for one in fitted]
        return all(one.explained and all(test.p_value >= DOUBTFUL for test in one.whiteness) for one in checks)


def climb_ladder(
    records: Sampled | Sequence[Sampled],
    validation: Sequence[Sampled] = (),
    other: Sequence[Sampled] = (),
    options: Options | None = None,
    time_box: float = TIME_BOX,
    watch: Watch | None = None,
    keep: Keep | None = None,
) -> Ladder:
    """Find the simplest structure that predicts records best.

    Args:
        records: records of the fit; records of another regime than the first are set apart. The last fifth of each is
            held out, and a third of the rest is for the choice of a structure.
        validation: records for the choice instead.
        other: held-out records instead.
        options: options of the estimation of the best structure of a rung; other structures have fewer starts.
        time_box: processor time [s].
        watch: called with a sentence and the used fraction of the time box.
        keep: called with every better model.

    Raises:
        InputError: the records do not fit together, or are uninformative.
        SolveError: there is not even a linear model.
    """
    records = [records] if isinstance(records, Sampled) else list(records)
    check_informative(records[:1], 0, "rest")
    fitted, apart = set_apart(records)
    factor = find_thinnest(fitted, max(map(len, fitted)) // COARSE)
    tests = [text for record in fitted[:1] for text in describe_copies([record])]
    if factor > 1:
        interval = factor * fitted[0].interval
        fitted, validation, other = (
            [resample_record(r, interval) for r in group] for group in (fitted, validation, other)
        )
        tests.append(
            f"Sample time: {factor} samples are averaged to one of {format_number(interval, 3)} s, which loses nothing."
        )
    check_records([*fitted, *validation, *other])
    blocked = divide_records(fitted, validation, other)
    clock = TimeBox(time_box)
    tell: Watch = watch or (lambda text, share: None)
    climb = _Climb(blocked, options or replace(PROBE, starts=12), clock, tell, keep or (lambda trial: None))
    with clock.watch(1.0 - RESERVED):
        tests += _climb_all(climb)
    return _finish(climb, tests, [records[k] for k in apart], list(apart.values()))


def _climb_all(climb: _Climb) -> list[str]:
    """Test the records, climb all rungs, and return the results of the tests."""
    visible = [one.hide(False) for one in climb.blocked_records if one.is_fitted]
    climb.watch("rest and delay", climb.clock.share)
    delay = find_delay(visible)
    order = climb.climb_linear(delay.value, len(ORDERS))
    tests = [*describe_rest(visible), *_describe_order(climb, delay, order), *_test_linear(climb, visible)]
    if not (climb.stop_reason or describe_step(visible) or describe_silence(climb.blocked_records, False)):
        # nonlinear terms hide poles from a linear model: at least two are used, and the last step removes idle ones
        _climb_nonlinear(climb, max(order, LEAST_ORDER), delay.value, tests)
    return tests


def _test_linear(climb: _Climb, visible: Sequence[Sampled]) -> Iterator[str]:
    linear = climb.rungs[0].trials[0].chain
    if linear is not None:
        for one in climb.blocked_records:
            yield from describe_coherence(_cut_held(one)) if one.is_fitted else ()
        yield from describe_linearity(linear, [validate_chain(linear, record) for record in visible])


def _climb_nonlinear(climb: _Climb, order: int, delay: int, tests: list[str]) -> None:
    ins, outs = (len(names) for names in (climb.record.input_names, climb.record.output_names))
    for name, structures in list_rungs(order, delay, ins, outs):
        if climb.exhausts():
            tests.append("The residuals are white and hold nothing of the input: higher rungs have nothing to find.")
            break
        climb.climb_rung(name, structures)
        if name == "Hammerstein–Wiener" and not climb.stop_reason and climb.best is not None:
            climb.climb_rung("order and delay", list_neighbours(climb.best.structure))
        if climb.stop_reason:
            break
    climb.trim_order()


def _cut_held(one: BlockedRecord) -> Sampled:
    return one.record.rows(0, one.held_out[0].start if one.held_out else None)


def _describe_order(climb: _Climb, delay: DelayTest, order: int) -> Iterator[str]:
    fits = {one.structure: one.chosen_by.fit for one in climb.rungs[0].trials}
    tried = ", ".join(f"`{text}` {fit:.1f} %" for text, fit in sorted(fits.items()))
    yield delay.sentence
    yield f"Linear order: {order}; higher ones are not better by more than chance ({tried})."


def _rank(trial: LadderTrial) -> float:
    """Return the mean error on the blocks to choose by; infinite without a model."""
    error = float(np.mean(trial.chosen_by.pieces)) if len(trial.chosen_by.pieces) else np.inf
    return error if trial.chain is not None and np.isfinite(error) else np.inf


def _pick_best(trials: Sequence[LadderTrial]) -> LadderTrial:
    """Return the trial of least error; of equally good ones the one with the fewest numbers."""
    best = min(trials, key=_rank)
    near = [
        one
        for one in trials
        if _rank(one) < np.inf and not compare_errors(one.chosen_by, best.chosen_by, LIKELY).certain
    ]
    return min(near, key=lambda one: (one.numbers, _rank(one)), default=best)


def _finish(climb: _Climb, tests: list[str], apart: Sequence[Sampled], reasons: Sequence[str]) -> Ladder:
    """Return the chosen structure, fitted to all data that are not held out, and its test on held-out data."""
    chosen = climb.best or climb.rungs[0].trials[0]
    chain, whole = chosen.chain, False
    remarks: list[str] = []
    if chain is None:
        raise SolveError("No model was found.")
    if climb.stop_reason != "interrupted" and any(one.chosen_by and one.is_fitted for one in climb.blocked_records):
        chain, whole, remarks = _fit_whole(climb, chain)
    runs = run_blocks(chain, climb.blocked_records, whole)
    errors = measure_blocks(climb.blocked_records, runs, True)
    fitted = [one.record for one in climb.blocked_records if one.is_fitted]
    doubts = [
        describe_step(fitted),
        *(describe_silence(climb.blocked_records, is_held_out) for is_held_out in (False, True)),
    ]
    doubts += describe_exchange(fitted, errors.fit)
    return Ladder(
        climb.blocked_records,
        climb.measure_mean(),
        tuple(climb.rungs),
        chosen,
        chain,
        errors,
        tuple(_check_held(chain, climb.blocked_records, whole)),
        tuple(tests),
        tuple(reasons),
        tuple(_score_apart(chain, apart)),
        tuple(text for text in doubts if text),
        tuple(remarks),
        climb.stop_reason,
        score_rivals(climb.blocked_records, whole),
    )


def _fit_whole(climb: _Climb, chain: Chain) -> tuple[Chain, bool, list[str]]:
    """Return the chain, whether it was also fitted to the blocks to choose by, and remarks."""
    whole_records = [one.hide(True) for one in climb.blocked_records if one.is_fitted]
    options = replace(PROBE, starts=0, begin=(chain,))
    try:
        climb.watch("last fit", climb.clock.share)
        estimate: ChainEstimate = estimate_chain(chain.blocks, whole_records, options)
    except KeyboardInterrupt:
        accept_interrupt()
        climb.stop_reason = "interrupted"
        return chain, False, []
    except MartensiteError:
        return chain, False, []
    return estimate.chain, True, list(estimate.remarks)


def _check_held(chain: Chain, blocked: Sequence[BlockedRecord], whole: bool) -> Iterator[Validation]:
    """Yield the tests of the chain on held-out data, in runs from the first sample of each record."""
    runs = run_blocks(chain, blocked, whole)
    for one, run in zip(blocked, runs, strict=True):
        if not one.held_out or not np.all(np.isfinite(run)):
            continue
        first = one.held_out[0].start
        part = one.record.rows(first, None, f"{one.record.name}, held out")
        if np.isfinite(part.outputs).sum(axis=0).min() >= 10:
            yield validate_chain(chain, part, state=_run_until(chain, one, whole, first))


def _run_until(chain: Chain, one: BlockedRecord, whole: bool, first: int) -> Numbers:
    """Return the state of a run at a sample."""
    begin = find_start(chain, one.hide(whole) if one.is_fitted else one.record, AUTO)
    steady = chain.engine.rest(chain.theta, one.record.inputs[0]).state
    state = np.array(steady if begin.state is None else begin.state, dtype=float)
    if first:
        chain.engine.simulate(chain.theta, one.record.inputs[:first], state)
    return state


def _score_apart(chain: Chain, apart: Sequence[Sampled]) -> Iterator[OutputScore]:
    for record in apart:
        try:
            yield from score_chain(chain, [record], "set apart")
        except MartensiteError:  # shorter than a sample of the model
            continue
