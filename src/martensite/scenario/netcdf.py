"""Results as labelled data: an xarray dataset in memory, netCDF-4 on disk.

A result is described once, as variables with dimensions, unit, long name and symbol and as attributes of the whole.
`to_dataset` and `save` only carry this description over, so that a file that is opened again equals the dataset that
would have been made. `save` writes with h5netcdf directly: importing xarray takes longer than a run.

Units are the SI units of the library in the spelling of the CF conventions (CF-1.10), which
is that of UDUNITS. Numbers that are not known (an accuracy that was not estimated) are NaN.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import OUTPUTS, PROFILES
from martensite.base.errors import DataError
from martensite.base.files import replace_file
from martensite.physics.materials.base import Material
from martensite.simulate.result import Result, Variants

if TYPE_CHECKING:
    import xarray

CONVENTIONS = "CF-1.10"
ENGINE = "h5netcdf"
TIME = "time"
CELL = "cell"
ACTUATOR = "actuator"
VARIANT = "variant"


@dataclass(frozen=True)
class Variable:
    """One labelled column."""

    name: str
    dims: tuple[str, ...]
    unit: str
    """SI unit, as UDUNITS spells it."""
    long_name: str
    symbol: str
    data: Any
    """Values in `unit`, one axis per dimension."""
    attrs: dict[str, str] = field(default_factory=dict[str, str])
    """What else is known of the column."""

    def attributes(self) -> dict[str, str]:
        """All attributes, under their CF names."""
        own = {"units": self.unit, "long_name": self.long_name, "symbol": self.symbol}
        return {**own, **self.attrs}


@dataclass(frozen=True)
class Description:
    """A result as variables and attributes; the time axis is the first variable."""

    variables: list[Variable]
    attributes: dict[str, str | int | float]


def describe_result(
    result: Result, scenario_text: str = "", material: Material | None = None, citations: Iterable[str] = ()
) -> Description:
    """Describe a result as variables and attributes, whatever they are written to."""
    time = Variable(TIME, (TIME,), "s", "time", "t", _to_array(result.times), {"axis": "T"})
    if result.variants is not None:
        return Description([time, *_by_variant(result, result.variants)], _list_attributes(result))
    stacked = {result.system.label(port, name) for port in _list_ports(result) for name in OUTPUTS}
    columns = [_describe_column(result, name) for name in result.outputs if name not in stacked]
    attributes = _list_attributes(result)
    attributes["scenario"] = scenario_text
    attributes["material"] = material.name if material else ""
    attributes["citations"] = ", ".join(citations)
    return Description([time, *columns, *_by_actuator(result), *_describe_profiles(result)], attributes)


def to_dataset(
    result: Result, scenario_text: str = "", material: Material | None = None, citations: Iterable[str] = ()
) -> xarray.Dataset:
    """The result as a dataset over time [s], with units and provenance as attributes.

    Args:
        result: what to describe.
        scenario_text: the whole scenario file, kept verbatim.
        material: the material whose numbers were used.
        citations: BibTeX keys of the models and numbers used.
    """
    import xarray

    description = describe_result(result, scenario_text, material, citations)
    arrays = {v.name: (v.dims, v.data, v.attributes()) for v in description.variables}
    axes = {name: arrays.pop(name) for name in (TIME, CELL, ACTUATOR) if name in arrays}
    return xarray.Dataset(arrays, coords=axes, attrs=description.attributes)


def save_result(
    result: Result,
    path: str | os.PathLike[str],
    scenario_text: str = "",
    citations: Iterable[str] = (),
    material: Material | None = None,
) -> None:
    """Write the result as netCDF-4; the file is replaced as a whole or not at all.

    Args:
        result: what to save.
        path: file to write; its folder must exist.
        scenario_text: the whole scenario file, kept verbatim.
        citations: BibTeX keys of the models and numbers used.
        material: the material whose numbers were used.

    Raises:
        DataError: the file cannot be written.
    """
    import h5netcdf

    description = describe_result(result, scenario_text, material, citations)
    whole = io.BytesIO()  # HDF5 ends the process if it cannot finish a file on a full disk
    with h5netcdf.File(whole, "w") as file:
        file.attrs.update(description.attributes)
        for variable in description.variables:
            for name, size in zip(variable.dims, variable.data.shape, strict=True):
                if name not in file.dimensions:
                    file.dimensions[name] = size
            text = variable.data.dtype == object
            written = file.create_variable(
                variable.name,
                variable.dims,
                data=variable.data,
                dtype=h5netcdf.core.h5py.string_dtype() if text else None,
            )
            written.attrs.update(variable.attributes())
    with replace_file(Path(path)) as part:
        part.write_bytes(whole.getbuffer())


def open_result(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read a saved result into memory; the file is closed again.

    Raises:
        DataError: there is no such file, or it holds no result.
    """
    import xarray

    path = Path(path)
    if not path.is_file():
        raise DataError(f"There is no file `{path}`; give a netCDF file written by `save`.")
    try:
        dataset = xarray.load_dataset(path, engine=ENGINE)
    except (OSError, ValueError) as error:
        raise DataError(f"The file `{path}` cannot be read as netCDF-4: {error}.") from None
    if TIME not in dataset.variables:
        raise DataError(f"The file `{path}` is no saved result: it lacks `{TIME}`.")
    if "martensite_version" not in dataset.attrs:
        raise DataError(f"The file `{path}` is no saved result: it lacks `martensite_version`.")
    return dataset


def _describe_column(result: Result, name: str) -> Variable:
    _, long_name, symbol = result.outputs[name]
    data = _to_array(result.columns[name])
    return Variable(name, (TIME,), result.unit(name), long_name, symbol, data)


def _by_variant(result: Result, variants: Variants) -> list[Variable]:
    """Of a batch: its columns over variants and time, in what they differ, and how they ended."""
    leaves = {leaf.path: leaf.declared for leaf in result.system.leaves()}
    differ = [
        Variable(path, (VARIANT,), leaves[path].unit, leaves[path].doc, path, _to_array(values))
        for path, values in variants.over.items()
    ]
    names = np.asarray([one.name for one in variants.status], dtype=object)
    ended = Variable("ended", (VARIANT,), "s", "time at which the run ended", "", variants.ended)
    status = Variable("status", (VARIANT,), "", "how the run ended", "", names)
    known = [] if variants.accuracy is None else [("accuracy", "error bound", variants.accuracy)]
    more = [Variable(name, (VARIANT,), "1", words, "", data) for name, words, data in known]
    columns = [
        Variable(name, (VARIANT, TIME), unit, words, symbol, result[name])
        for name, (unit, words, symbol) in result.outputs.items()
    ]
    return [*differ, ended, status, *more, *columns]


def _list_ports(result: Result) -> list[str]:
    """Ports of several actuators, whose outputs carry their names."""
    system = result.system
    return [port for port in system.actuators() if "." in system.label(port, "drive")]


def _by_actuator(result: Result) -> list[Variable]:
    system, ports = result.system, _list_ports(result)
    if not ports:
        return []
    names = np.asarray(ports, dtype=object)
    found = [Variable(ACTUATOR, (ACTUATOR,), "", "port of the mechanism", "", names)]
    for name, (_, long_name, symbol) in OUTPUTS.items():
        labels = [system.label(port, name) for port in ports]
        units = {result.unit(label) for label in labels}
        data = np.stack([_to_array(result[label]) for label in labels], axis=1)
        unit = units.pop() if len(units) == 1 else "mixed"
        found.append(Variable(name, (TIME, ACTUATOR), unit, long_name, symbol, data))
    return found


def _describe_profiles(result: Result) -> list[Variable]:
    if not result.profiles:
        return []
    (actuator,) = result.system.actuators().values()
    places = _to_array(actuator.element.places())
    where = Variable(CELL, (CELL,), "m", "place of a cell", "y", places)
    found = [where]
    for name, cells in result.profiles.items():
        unit, long_name, symbol = PROFILES[name]
        data = np.stack([_to_array(cell) for cell in cells], axis=1)
        found.append(Variable(name, (TIME, CELL), unit, long_name, symbol, data))
    return found


def _to_array(values: Iterable[float]) -> Any:
    return np.asarray(list(values), dtype=np.float64)


def _list_attributes(result: Result) -> dict[str, str | int | float]:
    found: dict[str, str | int | float | None] = {
        "Conventions": CONVENTIONS,
        "title": f"Simulation of {result.system.description()}",
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "status": result.status.name,
        "status_meaning": result.status.sentence,
        "status_time": result.status_time,
        "accuracy": result.accuracy,
        "runtime": result.runtime,
        "steps": int(result.steps),
        "rejected_steps": int(result.rejected),
        "step": float(result.step),
        "ripple": float(result.ripple),
        **_name_balance("heat", {} if result.heat is None else result.heat.as_dict()),
        **_name_balance("work", {} if result.work is None else result.work.as_dict()),
        "unbalanced": "\n".join(result.unbalanced) or None,
        "conformance": json.dumps(result.conformance) if result.conformance else None,
        "warnings": "\n".join(result.warnings),
        "alarms": json.dumps([asdict(alarm) for alarm in result.alarms], ensure_ascii=False),
        "martensite_version": _find_version("martensite"),
        "numpy_version": np.__version__,
        "h5netcdf_version": _find_version("h5netcdf"),
    }
    return {name: value for name, value in found.items() if value is not None}


def _name_balance(name: str, balance: Mapping[str, float | None]) -> dict[str, float | None]:
    """Those of a balance, called `heat_lost` or `work_springs` [J]; the work itself is `work`."""
    return {key if key == name else f"{name}_{key}": value for key, value in balance.items()}


def _find_version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
