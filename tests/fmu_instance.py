"""An instance of an FMU through FMPy's calls of the interface, with variables by name.

A refused call gives its status instead of an exception; what the FMU says of it is in `said`.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave

OK, WARNING, DISCARD, ERROR = range(4)


class Instance:
    """An FMU of FMI 2.0 or 3.0, for co-simulation."""

    def __init__(self, path: Path, token: str | None = None) -> None:
        self.folder, self.said = tempfile.mkdtemp(), list[str]()
        folder = str(path) if path.is_dir() else extract(str(path), self.folder)
        described: Any = read_model_description(str(path))
        self.names = {one.name: one.valueReference for one in described.modelVariables}
        self.second = described.fmiVersion == "2.0"
        slave: Any = FMU2Slave if self.second else FMU3Slave
        self.fmu = slave(
            guid=token or described.guid,
            unzipDirectory=folder,
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="one",
        )
        if self.second:
            self.callbacks = fmi2CallbackFunctions()
            self.callbacks.logger = fmi2CallbackLoggerTYPE(self._second_says)
            self.fmu.instantiate(callbacks=self.callbacks)
        else:
            self.fmu.instantiate(logMessage=self._third_says)

    def _second_says(self, _environment: Any, _name: Any, status: int, *texts: bytes) -> None:
        self.said.append(f"{status} {texts[0].decode()}: {texts[1].decode()}")

    def _third_says(self, _environment: Any, status: int, category: bytes, text: bytes) -> None:
        self.said.append(f"{status} {category.decode()}: {text.decode()}")

    def status(self, name: str, *arguments: Any) -> int:
        """How a call of FMPy's ends."""
        try:
            getattr(self.fmu, name)(*arguments)
        except FMICallException as error:
            return error.status
        return OK

    def set(self, values: Mapping[str | int, float]) -> int:
        """Set variables by name, or by value reference."""
        references = [self.names[k] if isinstance(k, str) else k for k in values]
        name = "setReal" if self.second else "setFloat64"
        return self.status(name, references, list(values.values()))

    def get(self, *names: str | int) -> list[float]:
        """Values of variables by name, or by value reference."""
        references = [self.names[k] if isinstance(k, str) else k for k in names]
        return (self.fmu.getReal if self.second else self.fmu.getFloat64)(references)

    def begin(self, values: Mapping[str | int, float] | None = None) -> Instance:
        """Go through the initialization."""
        if self.second:
            self.fmu.setupExperiment(startTime=0.0)
        assert self.set(values or {}) == OK
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def step(self, time: float, length: float) -> int:
        """How a step ends."""
        return self.status("doStep", time, length)

    def close(self) -> None:
        """Give everything back."""
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)
