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
    from martensite.control.averaging import Averaging as Averaging
    from martensite.control.averaging import compare_averaging as compare_averaging
    from martensite.control.closed_loop import ControlledModel as ControlledModel
    from martensite.control.tuning import Tuning as Tuning
    from martensite.control.tuning import tune as tune
    from martensite.controllers.constant_power import ConstantPower as ConstantPower
    from martensite.controllers.latched import LatchedOnOff as LatchedOnOff
    from martensite.controllers.on_off import OnOff as OnOff
    from martensite.controllers.pid import Gains as Gains
    from martensite.controllers.pid import Pid as Pid
    from martensite.electrical.current import CurrentSource as CurrentSource
    from martensite.electrical.furst_seelecke import (
        FurstSeeleckeResistance as FurstSeeleckeResistance,
    )
    from martensite.electrical.mixture import MixtureResistance as MixtureResistance
    from martensite.electrical.per_length import PerLengthResistance as PerLengthResistance
    from martensite.electrical.power import PowerSource as PowerSource
    from martensite.electrical.power_pwm import PowerPwm as PowerPwm
    from martensite.electrical.pwm import PwmVoltage as PwmVoltage
    from martensite.electrical.temperature import PrescribedTemperature as PrescribedTemperature
    from martensite.electrical.voltage import VoltageSource as VoltageSource
    from martensite.elements.axial_wire import AxialWire as AxialWire
    from martensite.elements.bundle import Bundle as Bundle
    from martensite.elements.chain import Chain as Chain
    from martensite.elements.coil_spring import CoilSpring as CoilSpring
    from martensite.elements.limits import Limits as Limits
    from martensite.elements.ribbon import Ribbon as Ribbon
    from martensite.elements.wire import Wire as Wire
    from martensite.errors import InputError as InputError
    from martensite.errors import MartensiteError as MartensiteError
    from martensite.errors import SolveError as SolveError
    from martensite.export.control_systems import to_control as to_control
    from martensite.export.control_systems import to_state_space as to_state_space
    from martensite.export.mjcf import bridge_of as bridge_of
    from martensite.export.mjcf import tendon_signals as tendon_signals
    from martensite.export.mjcf import to_mjcf as to_mjcf
    from martensite.export.mujoco_bridge import MujocoBridge as MujocoBridge
    from martensite.export.mujoco_bridge import TendonActuator as TendonActuator
    from martensite.export.mujoco_render import render_mujoco as render_mujoco
    from martensite.export.mujoco_rest import holding_tensions as holding_tensions
    from martensite.export.mujoco_result import MujocoResult as MujocoResult
    from martensite.identify.blocks.shared.play import PlaySum as PlaySum
    from martensite.identify.chains.chain import Chain as _BlockChain
    from martensite.identify.chains.estimate import estimate as _estimate_model
    from martensite.identify.chains.linearise import linearise as linearise
    from martensite.identify.chains.linearise import static_curve as static_curve
    from martensite.identify.chains.options import Options as _EstimateOptions
    from martensite.identify.chains.search import search as _search_structures
    from martensite.identify.chains.stages import Stage as Stage
    from martensite.identify.chains.stages import identify_stages as identify_stages
    from martensite.identify.chains.uncertainty import uncertainty as _model_uncertainty
    from martensite.identify.chains.validation import validate as _validate_model
    from martensite.identify.chains.written import parse_chain as parse_chain
    from martensite.identify.estimate import Estimate as Estimate
    from martensite.identify.film import FilmFit as FilmFit
    from martensite.identify.film import fit_film as fit_film
    from martensite.identify.film_points import FilmPoints as FilmPoints
    from martensite.identify.film_points import points_from_power as points_from_power
    from martensite.identify.film_report import FilmReport as FilmReport
    from martensite.identify.film_report import judge_film as judge_film
    from martensite.identify.fitting.experiment import Experiment as Experiment
    from martensite.identify.fitting.fit import Fit as Fit
    from martensite.identify.fitting.free import Wish as Wish
    from martensite.identify.fitting.problem import Problem as Problem
    from martensite.identify.fitting.problem import problem as problem
    from martensite.identify.fitting.profiled import profiled as profiled
    from martensite.identify.fitting.solve import solve as solve
    from martensite.identify.motor import MotorConstants as MotorConstants
    from martensite.identify.motor import motor_constants as motor_constants
    from martensite.identify.motor_tests import steady_running as steady_running
    from martensite.identify.motor_tests import winding_resistance as winding_resistance
    from martensite.identify.rise import Rise as Rise
    from martensite.identify.rise import fit_rise as fit_rise
    from martensite.identify.smoothing import moving_average as moving_average
    from martensite.identify.spectrum import SpectralPeak as SpectralPeak
    from martensite.identify.spectrum import natural_frequency as natural_frequency
    from martensite.identify.tangent_fit import TangentFit as TangentFit
    from martensite.identify.tangent_fit import tangent_fit as tangent_fit
    from martensite.identify.tangents import TangentPoints as TangentPoints
    from martensite.identify.tangents import tangent_points as tangent_points
    from martensite.identify.vibration import LogDecrement as LogDecrement
    from martensite.identify.vibration import log_decrement as log_decrement
    from martensite.io.compare import compare as compare
    from martensite.io.fitting.api import fit as fit
    from martensite.io.fitting.api import read_problem as read_problem
    from martensite.io.material_files import write_material as write_material
    from martensite.io.model_files import read_model as read_model
    from martensite.io.model_files import write_model as write_model
    from martensite.io.netcdf import open_result as open_result
    from martensite.io.netcdf import save as save
    from martensite.io.netcdf import to_dataset as to_dataset
    from martensite.io.public_benchmarks import read_silverbox as read_silverbox
    from martensite.io.public_benchmarks import read_wiener_hammerstein as read_wiener_hammerstein
    from martensite.io.sampled_files import read_sampled as read_sampled
    from martensite.io.sampled_files import write_sampled as write_sampled
    from martensite.io.scenario import Scenario as Scenario
    from martensite.io.scenario import load as load
    from martensite.io.staircase import plateaus as plateaus
    from martensite.io.staircase import unwrap_counter as unwrap_counter
    from martensite.io.tables import read_table as read_table
    from martensite.laws.brinson import Brinson as Brinson
    from martensite.laws.elahinia import Elahinia as Elahinia
    from martensite.laws.lagoudas import Lagoudas as Lagoudas
    from martensite.laws.liang_rogers import LiangRogers as LiangRogers
    from martensite.laws.mas import MullerAchenbachSeelecke as MullerAchenbachSeelecke
    from martensite.laws.mas_hybrid import (
        MullerAchenbachSeeleckeHybrid as MullerAchenbachSeeleckeHybrid,
    )
    from martensite.laws.mas_polycrystal import (
        MullerAchenbachSeeleckePolycrystal as MullerAchenbachSeeleckePolycrystal,
    )
    from martensite.laws.tanaka import Tanaka as Tanaka
    from martensite.materials.base import Material as Material
    from martensite.materials.base import load_material as load_material
    from martensite.materials.base import material_names as material_names
    from martensite.materials.wires import load_wires as load_wires
    from martensite.mechanisms.beam_motor import BeamMotor as BeamMotor
    from martensite.mechanisms.beam_motor import modal_numbers as modal_numbers
    from martensite.mechanisms.bias_spring import BiasSpring as BiasSpring
    from martensite.mechanisms.dead_weight import DeadWeight as DeadWeight
    from martensite.mechanisms.finger import Finger as Finger
    from martensite.mechanisms.hand import Hand as Hand
    from martensite.mechanisms.lever import Lever as Lever
    from martensite.mechanisms.parallel_platform import ParallelPlatform as ParallelPlatform
    from martensite.mechanisms.pulley import AntagonisticPulley as AntagonisticPulley
    from martensite.mechanisms.shared.beam_modes import BeamModes as BeamModes
    from martensite.mechanisms.shared.beam_modes import CantileverBeam as CantileverBeam
    from martensite.mechanisms.shared.beam_modes import beam_modes as beam_modes
    from martensite.mechanisms.shared.platform_kinematics import Plates as Plates
    from martensite.mechanisms.shared.platform_kinematics import platform_angles as platform_angles
    from martensite.mechanisms.shared.platform_kinematics import (
        platform_lengths as platform_lengths,
    )
    from martensite.mechanisms.shared.platform_workspace import Workspace as Workspace
    from martensite.mechanisms.shared.platform_workspace import reachable_angles as reachable_angles
    from martensite.mechanisms.testing_machine import TensileTestingMachine as TensileTestingMachine
    from martensite.plot.film_fit import plot_film as plot_film
    from martensite.plot.fit import plot_fit as plot_fit
    from martensite.plot.fit import plot_fit_loops as plot_fit_loops
    from martensite.plot.fit_knowledge import plot_correlation as plot_correlation
    from martensite.plot.fit_knowledge import plot_search as plot_search
    from martensite.plot.fit_knowledge import plot_singular_values as plot_singular_values
    from martensite.plot.fit_likelihood import plot_likelihood as plot_likelihood
    from martensite.plot.fit_residuals import plot_fit_residuals as plot_fit_residuals
    from martensite.plot.law_paths import plot_point as plot_point
    from martensite.plot.model import plot_model as plot_model
    from martensite.plot.model import plot_model_loop as plot_model_loop
    from martensite.plot.model_tests import plot_model_tests as plot_model_tests
    from martensite.plot.overview import plot_result as plot_result
    from martensite.plot.overview import save_figure as save_figure
    from martensite.plot.profile import plot_profile as plot_profile
    from martensite.plot.tangents import plot_tangents as plot_tangents
    from martensite.plot.workspace import plot_workspace as plot_workspace
    from martensite.report.fit_report import write_report as write_report
    from martensite.report.model_report import write_model_report as write_model_report
    from martensite.sensors.infrared import InfraredSensor as InfraredSensor
    from martensite.sensors.position import PositionSensor as PositionSensor
    from martensite.signals.carrier import Carrier as Carrier
    from martensite.signals.constant import Constant as Constant
    from martensite.signals.held import Held as Held
    from martensite.signals.pwm import PulseWidthModulation as PulseWidthModulation
    from martensite.signals.ramp import Ramp as Ramp
    from martensite.signals.records import Record as Record
    from martensite.signals.records import table_waveform as table_waveform
    from martensite.signals.sampling.resampling import resampled as resampled
    from martensite.signals.sampling.sampled import Sampled as Sampled
    from martensite.signals.sampling.trends import detrended as detrended
    from martensite.signals.sine import Sine as Sine
    from martensite.signals.staircase import Staircase as Staircase
    from martensite.signals.step import Step as Step
    from martensite.signals.table import Table as Table
    from martensite.signals.triangle import Triangle as Triangle
    from martensite.simulate.alarms import Alarm as Alarm
    from martensite.simulate.api import simulate as simulate
    from martensite.simulate.batch import Batch as Batch
    from martensite.simulate.batch import Sensitivity as Sensitivity
    from martensite.simulate.batch import sensitivity as sensitivity
    from martensite.simulate.batch import simulate_batch as simulate_batch
    from martensite.simulate.closed_loop import Loop as Loop
    from martensite.simulate.closed_loop import simulate_loop as simulate_loop
    from martensite.simulate.controlled import simulate_controlled as simulate_controlled
    from martensite.simulate.point import Leg as Leg
    from martensite.simulate.point import PointResult as PointResult
    from martensite.simulate.point import material_point as material_point
    from martensite.simulate.result import Result as Result
    from martensite.sizing.candidates import size_wire as size_wire
    from martensite.sizing.request import WireRequest as WireRequest
    from martensite.system.actuator import Actuator as Actuator
    from martensite.system.actuator import Group as Group
    from martensite.system.machine import Machine as Machine
    from martensite.system.single import System as System
    from martensite.thermal.base import Environment as Environment
    from martensite.thermal.churchill_bernstein import ChurchillBernstein as ChurchillBernstein
    from martensite.thermal.churchill_chu import ChurchillChu as ChurchillChu
    from martensite.thermal.combined import CombinedCooling as CombinedCooling
    from martensite.thermal.constant import ConstantCooling as ConstantCooling
    from martensite.thermal.ends import AdiabaticEnds as AdiabaticEnds
    from martensite.thermal.ends import ClampedEnds as ClampedEnds
    from martensite.thermal.fluids.air import Air as Air
    from martensite.thermal.fluids.air_table import AirTable as AirTable
    from martensite.thermal.fluids.oil import Oil as Oil
    from martensite.thermal.fluids.water import Water as Water
    from martensite.thermal.lefevre_ede import LeFevreEde as LeFevreEde
    from martensite.thermal.morgan import Morgan as Morgan
    from martensite.thermal.polynomial import PolynomialCooling as PolynomialCooling
    from martensite.thermal.radiation import Radiation as Radiation

    __version__: str
    # Names that are others at home; an import under another name is not public by itself.
    BlockChain = _BlockChain
    EstimateOptions = _EstimateOptions
    estimate_model = _estimate_model
    model_uncertainty = _model_uncertainty
    search_structures = _search_structures
    validate_model = _validate_model

_HOME = {
    "Actuator": "system.actuator",
    "AdiabaticEnds": "thermal.ends",
    "Air": "thermal.fluids.air",
    "AirTable": "thermal.fluids.air_table",
    "Alarm": "simulate.alarms",
    "AntagonisticPulley": "mechanisms.pulley",
    "Averaging": "control.averaging",
    "AxialWire": "elements.axial_wire",
    "Batch": "simulate.batch",
    "BeamModes": "mechanisms.shared.beam_modes",
    "BeamMotor": "mechanisms.beam_motor",
    "BiasSpring": "mechanisms.bias_spring",
    "BlockChain": "identify.chains.chain:Chain",
    "Brinson": "laws.brinson",
    "Bundle": "elements.bundle",
    "CantileverBeam": "mechanisms.shared.beam_modes",
    "Carrier": "signals.carrier",
    "Chain": "elements.chain",
    "ChurchillBernstein": "thermal.churchill_bernstein",
    "ChurchillChu": "thermal.churchill_chu",
    "ClampedEnds": "thermal.ends",
    "CoilSpring": "elements.coil_spring",
    "CombinedCooling": "thermal.combined",
    "Constant": "signals.constant",
    "ConstantCooling": "thermal.constant",
    "ConstantPower": "controllers.constant_power",
    "ControlledModel": "control.closed_loop",
    "CurrentSource": "electrical.current",
    "DeadWeight": "mechanisms.dead_weight",
    "Elahinia": "laws.elahinia",
    "Environment": "thermal.base",
    "Estimate": "identify.estimate",
    "EstimateOptions": "identify.chains.options:Options",
    "Experiment": "identify.fitting.experiment",
    "FilmFit": "identify.film",
    "FilmPoints": "identify.film_points",
    "FilmReport": "identify.film_report",
    "Finger": "mechanisms.finger",
    "Fit": "identify.fitting.fit",
    "FurstSeeleckeResistance": "electrical.furst_seelecke",
    "Gains": "controllers.pid",
    "Group": "system.actuator",
    "Hand": "mechanisms.hand",
    "Held": "signals.held",
    "InfraredSensor": "sensors.infrared",
    "InputError": "errors",
    "Lagoudas": "laws.lagoudas",
    "LatchedOnOff": "controllers.latched",
    "LeFevreEde": "thermal.lefevre_ede",
    "Leg": "simulate.point",
    "Lever": "mechanisms.lever",
    "LiangRogers": "laws.liang_rogers",
    "Limits": "elements.limits",
    "LogDecrement": "identify.vibration",
    "Loop": "simulate.closed_loop",
    "Machine": "system.machine",
    "MartensiteError": "errors",
    "Material": "materials.base",
    "MixtureResistance": "electrical.mixture",
    "Morgan": "thermal.morgan",
    "MotorConstants": "identify.motor",
    "MujocoBridge": "export.mujoco_bridge",
    "MujocoResult": "export.mujoco_result",
    "MullerAchenbachSeelecke": "laws.mas",
    "MullerAchenbachSeeleckeHybrid": "laws.mas_hybrid",
    "MullerAchenbachSeeleckePolycrystal": "laws.mas_polycrystal",
    "Oil": "thermal.fluids.oil",
    "OnOff": "controllers.on_off",
    "ParallelPlatform": "mechanisms.parallel_platform",
    "PerLengthResistance": "electrical.per_length",
    "Pid": "controllers.pid",
    "Plates": "mechanisms.shared.platform_kinematics",
    "PlaySum": "identify.blocks.shared.play",
    "PointResult": "simulate.point",
    "PolynomialCooling": "thermal.polynomial",
    "PositionSensor": "sensors.position",
    "PowerPwm": "electrical.power_pwm",
    "PowerSource": "electrical.power",
    "PrescribedTemperature": "electrical.temperature",
    "Problem": "identify.fitting.problem",
    "PulseWidthModulation": "signals.pwm",
    "PwmVoltage": "electrical.pwm",
    "Radiation": "thermal.radiation",
    "Ramp": "signals.ramp",
    "Record": "signals.records",
    "Result": "simulate.result",
    "Ribbon": "elements.ribbon",
    "Rise": "identify.rise",
    "Sampled": "signals.sampling.sampled",
    "Scenario": "io.scenario",
    "Sensitivity": "simulate.batch",
    "Sine": "signals.sine",
    "SolveError": "errors",
    "SpectralPeak": "identify.spectrum",
    "Stage": "identify.chains.stages",
    "Staircase": "signals.staircase",
    "Step": "signals.step",
    "System": "system.single",
    "Table": "signals.table",
    "Tanaka": "laws.tanaka",
    "TangentFit": "identify.tangent_fit",
    "TangentPoints": "identify.tangents",
    "TendonActuator": "export.mujoco_bridge",
    "TensileTestingMachine": "mechanisms.testing_machine",
    "Triangle": "signals.triangle",
    "Tuning": "control.tuning",
    "VoltageSource": "electrical.voltage",
    "Water": "thermal.fluids.water",
    "Wire": "elements.wire",
    "WireRequest": "sizing.request",
    "Wish": "identify.fitting.free",
    "Workspace": "mechanisms.shared.platform_workspace",
    "beam_modes": "mechanisms.shared.beam_modes",
    "bridge_of": "export.mjcf",
    "compare": "io.compare",
    "compare_averaging": "control.averaging",
    "detrended": "signals.sampling.trends",
    "estimate_model": "identify.chains.estimate:estimate",
    "fit": "io.fitting.api",
    "fit_film": "identify.film",
    "fit_rise": "identify.rise",
    "holding_tensions": "export.mujoco_rest",
    "identify_stages": "identify.chains.stages",
    "judge_film": "identify.film_report",
    "linearise": "identify.chains.linearise",
    "load": "io.scenario",
    "load_material": "materials.base",
    "load_wires": "materials.wires",
    "log_decrement": "identify.vibration",
    "material_names": "materials.base",
    "material_point": "simulate.point",
    "modal_numbers": "mechanisms.beam_motor",
    "model_uncertainty": "identify.chains.uncertainty:uncertainty",
    "motor_constants": "identify.motor",
    "moving_average": "identify.smoothing",
    "natural_frequency": "identify.spectrum",
    "open_result": "io.netcdf",
    "parse_chain": "identify.chains.written",
    "plateaus": "io.staircase",
    "platform_angles": "mechanisms.shared.platform_kinematics",
    "platform_lengths": "mechanisms.shared.platform_kinematics",
    "plot_correlation": "plot.fit_knowledge",
    "plot_film": "plot.film_fit",
    "plot_fit": "plot.fit",
    "plot_fit_loops": "plot.fit",
    "plot_fit_residuals": "plot.fit_residuals",
    "plot_likelihood": "plot.fit_likelihood",
    "plot_model": "plot.model",
    "plot_model_loop": "plot.model",
    "plot_model_tests": "plot.model_tests",
    "plot_point": "plot.law_paths",
    "plot_profile": "plot.profile",
    "plot_result": "plot.overview",
    "plot_search": "plot.fit_knowledge",
    "plot_singular_values": "plot.fit_knowledge",
    "plot_tangents": "plot.tangents",
    "plot_workspace": "plot.workspace",
    "points_from_power": "identify.film_points",
    "problem": "identify.fitting.problem",
    "profiled": "identify.fitting.profiled",
    "reachable_angles": "mechanisms.shared.platform_workspace",
    "read_model": "io.model_files",
    "read_problem": "io.fitting.api",
    "read_sampled": "io.sampled_files",
    "read_silverbox": "io.public_benchmarks",
    "read_table": "io.tables",
    "read_wiener_hammerstein": "io.public_benchmarks",
    "render_mujoco": "export.mujoco_render",
    "resampled": "signals.sampling.resampling",
    "save": "io.netcdf",
    "save_figure": "plot.overview",
    "search_structures": "identify.chains.search:search",
    "sensitivity": "simulate.batch",
    "simulate": "simulate.api",
    "simulate_batch": "simulate.batch",
    "simulate_controlled": "simulate.controlled",
    "simulate_loop": "simulate.closed_loop",
    "size_wire": "sizing.candidates",
    "solve": "identify.fitting.solve",
    "static_curve": "identify.chains.linearise",
    "steady_running": "identify.motor_tests",
    "table_waveform": "signals.records",
    "tangent_fit": "identify.tangent_fit",
    "tangent_points": "identify.tangents",
    "tendon_signals": "export.mjcf",
    "to_control": "export.control_systems",
    "to_dataset": "io.netcdf",
    "to_mjcf": "export.mjcf",
    "to_state_space": "export.control_systems",
    "tune": "control.tuning",
    "unwrap_counter": "io.staircase",
    "validate_model": "identify.chains.validation:validate",
    "winding_resistance": "identify.motor_tests",
    "write_material": "io.material_files",
    "write_model": "io.model_files",
    "write_model_report": "report.model_report",
    "write_report": "report.fit_report",
    "write_sampled": "io.sampled_files",
}
"""Public name -> module of this package that defines it, and the name there if it is another."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name == "__version__":
        return _version()
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, own = _HOME[name].partition(":")
    value = getattr(import_module(f"{__name__}.{module}"), own or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names."""
    return [*_HOME, "__version__"]


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("martensite")
    except PackageNotFoundError:  # run from a source tree that was not installed
        return "0+unknown"
