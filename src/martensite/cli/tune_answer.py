"""Result of a tuning: comparison with the present loop, printed text and saved files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from martensite.base.summary import Block, Sentence, Summary
from martensite.control.margins.loop_check import LoopReport
from martensite.control.tuning.judgement import TuningJudgement
from martensite.show.summaries.loop import check_scenario_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.cli.outputs import JudgedOptions, Outputs
    from martensite.control.loop.bench import Bench
    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class TuningVerdict:
    """Errors before and after, and the loop test of the tuned loop."""

    judgement: TuningJudgement
    report: LoopReport
    was_sound: bool
    """True if the present loop had no fault; tested only if the tuned loop has one."""

    @property
    def lost(self) -> bool:
        """True if only the tuned loop is unsound."""
        return self.was_sound and self.report.verdict == "not sound"

    @property
    def worse(self) -> bool:
        """True if the error is larger or the loop has become unsound."""
        return self.judgement.worse or self.lost

    @property
    def sentence(self) -> str:
        """The verdict without a full stop."""
        if self.lost:
            return f"WORSE: the tuned loop fails tests that the present loop passes ({self.judgement.describe()})"
        return f"{self.judgement.word}: {self.judgement.describe()}"

    def list_blocks(self) -> Iterator[Block]:
        """Yield loop findings and verdict."""
        yield from (Sentence(str(one), "bad" if one.fault else "caution") for one in self.report.findings)
        untested = f" ({', '.join(self.report.untested)})" if self.report.verdict == "not all tested" else ""
        tone = "bad" if self.report.verdict == "not sound" else ""
        yield Sentence(f"Tests of the tuned loop: {self.report.verdict}{untested}.", tone)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {**self.judgement.to_dict(), "worse": self.worse, "check": self.report.to_dict()}


def judge_scenario(scenario: Scenario, bench: Bench, judgement: TuningJudgement) -> TuningVerdict:
    """Test the tuned loop as `check` does, and the present loop if the tuned one has a fault."""
    report = check_scenario_loop(scenario, bench)
    faulty = report.verdict == "not sound" and scenario.bench is not None
    before = check_scenario_loop(scenario, scenario.bench) if faulty and scenario.bench is not None else report
    return TuningVerdict(judgement, report, before.verdict != "not sound")


@dataclass(frozen=True, eq=False)
class TuningAnswer:
    """Text, files and figure of a tuning."""

    verdict: TuningVerdict
    summary: Summary
    text: Callable[[], str]
    """Returns the scenario with the new gains."""
    draw: Callable[[], Figure]

    def give(self, outputs: Outputs, options: JudgedOptions) -> bool:
        """Print the result, verdict first; return True if a worse scenario was not saved."""
        from martensite.cli.outputs import Verdict

        verdict = Verdict(self.verdict.worse, self.verdict.sentence)
        blocks = [*self.summary.blocks, *self.verdict.list_blocks()]
        summary = replace(self.summary, blocks=blocks, data={**self.summary.data, "verdict": self.verdict.to_dict()})
        return outputs.answer_verdict(verdict, summary, options, self.text, self.draw)
