"""Suite of kinds of experiment: recognition, proposed scenarios and assumptions, tried with the example of each."""

import re
from dataclasses import replace

from martensite.fit.api import build_task
from martensite.fit.experiment_kinds.base import (
    AbstractExperimentKind,
    RecognisedExperiment,
    propose_scenarios,
    recognise_experiment,
)
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.scenario.scenario import read_scenario
from martensite.signals.records import Record
from martensite.testing.conformance import require_condition

ASSUMED = re.compile(r"`([^`]+)` is assumed to be ([^:]+):")


def _recognise(kind: AbstractExperimentKind) -> tuple[RecognisedExperiment, list[Record]]:
    records = kind.make_example()
    experiment = kind.recognise(LogSurvey(records))
    require_condition(experiment is not None, "it does not recognise its own example")
    return experiment, records  # type: ignore[return-value]


def check_words(kind: AbstractExperimentKind) -> None:
    """It describes its meaning and the columns that it needs."""
    for name in ("meaning", "needs"):
        require_condition(getattr(kind, name).strip(), f"`{name}` is empty")


def check_recognition(kind: AbstractExperimentKind) -> None:
    """Its example is recognised as this kind, by columns of the example."""
    experiment, records = _recognise(kind)
    first = recognise_experiment(records).name
    require_condition(first == kind.registered_name, f"its example is recognised as `{first}`, whose `order` is lower")
    lost = {*experiment.measured, *filter(None, [experiment.drive])} - {*records[0].columns}
    require_condition(not lost, f"its example has no column `{', '.join(lost)}`")


def check_silence(kind: AbstractExperimentKind) -> None:
    """It does not recognise records in which no column varies."""
    still = [
        replace(one, columns={name: x if name == "time" else [x[0]] * len(x) for name, x in one.columns.items()})
        for one in kind.make_example()
    ]
    require_condition(kind.recognise(LogSurvey(still)) is None, "it recognises records in which no column varies")


def check_proposals(kind: AbstractExperimentKind) -> None:
    """Each proposal is a scenario with free parameters, and its columns can be fitted."""
    if kind.command:
        return
    proposals, _ = propose_scenarios(*_recognise(kind), {})
    require_condition(proposals, "it proposes no scenario")
    for one in proposals:
        scenario = read_scenario(one.text, log=one.rows[0])
        task = build_task(scenario, list(one.rows), list(one.free))
        task = task.with_changes(each=list(one.each), hold_out="none", columns=list(one.columns))
        problem = task.arrange(check=False).problem
        require_condition(problem.free, f"the proposal `{one.name}` has no free parameter")


def check_assumptions(kind: AbstractExperimentKind) -> None:
    """A given value is used instead of an assumption."""
    if kind.command:
        return
    experiment, records = _recognise(kind)
    _, proposal = propose_scenarios(experiment, records, {})
    given = dict(match for note in proposal.sentences for match in ASSUMED.findall(note))
    _, again = propose_scenarios(experiment, records, given)
    ignored = [path for path in given if any(f"`{path}` is assumed" in note for note in again.sentences)]
    require_condition(not ignored, f"`{', '.join(ignored)}` is assumed although it is given")
