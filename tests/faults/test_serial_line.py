"""A serial line that fails ends in a sentence.

Source of truth: a pseudo-terminal whose other end reads nothing, or is closed.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator

import pytest

from martensite.base.errors import MartensiteError, SolveError
from martensite.boards.link.host import BoardLink, Port, open_port

pty = pytest.importorskip("pty")
PATIENCE = 20.0
"""Wall time [s] after which a write hangs."""


@pytest.fixture
def terminal() -> Iterator[tuple[int, Port]]:
    """The board's end of a line, and the host's."""
    board, host = pty.openpty()
    port = open_port(os.ttyname(host))
    os.close(host)
    yield board, port
    port.close()
    try:
        os.close(board)
    except OSError:
        return


def ask(port: Port) -> MartensiteError | None:
    """Greet the board many times; the error, or None for a host that hangs."""
    found: list[MartensiteError] = []

    def work() -> None:
        try:
            while True:
                BoardLink(port).send("ping", token=1)
        except MartensiteError as error:
            found.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(PATIENCE)
    return found[0] if found else None


def test_a_board_that_reads_nothing(terminal: tuple[int, Port]) -> None:
    error = ask(terminal[1])
    assert isinstance(error, SolveError)
    assert "The line to the board failed (Write timeout)" in str(error)


def test_a_board_that_is_unplugged(terminal: tuple[int, Port]) -> None:
    os.close(terminal[0])
    with pytest.raises(SolveError, match="The line to the board failed"):
        BoardLink(terminal[1]).greet()
