"""Workers that die, hang, lie or grow: a sentence, and the next call is answered."""

import asyncio
import json
import os
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from bad_calls import command

from martensite.app import worker_pool
from martensite.app.messages import Refusal, WorkerJson
from martensite.app.worker_pool import Worker, WorkerPool

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")

Work = Callable[[WorkerPool], Awaitable[Any]]


@pytest.fixture(autouse=True)
def bad(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pool, "COMMAND", command(tmp_path))


def pooled(folder: Path, work: Work, **given: Any) -> Any:
    """What becomes of work with a pool of one worker, which is closed in any case."""

    async def whole() -> Any:
        settings: dict[str, Any] = {"size": 1} | given
        pool = WorkerPool(folder, **settings)
        try:
            return await work(pool)
        finally:
            await pool.close()

    return asyncio.run(whole())


def refusal_then_answer(folder: Path, call: str, request: dict[str, Any], **given: Any) -> Refusal:
    """The refusal of a call; the next one must be answered."""

    async def work(pool: WorkerPool) -> Refusal:
        with pytest.raises(Refusal) as caught:
            await pool.ask("", call, request)
        assert await pool.ask("", "run", {"a": 1}) == {"echo": {"a": 1}}
        return caught.value

    return pooled(folder, work, **given)


def is_alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and is not fetched does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    "call, request_",
    [
        ("die", {"signal": "SIGKILL"}),
        ("die", {"signal": "SIGTERM"}),
        ("die", {"signal": "SIGSEGV"}),
        ("crash", {}),
        ("leave", {}),
    ],
)
def test_a_worker_that_dies(tmp_path: Path, call: str, request_: dict[str, Any]) -> None:
    refusal = refusal_then_answer(tmp_path, call, request_)
    assert (refusal.kind, refusal.status) == ("lost", 500)
    assert "ended unexpectedly" in str(refusal)


def test_a_worker_that_grows_without_end(tmp_path: Path) -> None:
    refusal = refusal_then_answer(tmp_path, "hungry", {})
    assert "not enough memory" in str(refusal)
    assert refusal.kind == "failed"


@pytest.mark.parametrize("line", ["", "garbage", "[1, 2]", "12", "null", "{}", '{"refused": "x"}', '{"kind": 1}', "\0"])
def test_a_worker_that_writes_garbage(tmp_path: Path, line: str) -> None:
    refusal = refusal_then_answer(tmp_path, "garbage", {"line": line})
    assert refusal.kind == "lost"


def test_a_call_that_takes_too_long(tmp_path: Path) -> None:
    refusal = refusal_then_answer(tmp_path, "hang", {}, quick=3.0)
    assert "longer than 3 s" in str(refusal)


def test_an_answer_that_is_too_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pool, "LONGEST_LINE", 2**16)
    refusal = refusal_then_answer(tmp_path, "huge", {"size": 2**20})
    assert "too long" in str(refusal)


def test_errors_that_nobody_thought_of(tmp_path: Path) -> None:
    refusal = refusal_then_answer(tmp_path, "bug", {"zero": 0})
    assert str(refusal).startswith("Unexpected error: ZeroDivisionError")
    assert "No space left" in str(refusal_then_answer(tmp_path, "full", {}))
    assert "no call named `nothing`" in str(refusal_then_answer(tmp_path, "nothing", {})).lower()


def test_what_a_call_prints_is_no_message(tmp_path: Path) -> None:
    assert pooled(tmp_path, lambda pool: pool.ask("", "prints", {})) == {"fine": True}


def test_numbers_that_json_lacks_are_null(tmp_path: Path) -> None:
    found = pooled(tmp_path, lambda pool: pool.ask("", "tree", {}))
    assert found == {"none": None, "n": [None, 1]}


def test_a_message_of_the_greatest_length_is_answered(tmp_path: Path) -> None:
    text = "x" * (8 * 2**20)
    found = pooled(tmp_path, lambda pool: pool.ask("", "run", {"t": text}))
    assert isinstance(found, WorkerJson)  # passed on as it came
    assert json.loads(found) == {"echo": {"t": text}}


def test_a_worker_that_cannot_be_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pool, "COMMAND", (str(tmp_path / "nothing"),))

    async def work(pool: WorkerPool) -> None:
        for _ in range(2):
            with pytest.raises(Refusal, match="No process could be started"):
                await pool.ask("", "run", {})

    pooled(tmp_path, work)


def test_progress_of_a_call_is_known_by_its_lane_until_it_ends(tmp_path: Path) -> None:
    async def work(pool: WorkerPool) -> list[Any]:
        call = asyncio.create_task(pool.ask("slider", "hang", {}))
        while not pool.notes and not call.done():
            await asyncio.sleep(0.02)
        seen = dict(pool.notes)
        pool.cancel("slider")
        with pytest.raises(Refusal, match="Cancelled"):
            await call
        return [seen, pool.notes]

    assert pooled(tmp_path, work) == [{"slider": {"begun": True}}, {}]


def test_a_newer_call_goes_over_one_that_waits(tmp_path: Path) -> None:
    async def work(pool: WorkerPool) -> list[Any]:
        calls = [pool.ask("slider", "run", {"k": k}) for k in range(20)]
        return await asyncio.gather(*calls, return_exceptions=True)

    found = pooled(tmp_path, work)
    assert (found[0], found[-1]) == ({"echo": {"k": 0}}, {"echo": {"k": 19}})
    assert {getattr(one, "kind", "") for one in found[1:-1]} == {"superseded"}


def test_calls_of_others_are_not_gone_over(tmp_path: Path) -> None:
    async def work(pool: WorkerPool) -> list[Any]:
        calls = [pool.ask("" if k % 2 else f"lane {k}", "run", {"k": k}) for k in range(10)]
        return await asyncio.gather(*calls)

    assert pooled(tmp_path, work) == [{"echo": {"k": k}} for k in range(10)]


def test_who_gives_up_waiting_keeps_no_worker(tmp_path: Path) -> None:
    async def work(pool: WorkerPool) -> Any:
        first = asyncio.create_task(pool.ask("a", "hang", {}))
        await asyncio.sleep(0.5)
        waiting = asyncio.create_task(pool.ask("b", "run", {}))
        await asyncio.sleep(0.1)
        waiting.cancel()
        first.cancel()
        await asyncio.gather(first, waiting, return_exceptions=True)
        return await pool.ask("c", "run", {})

    assert pooled(tmp_path, work) == {"echo": {}}


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks into /proc")
@pytest.mark.parametrize("how", ["kill", "worker dies"])
def test_what_a_worker_has_started_ends_with_it(tmp_path: Path, how: str) -> None:
    told: list[dict[str, Any]] = []

    async def work() -> None:
        worker = Worker(tmp_path)
        asked = asyncio.create_task(worker.ask("family", {}, told.append))
        while not told:
            await asyncio.sleep(0.02)
        process = await worker.start()
        assert is_alive(told[0]["child"])
        if how == "kill":
            await worker.kill()
        else:
            os.kill(process.pid, 9)
        with pytest.raises(Refusal, match="ended unexpectedly"):
            await asked

    asyncio.run(work())
    end = time.monotonic() + 10.0
    while is_alive(told[0]["child"]):
        assert time.monotonic() < end
        time.sleep(0.02)
