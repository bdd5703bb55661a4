"""Files that a run writes: checked before it starts, complete or absent afterwards."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from martensite.base.errors import DataError
from martensite.show.figures.files import FORMATS

DATA = (".nc",)
FIGURE = tuple(f".{name}" for name in FORMATS)


@dataclass(frozen=True)
class Outputs:
    """Where a run goes; None for what is not wanted."""

    data: Path | None
    figure: Path | None
    profile: Path | None = None
    """A figure of what differs along the element."""

    def paths(self) -> list[Path]:
        """The files that will be written."""
        return [path for path in (self.data, self.figure, self.profile) if path is not None]

    def check(self, force: bool, data: tuple[str, ...] = DATA, option: str = "--force") -> Outputs:
        """Raise `DataError` if a file has a wrong ending, no folder, or is there already.

        Args:
            force: files that are there may be replaced.
            data: endings allowed for the data file.
            option: the one that allows it.
        """
        _ending(self.data, data)
        _ending(self.figure, FIGURE)
        _ending(self.profile, FIGURE)
        for path in self.paths():
            if not path.parent.is_dir():
                raise DataError(f"There is no folder `{path.parent}` to write `{path.name}` into.")
            if not os.access(path.parent, os.W_OK):
                raise DataError(f"The folder `{path.parent}` cannot be written to.")
            if path.exists() and not force:
                raise DataError(
                    f"`{path}` is there already; use {option} to replace it, "
                    "or write to another file."
                )
        return self


def _ending(path: Path | None, endings: tuple[str, ...]) -> None:
    if path is not None and path.suffix.lower() not in endings:
        raise DataError(f"`{path}` must end in {' or '.join(endings)}.")


@contextmanager
def parts(outputs: Outputs) -> Iterator[Outputs]:
    """Names to write to; the files take their places together once all are complete."""
    mark = os.getpid()
    beside = {p: p.with_name(f".{p.stem}.{mark}{p.suffix}") for p in outputs.paths()}

    def part(path: Path | None) -> Path | None:
        return None if path is None else beside[path]

    try:
        yield Outputs(part(outputs.data), part(outputs.figure), part(outputs.profile))
        for path, written in beside.items():
            written.replace(path)
    finally:
        for written in beside.values():
            written.unlink(missing_ok=True)
