"""Labelled data of results, in memory and as netCDF-4 files.

A result is described once, as variables with dimensions, unit, long name and symbol, and as attributes. A file holds
this description alone and opens as the same description; xarray reads the file as a dataset. Units are SI in the
spelling of the CF conventions (CF-1.10, UDUNITS). Unknown numbers are NaN.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import OUTPUTS, PROFILES
from martensite.base.errors import DataError, UnknownNameError
from martensite.base.files import write_file
from martensite.base.object_text import encode
from martensite.logs.binary_files import read_apart
from martensite.physics.materials.base import Material
from martensite.simulate.alarms import RunWarnings
from martensite.simulate.restarts import PassState, Restart
from martensite.simulate.result import Result, Variants

if TYPE_CHECKING:
    import xarray

CONVENTIONS = "CF-1.10"
TIME = "time"
CELL = "cell"
ACTUATOR = "actuator"
VARIANT = "variant"
RESTART = "restart"
KEPT, WORST = ("lowest", "highest", "gap of"), ("ripple", "residual")
"""Numbers stored at a restart: per judged quantity, and of the time integration."""
LABELS = "labels of all variables"
KEPT_RESULT = "martensite_result"
"""Attribute with the remaining fields of a `Result` (`martensite.base.object_text`)."""
IN_VARIABLES = ("times", "columns", "profiles", "restarts")
"""Fields of a `Result` that are variables of the file."""
NOT_KEPT = ("trace",)
"""Fields of a `Result` that are not saved: the compiled program of a track."""


@dataclass(frozen=True)
class Variable:
    """Labelled column."""

    dims: tuple[str, ...]
    values: Any
    """Array with one axis per dimension."""
    attrs: dict[str, Any]
    """CF attributes: `units`, `long_name`, `symbol`."""


@dataclass(frozen=True)
class LabelledData:
    """Variables and attributes of a result; the first variable is the time axis."""

    variables: dict[str, Variable]
    attrs: dict[str, Any]

    def __getitem__(self, name: str) -> Variable:
        """Return a variable; raise `UnknownNameError` for an unknown name."""
        if name not in self.variables:
            raise UnknownNameError("variable", name, self.variables)
        return self.variables[name]

    def __repr__(self) -> str:
        rows = (f"  {n} [{v.attrs.get('units', '')}] {v.dims} {v.values.shape}" for n, v in self.variables.items())
        return "\n".join([f"LabelledData: {self.attrs.get('title', '')}", *rows])

    def to_xarray(self) -> xarray.Dataset:
        """Return a dataset over time [s], with units and provenance as attributes.

        Raises:
            InputError: xarray is not installed.
        """
        columns = {name: (v.dims, v.values, v.attrs) for name, v in self.variables.items()}
        axes = {name: columns.pop(name) for name in (TIME, CELL, ACTUATOR) if name in columns}
        import xarray

        return xarray.Dataset(columns, coords=axes, attrs=self.attrs)


def describe_result(
    result: Result, scenario_text: str = "", material: Material | None = None, citations: Iterable[str] = ()
) -> LabelledData:
    """Return a result as labelled data.

    Args:
        result: result of a run or batch.
        scenario_text: whole scenario file, kept verbatim.
        material: material whose numbers were used.
        citations: BibTeX keys of the models and numbers.
    """
    time = {TIME: _label((TIME,), "s", "time", "t", _to_array(result.times), axis="T")}
    attributes = _list_attributes(result)
    if result.variants is not None:
        return LabelledData(time | _by_variant(result, result.variants), attributes)
    stacked = {label for labels in list_stacked(result) for label in labels.values()}
    columns = {name: _describe_column(result, name) for name in result.outputs if name not in stacked}
    attributes["scenario"] = scenario_text
    attributes["material"] = material.name if material else ""
    attributes["citations"] = ", ".join(citations)
    more = _by_actuator(result) | _describe_profiles(result) | _describe_restarts(result)
    return LabelledData(time | columns | more, attributes)


def _describe_restarts(result: Result) -> dict[str, Variable]:
    """Return the exact numbers stored at restarts, for every pass."""
    if not result.restarts:
        return {}
    judged = list(result.system.convergence_scales())
    names = [*result.state_names, *(f"{word} {name}" for word in KEPT for name in judged), *WORST]
    rows = [[[*_fill(one, len(judged))] for one in restart.passes] for restart in result.restarts]
    times = _to_array(one.time for one in result.restarts)
    words = "numbers of a state, then what the march knows of the way there"
    return {
        f"{RESTART}_number": _label((f"{RESTART}_number",), "", words, "", np.asarray(names, dtype=object)),
        f"{RESTART}_time": _label((RESTART,), "s", "time at which a state is kept", "t", times),
        f"{RESTART}_state": _label((RESTART, "pass", f"{RESTART}_number"), "", "states", "", np.asarray(rows, float)),
    }


def _fill(one: PassState, judged: int) -> Iterator[float]:
    """Yield the numbers of a pass; unknown ones are NaN."""
    yield from one.state
    for row in (one.low, one.high, one.gap):
        yield from row or [np.nan] * judged
    yield from (one.ripple, one.residual)


def read_restarts(saved: LabelledData) -> tuple[list[Restart], list[str]]:
    """Return the restarts of a saved result and the names of the numbers of a state."""
    variables = saved.variables
    if f"{RESTART}_state" not in variables:
        return [], []
    names = [str(one) for one in variables[f"{RESTART}_number"].values]
    judged = sum(one.startswith(f"{KEPT[0]} ") for one in names)
    size = len(names) - len(KEPT) * judged - len(WORST)
    ends = [size, size + judged, size + 2 * judged, size + 3 * judged]

    def unpack(row: list[float]) -> PassState:
        parts = [tuple(row[a:b]) for a, b in zip([0, *ends], ends, strict=False)]
        state, *extremes = parts
        low, high, gap = (() if np.isnan(one).any() else one for one in extremes)
        return PassState(state, low, high, gap, *row[-len(WORST) :])

    table = variables[f"{RESTART}_state"].values.tolist()
    times = variables[f"{RESTART}_time"].values.tolist()
    rows = zip(times, table, strict=True)
    return [Restart(time, tuple(map(unpack, passes))) for time, passes in rows], names[:size]


def save_result(
    result: Result,
    path: str | os.PathLike[str],
    scenario_text: str = "",
    citations: Iterable[str] = (),
    material: Material | None = None,
) -> None:
    """Write a result as netCDF-4; the file is replaced as a whole or not at all.

    Args:
        result: result to save.
        path: file to write; its folder must exist.
        scenario_text: whole scenario file, kept verbatim.
        citations: BibTeX keys of the models and numbers.
        material: material whose numbers were used.

    Raises:
        DataError: the file cannot be written.
    """
    import h5netcdf

    described = describe_result(result, scenario_text, material, citations)
    whole = io.BytesIO()  # HDF5 ends the process if it cannot finish a file on a full disk
    with h5netcdf.File(whole, "w") as file:
        file.attrs.update(described.attrs)
        for name, variable in described.variables.items():
            for dim, size in zip(variable.dims, variable.values.shape, strict=True):
                if dim not in file.dimensions:
                    file.dimensions[dim] = size
            text = variable.values.dtype == object
            kind = h5netcdf.core.h5py.string_dtype() if text else None
            checked = {} if text or not variable.dims else {"fletcher32": True}  # a damaged number is noticed
            written = file.create_variable(name, variable.dims, data=variable.values, dtype=kind, **checked)
            written.attrs.update(variable.attrs)
    write_file(path, whole.getbuffer())


def read_labelled(path: str | os.PathLike[str]) -> LabelledData:
    """Return the variables and attributes of a saved result.

    Raises:
        DataError: the file does not exist or is not a result.
    """
    path = Path(path)
    if not path.is_file():
        raise DataError(f"There is no file `{path}`; give a netCDF file written by `save`.")
    arrays = read_apart(path, f"{__name__}:read_variables", path.stat().st_size)
    labels = json.loads(str(arrays.pop(LABELS)))
    values = {name: one.astype(object) if one.dtype.kind == "U" else one for name, one in arrays.items()}
    about = labels["variables"].items()
    variables = {name: Variable(tuple(dims), values[name], attrs) for name, (dims, attrs) in about}
    saved = LabelledData(variables, labels["attrs"])
    lacking = [TIME] if TIME not in variables else []
    lacking += ["martensite_version"] if "martensite_version" not in saved.attrs else []
    if lacking:
        raise DataError(f"The file `{path}` is no saved result: it lacks `{lacking[0]}`.")
    return saved


def read_variables(path: Path) -> dict[str, Any]:
    """Return the arrays of a netCDF file by name; `LABELS` is the JSON of dimensions and attributes."""
    import h5netcdf

    def plain(value: Any) -> Any:
        return value.tolist() if isinstance(value, np.ndarray | np.generic) else value

    with h5netcdf.File(path, "r", decode_vlen_strings=True) as file:
        try:
            arrays = {name: np.asarray(one[...]) for name, one in file.variables.items()}
        except OSError:
            raise DataError(f"`{path.name}` is damaged: its values differ from their checksums.") from None
        about = {
            name: (one.dimensions, {key: plain(value) for key, value in one.attrs.items()})
            for name, one in file.variables.items()
        }
        labels = {"variables": about, "attrs": {key: plain(value) for key, value in file.attrs.items()}}
    texts = {name: one.astype(str) if one.dtype.kind == "O" else one for name, one in arrays.items()}
    return {LABELS: np.array(json.dumps(labels)), **texts}


def _label(dims: tuple[str, ...], unit: str, long_name: str, symbol: str, values: Any, **more: str) -> Variable:
    return Variable(dims, values, {"units": unit, "long_name": long_name, "symbol": symbol, **more})


def _describe_column(result: Result, name: str) -> Variable:
    _, long_name, symbol = result.outputs[name]
    return _label((TIME,), result.unit(name), long_name, symbol, _to_array(result.columns[name]))


def _by_variant(result: Result, variants: Variants) -> dict[str, Variable]:
    """Return the variables of a batch, with the varied parameters and the end of each run."""
    leaves = {leaf.path: leaf.declared for leaf in result.system.leaves()}
    columns = {
        path: _label((VARIANT,), leaves[path].unit, leaves[path].doc, path, _to_array(values))
        for path, values in variants.over.items()
    }
    names = np.asarray([one.name for one in variants.status], dtype=object)
    columns["ended"] = _label((VARIANT,), "s", "time at which the run ended", "", variants.ended)
    columns["status"] = _label((VARIANT,), "", "how the run ended", "", names)
    if variants.accuracy is not None:
        columns["accuracy"] = _label((VARIANT,), "1", "error bound", "", variants.accuracy)
    return columns | {
        name: _label((VARIANT, TIME), unit, words, symbol, result[name])
        for name, (unit, words, symbol) in result.outputs.items()
    }


def list_stacked(result: Result) -> list[dict[str, str]]:
    """Return the column of each actuator by the name of its stacked variable, for each of several actuators."""
    system = result.system
    ports = [port for port in system.actuators() if "." in system.label(port, "drive")]
    return [{name: system.label(port, name) for name in OUTPUTS} for port in ports]


def _by_actuator(result: Result) -> dict[str, Variable]:
    stacked = list_stacked(result)
    if not stacked:
        return {}
    names = np.asarray(list(result.system.actuators()), dtype=object)
    columns = {ACTUATOR: _label((ACTUATOR,), "", "port of the mechanism", "", names)}
    for name, (_, long_name, symbol) in OUTPUTS.items():
        labels = [one[name] for one in stacked]
        units = {result.unit(label) for label in labels}
        values = np.stack([_to_array(result[label]) for label in labels], axis=1)
        unit = units.pop() if len(units) == 1 else "mixed"
        columns[name] = _label((TIME, ACTUATOR), unit, long_name, symbol, values)
    return columns


def _describe_profiles(result: Result) -> dict[str, Variable]:
    if not result.profiles:
        return {}
    (actuator,) = result.system.actuators().values()
    columns = {CELL: _label((CELL,), "m", "place of a cell", "y", _to_array(actuator.element.places()))}
    for name, cells in result.profiles.items():
        values = np.stack([_to_array(cell) for cell in cells], axis=1)
        columns[name] = _label((TIME, CELL), *PROFILES[name], values)
    return columns


def _to_array(values: Iterable[float]) -> Any:
    return np.asarray(list(values), dtype=np.float64)


def _list_attributes(result: Result) -> dict[str, Any]:
    attributes = {
        "Conventions": CONVENTIONS,
        "title": f"Simulation of {result.system.description()}",
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "status": result.status.name,
        "status_meaning": result.status.sentence,
        "status_time": result.status_time,
        "accuracy": result.accuracy,
        "start": result.start,
        "runtime": result.runtime,
        "noise_seed": result.seed,
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
        KEPT_RESULT: _keep_result(result),
    }
    return {name: value for name, value in attributes.items() if value is not None}


def _keep_result(result: Result) -> str | None:
    """Return the remaining fields of a result as text, or None if a field has no text form."""
    left_out = (*IN_VARIABLES, *NOT_KEPT)
    own = {one.name: getattr(result, one.name) for one in fields(result) if one.name not in left_out}
    own["begin"] = result.start
    own["judged"] = RunWarnings(result.alarms, result.warnings[len(result.notes) :])
    own["extremes"] = {} if result.variants is not None else dict(result.extremes)
    try:
        return json.dumps(encode(own), ensure_ascii=False)
    except DataError:
        return None


def _name_balance(name: str, balance: Mapping[str, float | None]) -> dict[str, float | None]:
    """Prefix the terms of a balance [J] with its name; `work` stays."""
    return {key if key == name else f"{name}_{key}": value for key, value in balance.items()}


def _find_version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
