"""Interrupts: Ctrl-C, SIGTERM and SIGHUP end a command within about a second.

    handle_signals      context of the command line: signals raise `KeyboardInterrupt`; a watching thread ends a
                        process that does not react, such as in a long compiled run
    rescue_answer       block whose partial result is saved on an interrupt
    hold_interrupts     block that is interrupted only at its end
    accept_interrupt    called after `KeyboardInterrupt` was caught and the program continues

Outside of `handle_signals`, and in threads other than the main thread, Python's default handling applies.
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
"""Time in which a process can react to a signal [s]."""
SAVING = 5.0
"""Time limit for saving results [s]."""
TWICE = 0.3
"""Interval within which signals count as one [s]: `timeout` signals the process and its group."""
CLEAR_LINE = "\r\x1b[K"
"""Escape sequence that removes a progress bar."""
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class InterruptError(StoppedError):
    """Error for an interrupted command; the sentence names the saved results."""

    exit_code = 130


class _Rescue:
    """Function that saves a result, called once by the first thread."""

    def __init__(self, save: Callable[[], str]) -> None:
        self._save = save
        self._lock = threading.RLock()
        self._sentence: str | None = None

    def run(self) -> str:
        """Save the result and return the sentence about it; may be empty."""
        if not self._lock.acquire(timeout=SAVING):
            return ""
        try:
            if self._sentence is None:
                self._sentence = ""
                self._sentence = self._save()
            return self._sentence
        finally:
            self._lock.release()


class _State:
    def __init__(self) -> None:
        self.rescues: list[_Rescue] = []
        self.delays = 0
        self.signal_time = 0.0
        """Time of the signal that the main thread is handling; 0 without a signal."""
        self.accepted = 0.0
        self.waiting = False
        """True if a signal arrived in a block that delays it."""
        self.reported = False
        """True if the main thread prints the sentence."""


_state = _State()


@contextmanager
def handle_signals() -> Generator[None]:
    """Raise `KeyboardInterrupt` for all signals that end a program and are not ignored."""
    handlers = {one: signal.getsignal(one) for one in SIGNALS}
    handlers = {one: before for one, before in handlers.items() if before is not signal.SIG_IGN}
    for one in handlers:
        signal.signal(one, _interrupt)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_watch_signals, args=(reading,), daemon=True).start()
    try:
        yield
    finally:
        if _state.signal_time:  # threads that still work, and Python's own exit code, are not waited for
            _end_process()
        signal.set_wakeup_fd(before)
        os.close(writing)
        for one, handler in handlers.items():
            signal.signal(one, handler)


@contextmanager
def rescue_answer(save: Callable[[], str]) -> Generator[None]:
    """Save a partial result if a block is interrupted.

    `save` stores the result and returns a sentence. It is called once, from another thread if this thread is in a
    compiled run. An empty sentence leaves the interrupt to the enclosing blocks.

    Raises:
        InterruptError: the block was interrupted; the error has the sentence.
    """
    rescue = _Rescue(save)
    if threading.current_thread() is threading.main_thread():
        _state.rescues.append(rescue)
    try:
        yield
    except KeyboardInterrupt:
        sentence = rescue.run()
        if not sentence:
            raise
        _state.reported = True
        raise InterruptError(sentence) from None
    finally:
        if rescue in _state.rescues:
            _state.rescues.remove(rescue)


@contextmanager
def hold_interrupts() -> Generator[None]:
    """Delay interrupts to the end of a short block, such as one that writes to a store."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _state.delays += 1
    try:
        yield
    finally:
        _state.delays -= 1
        if _state.waiting and not _state.delays:
            _state.waiting = False
            raise KeyboardInterrupt


def accept_interrupt() -> None:
    """Continue after an interrupt; the watching thread does not end the process."""
    _state.accepted = time.monotonic()
    _state.signal_time = 0.0


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise `KeyboardInterrupt` once; delay it within `hold_interrupts`."""
    del number, frame
    now = time.monotonic()
    if _state.signal_time or now - _state.accepted < TWICE:
        return
    _state.signal_time = now
    if _state.delays:
        _state.waiting = True
        return
    raise KeyboardInterrupt


def _watch_signals(reading: int) -> None:
    """End the process if the main thread does not."""
    while numbers := os.read(reading, 1):
        came = time.monotonic()
        if signal.getsignal(numbers[0]) is not _interrupt:  # a server has its own rule
            continue
        time.sleep(GRACE)
        if _state.accepted < came - TWICE:
            _end_process()
    os.close(reading)


def _end_process() -> None:
    """Save results, print the sentence, kill child processes, and exit."""
    sentence = _rescue_all() or "Interrupted."
    beside = threading.current_thread() is not threading.main_thread()
    if _state.reported and beside:  # by the main thread, which is given the time to
        time.sleep(TWICE)
    elif not _state.reported:
        os.write(2, f"{CLEAR_LINE if os.isatty(2) else ''}error: {sentence}\n".encode())
    if "multiprocessing" in sys.modules:
        from multiprocessing import active_children

        for child in active_children():
            child.kill()
    sys.stderr.flush()
    os._exit(InterruptError.exit_code)


def _rescue_all() -> str:
    """Save all results and return the first sentence, innermost block first."""
    first = ""
    for rescue in reversed(_state.rescues):
        try:
            sentence = rescue.run()
        except Exception as error:  # the end comes all the same
            sentence = str(error)
        first = first or sentence
    return first
