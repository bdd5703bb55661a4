"""Log of a board over its time: a table that `fit` and `identify` read without options.

Headings have units. The description of the firmware with its calibration, and the scenario, are in the lines above a
text table, in the metadata of Parquet, and in metadata and an attachment of MCAP.
"""

from __future__ import annotations

import json
import struct
from array import array
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError
from martensite.base.files import replace_file
from martensite.base.lazy import import_extra
from martensite.boards.link.frames import BoardClock, LinkCounts
from martensite.boards.link.messages import Message

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

ENDINGS = (".csv", ".parquet", ".mcap")


@dataclass
class BoardLog:
    """Telemetry of a board, sample by sample."""

    firmware: dict[str, Any]
    clock: BoardClock = field(default_factory=BoardClock)
    _numbers: array[float] = field(default_factory=lambda: array("d"))
    """Row after row: an hour at 1 kHz takes a quarter of a gigabyte."""

    def take(self, message: Message) -> bool:
        """Store a message if it is telemetry, and return whether it is."""
        if message.name != "telemetry":
            return False
        values = message.values
        time = 1e-6 * self.clock.unwrap(values["time"])
        self._numbers.extend((time, values["flags"], values["alarm"], *values["values"]))
        return True

    def __len__(self) -> int:
        return len(self._numbers) // len(self.names)

    @property
    def latest(self) -> dict[str, float]:
        """Return the newest sample by name; empty before the first."""
        names = self.names
        return dict(zip(names, self._numbers[-len(names) :], strict=True)) if self._numbers else {}

    @property
    def names(self) -> list[str]:
        """Return the names of the columns."""
        return ["time", "status", "alarm", *(row["name"] for row in self.firmware["telemetry"])]

    def headings(self) -> list[str]:
        """Return the names with units; dimensionless columns have one only if a reader needs it."""
        from martensite.logs.layout import CANONICAL

        units = ["s", "1", "1", *(row["unit"] for row in self.firmware["telemetry"])]
        return [
            f"{name} [{unit}]" if unit != "1" or name.rpartition(".")[2] in CANONICAL else name
            for name, unit in zip(self.names, units, strict=True)
        ]

    def table(self, first: int = 0) -> NDArray[np.float64]:
        """Return the rows from a given one on, in SI; time starts at the first sample of all."""
        import numpy as np

        rows = np.array(self._numbers[first * len(self.names) :], dtype=float).reshape(-1, len(self.names))
        if len(rows):
            rows[:, 0] -= self._numbers[0]
        return rows

    def plot(self) -> Figure:
        """Return a figure of every column but the status over time.

        Raises:
            DataError: the log is empty.
        """
        if not self._numbers:
            raise DataError("Nothing was heard from the board: there is nothing to draw.")
        from martensite.show.figures.style import make_figure, use_style

        table, headings = self.table(), self.headings()
        columns = [k for k, name in enumerate(self.names) if name not in ("time", "status")]
        with use_style():
            figure = make_figure(7.0, 1.0 + 1.6 * len(columns))
            for row, k in enumerate(columns):
                axes = figure.add_subplot(len(columns), 1, row + 1)
                axes.step(table[:, 0], table[:, k], where="post")
                axes.set(ylabel=headings[k])
            figure.axes[-1].set(xlabel="time [s]")
        return figure

    def describe(self, counts: LinkCounts) -> dict[str, str]:
        """Return the metadata of the table."""
        plain = {key: value for key, value in self.firmware.items() if key != "scenario"}
        return {"written by": "martensite hardware", "frames": counts.describe(), "firmware": json.dumps(plain)}

    def write(self, path: Path, counts: LinkCounts) -> None:
        """Write `.csv`, `.parquet` or `.mcap`.

        Raises:
            DataError: the log is empty, or the file cannot be written.
            InputError: the extra for the format is not installed.
        """
        if not self._numbers:
            raise DataError("Nothing was heard from the board: there is no log to write.")
        writers = {".csv": self._write_text, ".parquet": self._write_parquet, ".mcap": self._write_mcap}
        writers[path.suffix.lower()](path, self.describe(counts))

    def _write_text(self, path: Path, metadata: dict[str, str]) -> None:
        lines = [f"# {key}: {value}" for key, value in metadata.items()]
        lines += [f"# scenario: {json.dumps(self.firmware['scenario'])}", ",".join(self.headings())]
        with replace_file(path) as part, part.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(f"{line}\n" for line in lines)
            file.writelines(",".join(f"{x:.9g}" for x in row) + "\n" for row in self.table().tolist())

    def _write_parquet(self, path: Path, metadata: dict[str, str]) -> None:
        arrow = import_extra("pyarrow", "parquet", "pyarrow")
        parquet = import_extra("pyarrow.parquet", "parquet", "pyarrow")
        columns = dict(zip(self.headings(), self.table().T, strict=True))
        table = arrow.table(columns).replace_schema_metadata(metadata | {"scenario": self.firmware["scenario"]})
        with replace_file(path) as part:
            parquet.write_table(table, part)

    def _write_mcap(self, path: Path, metadata: dict[str, str]) -> None:
        writer_of = import_extra("mcap.writer", "mcap", "mcap").Writer
        names = self.headings()[1:]
        schema = {"type": "object", "properties": {name: {"type": "number"} for name in names}}
        with replace_file(path) as part, part.open("wb") as file:
            writer = writer_of(file)
            writer.start(profile="", library="martensite")
            kind = writer.register_schema("martensite.telemetry", "jsonschema", json.dumps(schema).encode())
            channel = writer.register_channel("telemetry", "json", kind)
            for row in self.table():
                stamp, data = round(1e9 * row[0]), json.dumps(dict(zip(names, map(float, row[1:]), strict=True)))
                writer.add_message(channel, log_time=stamp, publish_time=stamp, data=data.encode())
            writer.add_metadata("martensite", metadata)
            scenario = self.firmware["scenario"].encode()
            writer.add_attachment(0, 0, "scenario.toml", "application/toml", scenario)
            writer.finish()


def read_log_scenario(path: Path) -> str:
    """Return the scenario in a log; an empty text without one, or for a damaged file, which its reader refuses.

    Raises:
        DataError: the line of the scenario is damaged.
    """
    ending = path.suffix.lower()
    with suppress(ValueError, OSError):  # also errors of pyarrow
        if ending == ".parquet":
            parquet = import_extra("pyarrow.parquet", "parquet", "pyarrow")
            return (parquet.read_schema(path).metadata or {}).get(b"scenario", b"").decode()
        if ending == ".mcap":
            return _read_attachment(path)
        with path.open(encoding="utf-8", errors="replace") as file:
            for line in takewhile(lambda one: one.startswith("#"), file):
                if line.startswith("# scenario: "):
                    return _read_line(path, line)
    return ""


def _read_line(path: Path, line: str) -> str:
    try:
        return str(json.loads(line.removeprefix("# scenario: ")))
    except ValueError:
        raise DataError(f"`{path.name}`: its line `# scenario: …` is damaged; delete it, or give --scenario.") from None


def _read_attachment(path: Path) -> str:
    reader = import_extra("mcap.reader", "mcap", "mcap").make_reader
    damaged = import_extra("mcap.exceptions", "mcap", "mcap").McapError
    with path.open("rb") as file, suppress(damaged, struct.error):
        return next((one.data.decode() for one in reader(file).iter_attachments()), "")
    return ""
