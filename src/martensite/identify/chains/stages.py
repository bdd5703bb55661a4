"""Models in stages: from the input to an intermediate measurement, and from there to the output.

Each stage is estimated from measurements before and after it; the series of all stages then runs from the input alone.
Its score is the score of the model: errors of the first stage pass through the second.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import InputError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain, RecordStart
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.estimate import ChainEstimate, Options, estimate_chain
from martensite.identify.chains.scores import ROLES, OutputScore, score_chain
from martensite.signals.sampling.resampling import collect_experiments, select_signals
from martensite.signals.sampling.sampled import Sampled

SERIES = "series"


@dataclass(frozen=True)
class ModelStage:
    """One stage: its structure and its outputs."""

    structure: str
    output: str

    @property
    def outputs(self) -> tuple[str, ...]:
        """Return the names of the outputs."""
        return tuple(name.strip() for name in self.output.split(",") if name.strip())

    @classmethod
    def read(cls, text: str, output: str | None = None) -> ModelStage:
        """Return a stage from `structure -> output`; the arrow is optional if `output` is given.

        Raises:
            InputError: the output is not named.
        """
        structure, arrow, name = text.partition("->")
        name = name.strip() if arrow else (output or "")
        if not name:
            raise InputError(f"Stage `{text.strip()}` names no output; write `… -> temperature`.")
        return cls(structure.strip(), name)


@dataclass(frozen=True, eq=False)
class IdentifiedStages:
    """Estimated stages, their series, and scores in free run."""

    stages: tuple[ModelStage, ...]
    estimates: tuple[ChainEstimate, ...]
    model: Chain
    """Series of all stages, or the single stage."""
    scores: tuple[OutputScore, ...]
    options: Options

    def fit(self, role: str = "validation", model: str | None = None) -> list[float]:
        """Return the fits [%] of the model, or of a stage such as `stage 1`, by role of the records."""
        name = model or (SERIES if len(self.stages) > 1 else "model")
        return [s.fit for s in self.scores if (s.role, s.model) == (role, name)]


def identify_stages(
    records: Sampled | Sequence[Sampled],
    stages: str | Sequence[str | ModelStage],
    validation: Sampled | Sequence[Sampled] = (),
    other: Sampled | Sequence[Sampled] = (),
    options: Options | None = None,
    watch: Callable[[str, float], None] | None = None,
) -> IdentifiedStages:
    """Estimate models from records, stage by stage, and their series.

    Args:
        records: records of the fit, with all intermediate and final measurements as outputs.
        stages: structures, such as `poly2 | oe(3,3,1) | pwl10 -> temperature`; the default output of the last stage
            is the last output of the records.
        validation: records for validation, with another excitation.
        other: further records that are scored.
        options: options of the estimation of each stage.
        watch: called with a sentence and the completed fraction.

    Raises:
        InputError: records or stages do not fit.
        SolveError: no search gave a model that can be simulated.
    """
    options = options or Options()
    groups = [_group_records(records), _group_records(validation), _group_records(other)]
    collect_experiments(*groups[0], *groups[1], *groups[2])
    planned = _plan_stages(stages, groups[0][0])
    inputs: tuple[str, ...] = groups[0][0].input_names
    estimates: list[ChainEstimate] = []
    scores: list[OutputScore] = []
    for k, stage in enumerate(planned):
        parts = [[select_signals(r, inputs, stage.outputs) for r in group] for group in groups]
        tell = _share_progress(watch, k, len(planned))
        estimates.append(estimate_chain(stage.structure, parts[0], options, tell))
        name = f"stage {k + 1}" if len(planned) > 1 else "model"
        scores += _score_stage(estimates[-1].chain, parts, options, name)
        inputs = stage.outputs
        if not estimates[-1].complete:
            planned = planned[: k + 1]  # interrupted: the finished stages are the model
            break
    ends = [[select_signals(r, r.input_names, planned[-1].outputs) for r in group] for group in groups]
    model = _join_series(estimates, ends[0])
    if len(planned) > 1:
        scores += _score_stage(model, ends, options, SERIES)
    return IdentifiedStages(tuple(planned), tuple(estimates), model, tuple(scores), options)


def _group_records(records: Sampled | Sequence[Sampled]) -> list[Sampled]:
    return [records] if isinstance(records, Sampled) else list(records)


def _plan_stages(stages: str | Sequence[str | ModelStage], record: Sampled) -> list[ModelStage]:
    """Return the stages with named outputs and valid structures."""
    texts = [stages] if isinstance(stages, str) else list(stages)
    if not texts:
        raise InputError("A model needs at least one stage.")
    last = len(texts) - 1
    planned = [
        s if isinstance(s, ModelStage) else ModelStage.read(s, record.output_names[-1] if k == last else None)
        for k, s in enumerate(texts)
    ]
    for stage in planned:
        parse_chain(stage.structure)
    return planned


def _share_progress(
    watch: Callable[[str, float], None] | None, k: int, count: int
) -> Callable[[str, float], None] | None:
    if watch is None or count == 1:
        return watch
    return lambda text, share: watch(f"stage {k + 1}: {text}", (k + share) / count)


def _score_stage(chain: Chain, groups: Sequence[Sequence[Sampled]], options: Options, model: str) -> list[OutputScore]:
    return [
        score
        for role, group in zip(ROLES, groups, strict=True)
        for score in score_chain(chain, group, role, options.start, options.skip, model)
    ]


def _join_series(estimates: Sequence[ChainEstimate], records: Sequence[Sampled]) -> Chain:
    """Return the stages in series, with the starts of records."""
    model = estimates[0].chain
    if len(estimates) == 1:
        return model
    for one in estimates[1:]:
        model = model.then(one.chain)
    starts: dict[str, RecordStart] = {}
    for k, record in enumerate(records):
        stage_starts = [(one, one.chain.starts[one.records[k].hash]) for one in estimates]
        kinds = {start.kind for _, start in stage_starts}
        kind = kinds.pop() if len(kinds) == 1 else "estimate"
        states = [_find_state(one, one.records[k], start) for one, start in stage_starts] if kind == "estimate" else []
        starts[record.hash] = RecordStart(record.name, kind, tuple(map(float, np.concatenate([[], *states]))))
    return replace(model, name=SERIES).with_records(starts, model.ranges)


def _find_state(one: ChainEstimate, record: Sampled, start: RecordStart) -> Numbers:
    state = one.chain.restore_state(start)
    return one.chain.engine.rest(one.chain.theta, record.inputs[0]).state if state is None else state
