"""Limit of the processor time."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from threading import Event, Thread


class OutOfTimeError(KeyboardInterrupt):
    """End of a search whose time box is used up; the search keeps its best result as after Ctrl-C."""


class TimeBox:
    """Processor time of this process and its children; sets an event when it is used up."""

    def __init__(self, seconds: float) -> None:
        self.halt, self._ended = Event(), Event()
        self.over = False
        self._begun, self._seconds = measure_processor_time(), seconds

    @property
    def share(self) -> float:
        """Return the used fraction of the time box."""
        return min((measure_processor_time() - self._begun) / self._seconds, 1.0)

    def limit(self, part: float) -> Callable[[object], None]:
        """Return a function that raises `OutOfTimeError` once a fraction of the time box is used."""

        def check(note: object) -> None:
            del note
            if self.share >= part:
                raise OutOfTimeError

        return check

    @contextmanager
    def watch(self, part: float) -> Generator[None]:
        """Set the event after a fraction of the time box."""

        def look() -> None:
            while not self._ended.wait(0.1):
                if self.share >= part:
                    self.over = True
                    self.halt.set()
                    return

        Thread(target=look, daemon=True).start()
        try:
            yield
        finally:
            self._ended.set()


def measure_processor_time() -> float:
    """Return the processor time of this process and its finished children [s]."""
    return float(sum(os.times()[:4]))
