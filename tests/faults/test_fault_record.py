"""The page of the laboratory of faults is true today.

Source of truth: trials of the page, made again.
"""

from __future__ import annotations

import subprocess

import pytest
from fault_trials import Outcome, Trial, run_trials
from laboratory.faults import PAGE, ROOT, FaultRecord, build_record, list_trials

LONG = [["saved results", 57]]
"""Closed trials of a minute."""
RECORD = FaultRecord.read()


def name_wrong(trials: list[tuple[str, int]], fine: bool) -> list[str]:
    """Trials that do not come out as the page says."""
    return [str(one) for one in run_trials(trials, cap=300.0) if one.fine is not fine]


def test_the_page_is_of_its_record() -> None:
    assert PAGE.read_text(encoding="utf-8") == RECORD.page()
    found = subprocess.run(
        ["git", "-C", str(ROOT), "cat-file", "-t", RECORD.commit.rstrip("+")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode or found.stdout == "commit\n"  # a shallow checkout does not know it


def test_open_trials_still_fail() -> None:
    """One that passes is closed by a new run: `python -m laboratory faults`."""
    assert name_wrong(list_trials(RECORD.open), fine=False) == []


def test_closed_trials_pass() -> None:
    assert name_wrong(list_trials([one for one in RECORD.closed if one not in LONG]), fine=True) == []


@pytest.mark.slow
def test_long_closed_trials_pass() -> None:
    assert name_wrong(list_trials(LONG), fine=True) == []


def test_a_trial_moves_from_open_to_closed_and_back() -> None:
    trials = [
        Trial("logs", 1, Outcome.ANSWERED, ""),
        Trial("logs", 2, Outcome.HANG, ""),
        Trial("logs", 3, Outcome.HANG, ""),
    ]
    again = [Trial("logs", 2, Outcome.ANSWERED, ""), Trial("logs", 3, Outcome.HANG, "")]
    record = build_record(trials, again, [("logs", 1), ("logs", 3)], "abc")
    assert record.open == [["logs", 3, "hang"]]
    assert record.unsteady == [["logs", 2, "hang"]]
    assert record.closed == [["logs", 1]]
    assert record.counts == {"logs": {"answered": 1, "hang": 2}}
    assert "commit `abc`" in record.page()
