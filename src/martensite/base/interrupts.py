"""One rule for interrupts: Ctrl-C, SIGTERM and SIGHUP alike end a command, within about a second.

    handle_signals      what the command line runs in: these signals raise `KeyboardInterrupt`; a process that
                        does not come to hear it, such as in a long compiled run, is ended from beside
    rescue_answer       a block in which there is something worth keeping, and what keeps it
    hold_interrupts     a block that is not cut in two: it is interrupted at its end
    accept_interrupt    said by who has caught `KeyboardInterrupt` and goes on with what there is

Outside of `handle_signals`, and in other threads than the main one, nothing but Python's own rule is changed.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from types import FrameType

from martensite.base.errors import StoppedError

GRACE = 0.6
"""Time for a process to end by itself [s]."""
SAVING = 5.0
"""Time to write the results to be kept [s]."""
TWICE = 0.3
"""Signals that follow so soon are one [s]: `timeout` sends its signal to the process and to its group."""
CLEAR_LINE = "\r\x1b[K"
"""Sequence that removes a progress bar from a terminal."""
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class InterruptError(StoppedError):
    """Error for an interrupted command; the sentence names the kept results."""

    exit_code = 130


class _Rescue:
    """Function that saves a result: called once, by the first thread."""

    def __init__(self, save: Callable[[], str]) -> None:
        self._save = save
        self._lock = threading.RLock()
        self._said: str | None = None

    def run(self) -> str:
        """Keep it, and say so; an empty sentence where there is nothing to say."""
        if not self._lock.acquire(timeout=SAVING):
            return ""
        try:
            if self._said is None:
                self._said = ""
                self._said = self._save()
            return self._said
        finally:
            self._lock.release()


class _State:
    """State of interrupts in this process."""

    def __init__(self) -> None:
        self.rescues: list[_Rescue] = []
        self.held = 0
        self.heard = 0.0
        """When the signal came that the main thread is ending for; 0 without."""
        self.accepted = 0.0
        self.waiting = False
        """True if a signal came in a block that holds it."""
        self.told = False
        """True if the main thread prints the sentence."""


_state = _State()


@contextmanager
def handle_signals() -> Generator[None]:
    """Let the signals that mean the end raise `KeyboardInterrupt`; those that are ignored stay so."""
    taken = {one: signal.getsignal(one) for one in SIGNALS}
    taken = {one: before for one, before in taken.items() if before is not signal.SIG_IGN}
    for one in taken:
        signal.signal(one, _interrupt)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_watch_signals, args=(reading,), daemon=True).start()
    try:
        yield
    finally:
        if _state.heard:  # threads that still work, and Python's own exit code, are not waited for
            _end_process()
        signal.set_wakeup_fd(before)
        os.close(writing)
        for one, handler in taken.items():
            signal.signal(one, handler)


@contextmanager
def rescue_answer(save: Callable[[], str]) -> Generator[None]:
    """Keep what there is where a block is interrupted.

    `save` keeps it and answers a sentence; it is called once, and from another thread where this one is in a compiled
    run. An empty sentence leaves the interrupt to the blocks around.

    Raises:
        InterruptError: the block was interrupted; it says the sentence.
    """
    rescue = _Rescue(save)
    if threading.current_thread() is threading.main_thread():
        _state.rescues.append(rescue)
    try:
        yield
    except KeyboardInterrupt:
        said = rescue.run()
        if not said:
            raise
        _state.told = True
        raise InterruptError(said) from None
    finally:
        if rescue in _state.rescues:
            _state.rescues.remove(rescue)


@contextmanager
def hold_interrupts() -> Generator[None]:
    """Interrupt a short block, such as one that writes to a store, at its end."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _state.held += 1
    try:
        yield
    finally:
        _state.held -= 1
        if _state.waiting and not _state.held:
            _state.waiting = False
            raise KeyboardInterrupt


def accept_interrupt() -> None:
    """Go on after an interrupt with the best so far: the process is not ended from beside."""
    _state.accepted = time.monotonic()
    _state.heard = 0.0


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise `KeyboardInterrupt`, once, and not in a block that holds it."""
    del number, frame
    now = time.monotonic()
    if _state.heard or now - _state.accepted < TWICE:
        return
    _state.heard = now
    if _state.held:
        _state.waiting = True
        return
    raise KeyboardInterrupt


def _watch_signals(reading: int) -> None:
    """End the process where the main thread does not."""
    while numbers := os.read(reading, 1):
        came = time.monotonic()
        if signal.getsignal(numbers[0]) is not _interrupt:  # a server has its own rule
            continue
        time.sleep(GRACE)
        if _state.accepted < came - TWICE:
            _end_process()
    os.close(reading)


def _end_process() -> None:
    """Keep what there is, say so, and end, with the processes that were started."""
    said = _rescue_all() or "Interrupted."
    beside = threading.current_thread() is not threading.main_thread()
    if _state.told and beside:  # by the main thread, which is given the time to
        time.sleep(TWICE)
    elif not _state.told:
        os.write(2, f"{CLEAR_LINE if os.isatty(2) else ''}error: {said}\n".encode())
    if "multiprocessing" in sys.modules:
        from multiprocessing import active_children

        for child in active_children():
            child.kill()
    sys.stderr.flush()
    os._exit(InterruptError.exit_code)


def _rescue_all() -> str:
    """Return the sentence of the innermost block that has one; all of them keep what they have."""
    found = ""
    for rescue in reversed(_state.rescues):
        try:
            said = rescue.run()
        except Exception as error:  # the end comes all the same
            said = str(error)
        found = found or said
    return found
