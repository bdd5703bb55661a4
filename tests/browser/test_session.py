"""The session of the page: nothing is lost by a reload, another page, a cut link or the end of the server."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser
from session_walk import walking

LOG = "time (s),power (W),temperature (degC)\n" + "".join(f"{k},{k % 2},{20 + k}\n" for k in range(20))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "mine.csv"
    path.write_text(LOG)
    return path


def test_nothing_is_lost_on_a_walk_with_reloads_and_a_dying_server(chromium: Browser, tmp_path: Path, log: Path) -> None:
    with walking(chromium, tmp_path, log, seed=1) as walk:
        walk.walk(40, restarts=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_nothing_is_lost_on_a_long_walk(chromium: Browser, tmp_path: Path, log: Path, seed: int) -> None:
    with walking(chromium, tmp_path, log, seed) as walk:
        walk.walk(200, restarts=4)
