"""The laboratory of faults: makes trials, keeps what came out with the commit, and writes its page.

`python -m laboratory faults`, in the folder `tests`. The trials are those of `fault_experiments.py`.
"""

from __future__ import annotations

import json
import math
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fault_experiments import EXPERIMENTS, LARGE, ROOT, can_mount, list_wanted
from fault_trials import FINE, Outcome, Trial, count_trials, run_trials

PAGE = ROOT / "docs/developer/fault-tests.md"
RECORD = PAGE.with_suffix(".json")
NEEDS_ROOT = ("full disks", "read-only folders", "read-only caches")
HEAD = ("experiment", "what is broken", "trials", *Outcome)
Named = list[list[Any]]
"""Trials by experiment and seed, each with an outcome where it is open."""
INTRODUCTION = """# Fault tests

This page shows how the package handles wrong input, damaged files, killed processes, hostile folders and caches that
other users can write. Each trial is an experiment with a seed: it damages a valid input at random.

| outcome | meaning | fault of the package |
| --- | --- | --- |
| answered | complete, all values finite, equal to an undisturbed run to the last bit | no |
| refused | one sentence, exit code 2 | no |
| failed | a run started and ended with a status and a sentence | no |
| left out | valid, but longer than 100 000 steps | no |
| traceback, dead process, hang | – | yes |
| nan | a value is not finite | yes |
| silent loss | data are missing or changed, or hostile code ran, without a message | yes |

```sh
python tests/fault_experiments.py scenarios 17        # one trial, with its messages
cd tests && python -m laboratory faults               # a whole run and this page: hours
cd tests && python -m laboratory faults --share 0.02  # the same with 2 % of the trials
```

The test `tests/faults/test_fault_record.py` runs the open and the closed trials of this page again: an open trial
must still fail, and a closed trial must pass. Trials with full disks mount a disk, which needs root. gcc compiles
exported code with the address and undefined-behaviour sanitizers.
"""


@dataclass(frozen=True)
class FaultRecord:
    """What a run of the laboratory found."""

    commit: str
    day: str
    counts: dict[str, dict[str, int]]
    """Trials by experiment and outcome."""
    open: Named
    """One trial of every experiment and kind of fault, which failed twice."""
    unsteady: Named
    """Trials that failed once, and passed when they were repeated at once."""
    closed: Named
    """Trials that were open in an earlier run and are no more."""

    @classmethod
    def read(cls) -> FaultRecord:
        """The record of the page."""
        return cls(**json.loads(RECORD.read_text(encoding="utf-8")))

    def write(self) -> None:
        """Write the record and its page."""
        RECORD.write_text(json.dumps(vars(self), indent=1) + "\n", encoding="utf-8")
        PAGE.write_text(self.page(), encoding="utf-8")

    def page(self) -> str:
        """The page, in Markdown."""
        lines = [f"| {' | '.join(HEAD)} |", f"| --- | --- |{' ---: |' * (len(HEAD) - 2)}"]
        for name in (name for name in EXPERIMENTS if name in self.counts):
            told = (EXPERIMENTS[name].__doc__ or "").splitlines()[0].rstrip(".")
            cells = [self.counts[name].get(outcome, 0) for outcome in Outcome]
            lines.append(f"| {name} | {told} | {sum(cells)} | {' | '.join(map(str, cells))} |")
        whole = [sum(row.get(outcome, 0) for row in self.counts.values()) for outcome in Outcome]
        lines.append(f"| **all** | | {sum(whole)} | {' | '.join(map(str, whole))} |")
        begin = f"Run of {self.day} at commit `{self.commit}`:"
        found = [f"- `{name} {seed}`: {outcome}" for name, seed, outcome in self.open] or ["No trial is open."]
        once = [f"- `{name} {seed}`: {outcome}" for name, seed, outcome in self.unsteady] or ["No trial is unsteady."]
        closed = [f"- `{name} {seed}`" for name, seed in self.closed] or ["No trial was open in an earlier run."]
        parts = ["## Open", "", "Failed, and failed again when repeated:", "", *found, ""]
        parts += [
            "## Unsteady",
            "",
            "Failed, and passed when repeated; the computer may have been busy:",
            "",
            *once,
            "",
        ]
        parts += ["## Closed", "", "Open in an earlier run, and closed since:", "", *closed]
        return "\n".join([INTRODUCTION, begin, "", *lines, "", *parts, ""])


def write(share: float) -> None:
    """Run a fraction of all trials and the recorded trials; write the record and the page."""
    before = FaultRecord.read()
    known = [(name, seed) for name, seed, *_ in (*before.open, *before.closed)]
    names = [name for name in LARGE if name not in NEEDS_ROOT or can_mount()]
    wanted = [one for name in names for one in list_wanted(name, max(2, math.ceil(share * LARGE[name])))]
    begun = find_commit()
    found = run_trials(dict.fromkeys([*wanted, *known]), cap=300.0)
    again = run_trials([(one.experiment, one.seed) for one in found if not one.fine], cap=300.0)
    build_record(found, again, known, begun).write()


def build_record(
    found: Sequence[Trial], again: Sequence[Trial], known: Sequence[tuple[str, int]], commit: str
) -> FaultRecord:
    """The record of trials, of those that were repeated, and of those that an earlier record knows."""
    passed = {(one.experiment, one.seed) for one in again if one.fine}
    odd = [one for one in found if one.outcome not in FINE]
    steady = {(one.experiment, one.outcome): one for one in odd[::-1] if (one.experiment, one.seed) not in passed}
    is_open: Named = [[one.experiment, one.seed, str(one.outcome)] for one in reversed(steady.values())]
    once: Named = [[one.experiment, one.seed, str(one.outcome)] for one in odd if (one.experiment, one.seed) in passed]
    fine = {(one.experiment, one.seed) for one in found if one.fine}
    closed: Named = [[name, seed] for name, seed in known if (name, seed) in fine]
    counts = {name: {str(key): n for key, n in row.items()} for name, row in count_trials(found).items()}
    return FaultRecord(commit, time.strftime("%-d %B %Y"), counts, is_open, once, closed)


def find_commit() -> str:
    """The commit of the checkout, with `+` behind it if its files differ."""
    words = ["git", "-C", str(ROOT), "describe", "--always", "--abbrev=8", "--exclude=*", "--dirty=+"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def list_trials(named: Named) -> list[tuple[str, int]]:
    """Experiments and seeds of some trials of a record that can be made here."""
    return [(str(name), int(seed)) for name, seed, *_ in named if name not in NEEDS_ROOT or can_mount()]
