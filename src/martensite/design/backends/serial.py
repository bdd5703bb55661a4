"""One chunk after another, in this process."""

from __future__ import annotations

from collections.abc import Generator, Iterable

from martensite.design.backends.base import BACKENDS, AbstractBackend, Job, Report


@BACKENDS.register("serial")
class Serial(AbstractBackend):
    """This process alone."""

    def run(self, job: Job, chunks: Iterable[int]) -> Generator[Report]:
        """One chunk after another."""
        for chunk in chunks:
            yield job(chunk)
