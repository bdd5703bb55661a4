"""Model and simulate shape-memory-alloy actuators.

    import martensite as ms
    result = ms.load("finger.toml").run()

The names below are imported when they are first used, so that `import martensite` costs
nothing; their home modules (`martensite.laws.liang_rogers`, …) may be imported just as well.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

# A subpackage becomes an attribute on its first import and never again: bring that about here
# and free the name, so that `martensite.simulate` is the function whatever is imported later.
import_module("martensite.simulate")
globals().pop("simulate", None)

if TYPE_CHECKING:
    from martensite.electrical.current import CurrentSource
    from martensite.electrical.mixture import MixtureResistance
    from martensite.electrical.per_length import PerLengthResistance
    from martensite.electrical.power import PowerSource
    from martensite.electrical.temperature import PrescribedTemperature
    from martensite.electrical.voltage import VoltageSource
    from martensite.elements.limits import Limits
    from martensite.elements.wire import Wire
    from martensite.errors import InputError, MartensiteError, SolveError
    from martensite.io.compare import compare
    from martensite.io.netcdf import open_result, save, to_dataset
    from martensite.io.records import Record, table_waveform
    from martensite.io.scenario import Scenario, load
    from martensite.io.tables import read_table
    from martensite.laws.liang_rogers import LiangRogers
    from martensite.materials.base import Material, load_material, material_names
    from martensite.mechanisms.bias_spring import BiasSpring
    from martensite.mechanisms.dead_weight import DeadWeight
    from martensite.plot.overview import plot_result, save_figure
    from martensite.signals.constant import Constant
    from martensite.signals.pwm import PulseWidthModulation
    from martensite.signals.ramp import Ramp
    from martensite.signals.sine import Sine
    from martensite.signals.staircase import Staircase
    from martensite.signals.step import Step
    from martensite.signals.table import Table
    from martensite.signals.triangle import Triangle
    from martensite.simulate.api import simulate
    from martensite.simulate.result import Result
    from martensite.system import System
    from martensite.thermal.base import Environment
    from martensite.thermal.constant import ConstantCooling
    from martensite.thermal.polynomial import PolynomialCooling

    __version__: str

_HOME = {
    "BiasSpring": "mechanisms.bias_spring",
    "Constant": "signals.constant",
    "ConstantCooling": "thermal.constant",
    "CurrentSource": "electrical.current",
    "DeadWeight": "mechanisms.dead_weight",
    "Environment": "thermal.base",
    "InputError": "errors",
    "LiangRogers": "laws.liang_rogers",
    "Limits": "elements.limits",
    "MartensiteError": "errors",
    "Material": "materials.base",
    "MixtureResistance": "electrical.mixture",
    "PerLengthResistance": "electrical.per_length",
    "PolynomialCooling": "thermal.polynomial",
    "PowerSource": "electrical.power",
    "PrescribedTemperature": "electrical.temperature",
    "PulseWidthModulation": "signals.pwm",
    "Ramp": "signals.ramp",
    "Record": "io.records",
    "Result": "simulate.result",
    "Scenario": "io.scenario",
    "Sine": "signals.sine",
    "SolveError": "errors",
    "Staircase": "signals.staircase",
    "Step": "signals.step",
    "System": "system",
    "Table": "signals.table",
    "Triangle": "signals.triangle",
    "VoltageSource": "electrical.voltage",
    "Wire": "elements.wire",
    "compare": "io.compare",
    "load": "io.scenario",
    "load_material": "materials.base",
    "material_names": "materials.base",
    "open_result": "io.netcdf",
    "plot_result": "plot.overview",
    "read_table": "io.tables",
    "save": "io.netcdf",
    "save_figure": "plot.overview",
    "simulate": "simulate.api",
    "table_waveform": "io.records",
    "to_dataset": "io.netcdf",
}
"""Public name -> module of this package that defines it."""

__all__ = [
    "BiasSpring",
    "Constant",
    "ConstantCooling",
    "CurrentSource",
    "DeadWeight",
    "Environment",
    "InputError",
    "LiangRogers",
    "Limits",
    "MartensiteError",
    "Material",
    "MixtureResistance",
    "PerLengthResistance",
    "PolynomialCooling",
    "PowerSource",
    "PrescribedTemperature",
    "PulseWidthModulation",
    "Ramp",
    "Record",
    "Result",
    "Scenario",
    "Sine",
    "SolveError",
    "Staircase",
    "Step",
    "System",
    "Table",
    "Triangle",
    "VoltageSource",
    "Wire",
    "__version__",
    "compare",
    "load",
    "load_material",
    "material_names",
    "open_result",
    "plot_result",
    "read_table",
    "save",
    "save_figure",
    "simulate",
    "table_waveform",
    "to_dataset",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name == "__version__":
        return _version()
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names."""
    return __all__


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("martensite")
    except PackageNotFoundError:  # run from a source tree that was not installed
        return "0+unknown"
