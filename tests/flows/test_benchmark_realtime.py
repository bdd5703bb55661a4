"""The benchmark section of the control step still runs; times say nothing here."""

import pytest
from benchmarks import sections_realtime
from benchmarks.engines import available
from benchmarks.sections import Options

OURS = Options(available(["ours"]), repeats=1, calls=60)


@pytest.mark.slow
def test_realtime(monkeypatch):
    cheap = {
        "pid": sections_realtime.drive(sections_realtime.bench(False).controllers.members()["drive"]),
        "loop": sections_realtime.loop(sections_realtime.bench(False), native=False),
    }
    monkeypatch.setattr(sections_realtime, "calls", lambda: cheap)
    (table,) = sections_realtime.realtime(OURS)
    assert [row["step"] for row in table.rows] == list(cheap)
    assert all(0.0 < row["median [us]"] <= row["p99.9 [us]"] for row in table.rows)
    assert table.rows[0]["ratio"] == 1.0
