"""Records at equal intervals: inputs and outputs of a system.

Missing outputs are NaN; all inputs must be known because a model needs them. Values are in the units of `units`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError

Numbers: TypeAlias = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Sampled:
    """Sampled inputs and outputs of a system."""

    name: str
    interval: float
    """Sample time T_s [s]."""
    inputs: Numbers
    """Shape (samples, inputs)."""
    outputs: Numbers
    """Shape (samples, outputs); NaN for missing samples."""
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict[str, str])
    """Unit of each signal."""
    start: float = 0.0
    """Time of the first sample [s]."""
    remarks: tuple[str, ...] = ()
    """Changes to the measured table, one sentence each."""

    def __post_init__(self) -> None:
        for name in ("inputs", "outputs"):
            array = np.asarray(getattr(self, name), dtype=float)
            array = array[:, None] if array.ndim == 1 else array
            object.__setattr__(self, name, array)
        shapes = (len(self.input_names), len(self.output_names))
        if (self.inputs.shape[1], self.outputs.shape[1]) != shapes:
            raise DataError(
                f"Record `{self.name}` has {self.inputs.shape[1]} inputs and "
                f"{self.outputs.shape[1]} outputs, but names for {shapes[0]} and {shapes[1]}."
            )
        if len(self.inputs) != len(self.outputs) or not len(self.inputs):
            raise DataError(
                f"Record `{self.name}` needs as many samples of outputs as of inputs, and at "
                f"least one; it has {len(self.outputs)} and {len(self.inputs)}."
            )
        if not np.all(np.isfinite(self.inputs)):
            bad = int(np.argmin(np.all(np.isfinite(self.inputs), axis=1)))
            raise DataError(
                f"Inputs of record `{self.name}` must be known throughout, but are missing at "
                f"sample {bad}; fill or cut them first."
            )
        if not self.interval > 0.0:
            raise DataError(f"The sample time of record `{self.name}` must be above 0 s, but is {self.interval} s.")

    def __len__(self) -> int:
        return len(self.inputs)

    @property
    def times(self) -> Numbers:
        """Return the times of the samples [s]."""
        return self.start + self.interval * np.arange(len(self))

    @property
    def duration(self) -> float:
        """Return the length of the record [s]."""
        return self.interval * len(self)

    @cached_property
    def hash(self) -> str:
        """Return the SHA-256 of sample time, names and values (little-endian doubles)."""
        total = hashlib.sha256()
        names = "\0".join([*self.input_names, "", *self.output_names])
        total.update(f"{self.interval!r}\0{names}\0".encode())
        for array in (self.inputs, self.outputs):
            total.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        return total.hexdigest()

    def rows(self, first: int, last: int | None = None, name: str | None = None) -> Sampled:
        """Return a slice of samples as a separate record."""
        rows = slice(first, last)
        begin = range(len(self))[rows].start
        return replace(
            self,
            name=name or self.name,
            inputs=self.inputs[rows],
            outputs=self.outputs[rows],
            start=self.start + begin * self.interval,
        )

    def with_outputs(self, outputs: Numbers, names: tuple[str, ...] | None = None) -> Sampled:
        """Return a record with the same inputs and other outputs."""
        return replace(self, outputs=outputs, output_names=names or self.output_names)
