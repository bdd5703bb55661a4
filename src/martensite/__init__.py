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
for _name in ("simulate", "sweep"):
    import_module(f"martensite.{_name}")
    globals().pop(_name, None)

if TYPE_CHECKING:
    from martensite.bench.bench import Bench as Bench
    from martensite.bench.consistency import Consistency as Consistency
    from martensite.bench.consistency import consistency as consistency
    from martensite.bench.faults.ambient_step import AmbientStep as AmbientStep
    from martensite.bench.faults.draught import Draught as Draught
    from martensite.bench.faults.drift import Drift as Drift
    from martensite.bench.faults.drop_out import DropOut as DropOut
    from martensite.bench.faults.open_circuit import OpenCircuit as OpenCircuit
    from martensite.bench.faults.stuck import Stuck as Stuck
    from martensite.bench.faults.supply_sag import SupplySag as SupplySag
    from martensite.bench.mounted import Mounted as Mounted
    from martensite.bench.parts import Controllers as Controllers
    from martensite.bench.parts import Faults as Faults
    from martensite.bench.parts import Observers as Observers
    from martensite.bench.parts import Sensors as Sensors
    from martensite.bench.realtime import RealtimeStep as RealtimeStep
    from martensite.bench.run import opened as _open_bench
    from martensite.bench.run import simulate_bench as simulate_bench
    from martensite.bench.supervisors.checks.above import OverCurrent as OverCurrent
    from martensite.bench.supervisors.checks.above import OverForce as OverForce
    from martensite.bench.supervisors.checks.above import Overheat as Overheat
    from martensite.bench.supervisors.checks.above import OverStress as OverStress
    from martensite.bench.supervisors.checks.base import Checks as Checks
    from martensite.bench.supervisors.checks.base import alarm_names as alarm_names
    from martensite.bench.supervisors.checks.mismatch import Mismatch as Mismatch
    from martensite.bench.supervisors.checks.open_circuit import NoCurrent as NoCurrent
    from martensite.bench.supervisors.checks.sensor_lost import SensorLost as SensorLost
    from martensite.bench.supervisors.checks.sensor_stuck import SensorStuck as SensorStuck
    from martensite.bench.supervisors.checks.thermal_bound import ThermalBound as ThermalBound
    from martensite.bench.supervisors.from_plant import guard_for as guard_for
    from martensite.bench.supervisors.from_sensors import checks_for as checks_for
    from martensite.bench.supervisors.guard import Guard as Guard
    from martensite.characterise.estimate import Estimate as Estimate
    from martensite.characterise.film_coefficient import FilmFit as FilmFit
    from martensite.characterise.film_coefficient import fit_film as fit_film
    from martensite.characterise.film_points import FilmPoints as FilmPoints
    from martensite.characterise.film_points import points_from_power as points_from_power
    from martensite.characterise.film_report import FilmReport as FilmReport
    from martensite.characterise.film_report import judge_film as judge_film
    from martensite.characterise.free_vibration import LogDecrement as LogDecrement
    from martensite.characterise.free_vibration import log_decrement as log_decrement
    from martensite.characterise.motor_constants import MotorConstants as MotorConstants
    from martensite.characterise.motor_constants import motor_constants as motor_constants
    from martensite.characterise.motor_tests import steady_running as steady_running
    from martensite.characterise.motor_tests import winding_resistance as winding_resistance
    from martensite.characterise.moving_average import moving_average as moving_average
    from martensite.characterise.spectrum import SpectralPeak as SpectralPeak
    from martensite.characterise.spectrum import natural_frequency as natural_frequency
    from martensite.characterise.tangent_fit import TangentFit as TangentFit
    from martensite.characterise.tangent_fit import tangent_fit as tangent_fit
    from martensite.characterise.tangent_points import TangentPoints as TangentPoints
    from martensite.characterise.tangent_points import tangent_points as tangent_points
    from martensite.characterise.time_constant import Rise as Rise
    from martensite.characterise.time_constant import fit_rise as fit_rise
    from martensite.control.analysis.energy import CycleEnergies as CycleEnergies
    from martensite.control.analysis.energy import energy_per_cycle as energy_per_cycle
    from martensite.control.analysis.frequency import FrequencyResponse as FrequencyResponse
    from martensite.control.analysis.frequency import frequency_response as frequency_response
    from martensite.control.analysis.speed import Speeds as Speeds
    from martensite.control.analysis.speed import speeds as speeds
    from martensite.control.averaging import Averaging as Averaging
    from martensite.control.averaging import compare_averaging as compare_averaging
    from martensite.control.closed_loop import ControlledModel as ControlledModel
    from martensite.control.design.inverse_hysteresis import (
        IdentifiedHysteresis as IdentifiedHysteresis,
    )
    from martensite.control.design.inverse_hysteresis import (
        identify_hysteresis as identify_hysteresis,
    )
    from martensite.control.design.linear import in_readings as in_readings
    from martensite.control.design.linear import linearised as _linearised_plant
    from martensite.control.design.linear import mean_of as _mean_readings
    from martensite.control.design.lqr import Regulator as Regulator
    from martensite.control.design.lqr import Sizes as _LqrSizes
    from martensite.control.design.lqr import lqr as lqr
    from martensite.control.design.operating_point import OperatingPoint as _SteadyPoint
    from martensite.control.design.operating_point import operating_point as _steady_point
    from martensite.control.design.operating_point import operating_point_at as _steady_point_at
    from martensite.control.rules.formulas import FirstOrder as FirstOrder
    from martensite.control.rules.formulas import Integrating as Integrating
    from martensite.control.rules.formulas import gains_by_rule as gains_by_rule
    from martensite.control.rules.relay import gains_by_relay as gains_by_relay
    from martensite.control.rules.relay import relay_test as relay_test
    from martensite.control.rules.rule_starts import best_rules as best_rules
    from martensite.control.rules.rule_starts import gains_by_tests as gains_by_tests
    from martensite.control.rules.rule_starts import loop_tests as loop_tests
    from martensite.control.rules.rule_starts import pid_values as pid_values
    from martensite.control.rules.step_test import step_test as step_test
    from martensite.control.search.bench_tuning import TunedBench as TunedBench
    from martensite.control.search.bench_tuning import tune_bench as tune_bench
    from martensite.control.search.gain_search import Search as _TuningSearch
    from martensite.control.search.goals import Goal as _TuningGoal
    from martensite.control.search.loop_runs import LoopRuns as LoopRuns
    from martensite.control.search.over_plants import over_plants as over_plants
    from martensite.control.search.perturbed import Plants as Plants
    from martensite.control.search.perturbed import draw_plants as draw_plants
    from martensite.control.tuning import Tuning as Tuning
    from martensite.control.tuning import tune as tune
    from martensite.controllers.cascade import Cascade as Cascade
    from martensite.controllers.constant_power import ConstantPower as ConstantPower
    from martensite.controllers.correction import Correction as Correction
    from martensite.controllers.direct import Direct as Direct
    from martensite.controllers.feedforward import Feedforward as Feedforward
    from martensite.controllers.inverse_play import InversePlay as InversePlay
    from martensite.controllers.latched import LatchedOnOff as LatchedOnOff
    from martensite.controllers.mpc import Mpc as Mpc
    from martensite.controllers.on_off import OnOff as OnOff
    from martensite.controllers.pid import Gains as Gains
    from martensite.controllers.pid import Pid as Pid
    from martensite.controllers.pid import PidGains as PidGains
    from martensite.controllers.pid import PidLaw as PidLaw
    from martensite.controllers.pid import per_sample as per_sample
    from martensite.controllers.planning import Price as _PlanPrice
    from martensite.controllers.planning import Search as _PlanSearch
    from martensite.controllers.scheduled_pid import GainsAt as GainsAt
    from martensite.controllers.scheduled_pid import Schedule as Schedule
    from martensite.controllers.scheduled_pid import ScheduledPid as ScheduledPid
    from martensite.controllers.sliding_mode import SlidingMode as SlidingMode
    from martensite.controllers.state_feedback import StateFeedback as StateFeedback
    from martensite.controllers.two_level import TwoLevel as TwoLevel
    from martensite.electrical.current import CurrentSource as CurrentSource
    from martensite.electrical.furst_seelecke import (
        FurstSeeleckeResistance as FurstSeeleckeResistance,
    )
    from martensite.electrical.h_bridge import HBridge as HBridge
    from martensite.electrical.linear_amplifier import LinearAmplifier as LinearAmplifier
    from martensite.electrical.mixture import MixtureResistance as MixtureResistance
    from martensite.electrical.mosfet import Mosfet as Mosfet
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
    from martensite.export.c_core import CCore as CCore
    from martensite.export.c_core import c_core as c_core
    from martensite.export.c_loop import c_loop as c_loop
    from martensite.export.control_systems import plant_state_space as plant_state_space
    from martensite.export.control_systems import to_control as to_control
    from martensite.export.control_systems import to_nonlinear_system as to_nonlinear_system
    from martensite.export.control_systems import to_state_space as to_state_space
    from martensite.export.fmu.archive import Fmu as Fmu
    from martensite.export.fmu.archive import to_fmu as to_fmu
    from martensite.export.gymnasium import SmaEnv as SmaEnv
    from martensite.export.gymnasium_vector import SmaVectorEnv as SmaVectorEnv
    from martensite.export.learning_task import Task as _LearningTask
    from martensite.export.mjcf import bridge_of as bridge_of
    from martensite.export.mjcf import tendon_signals as tendon_signals
    from martensite.export.mjcf import to_mjcf as to_mjcf
    from martensite.export.mjcf_snippet import to_mjcf_snippet as to_mjcf_snippet
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
    from martensite.identify.fitting.experiment import Experiment as Experiment
    from martensite.identify.fitting.fit import Fit as Fit
    from martensite.identify.fitting.free import Wish as Wish
    from martensite.identify.fitting.problem import Problem as Problem
    from martensite.identify.fitting.problem import problem as problem
    from martensite.identify.fitting.profiled import profiled as profiled
    from martensite.identify.fitting.solve import solve as solve
    from martensite.io.compare import compare as compare
    from martensite.io.fitting.api import fit as fit
    from martensite.io.fitting.api import read_problem as read_problem
    from martensite.io.material_files import write_material as write_material
    from martensite.io.model_files import read_model as read_model
    from martensite.io.model_files import write_model as write_model
    from martensite.io.netcdf import open_result as open_result
    from martensite.io.netcdf import save as save
    from martensite.io.public_benchmarks import read_silverbox as read_silverbox
    from martensite.io.public_benchmarks import read_wiener_hammerstein as read_wiener_hammerstein
    from martensite.io.sampled_files import read_sampled as read_sampled
    from martensite.io.sampled_files import write_sampled as write_sampled
    from martensite.io.scenario import Scenario as Scenario
    from martensite.io.scenario import load as load
    from martensite.io.staircase import plateaus as plateaus
    from martensite.io.staircase import unwrap_counter as unwrap_counter
    from martensite.io.sweeps.api import sweep as sweep
    from martensite.io.sweeps.dataset import open_sweep as open_sweep
    from martensite.io.sweeps.reading import read_sweep as read_sweep
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
    from martensite.observers.extended import ExtendedKalman as ExtendedKalman
    from martensite.observers.inverse import InverseModel as InverseModel
    from martensite.observers.shaken import Shaken as Shaken
    from martensite.observers.unscented import UnscentedKalman as UnscentedKalman
    from martensite.plot.bench import plot_bench as plot_bench
    from martensite.plot.energy import plot_energy as plot_energy
    from martensite.plot.film_fit import plot_film as plot_film
    from martensite.plot.fit import plot_fit as plot_fit
    from martensite.plot.fit import plot_fit_loops as plot_fit_loops
    from martensite.plot.fit_knowledge import plot_correlation as plot_correlation
    from martensite.plot.fit_knowledge import plot_search as plot_search
    from martensite.plot.fit_knowledge import plot_singular_values as plot_singular_values
    from martensite.plot.fit_likelihood import plot_likelihood as plot_likelihood
    from martensite.plot.fit_residuals import plot_fit_residuals as plot_fit_residuals
    from martensite.plot.frequency import plot_frequency_response as plot_frequency_response
    from martensite.plot.law_paths import plot_point as plot_point
    from martensite.plot.model import plot_model as plot_model
    from martensite.plot.model import plot_model_loop as plot_model_loop
    from martensite.plot.model_tests import plot_model_tests as plot_model_tests
    from martensite.plot.pareto import plot_pareto as plot_pareto
    from martensite.plot.profile import plot_profile as plot_profile
    from martensite.plot.sensitivity import plot_sensitivity as plot_sensitivity
    from martensite.plot.speeds import plot_speeds as plot_speeds
    from martensite.plot.sweep import plot_sweep as plot_sweep
    from martensite.plot.tangents import plot_tangents as plot_tangents
    from martensite.plot.tuning import plot_tuning as plot_tuning
    from martensite.plot.workspace import plot_workspace as plot_workspace
    from martensite.report.fit_report import write_report as write_report
    from martensite.report.model_report import write_model_report as write_model_report
    from martensite.sensors.current import CurrentSensor as CurrentSensor
    from martensite.sensors.encoder import EncoderSensor as EncoderSensor
    from martensite.sensors.force import ForceSensor as ForceSensor
    from martensite.sensors.gyroscope import GyroscopeSensor as GyroscopeSensor
    from martensite.sensors.ideal import IdealSensor as IdealSensor
    from martensite.sensors.infrared import InfraredSensor as InfraredSensor
    from martensite.sensors.position import PositionSensor as PositionSensor
    from martensite.sensors.resistance import ResistanceSensor as ResistanceSensor
    from martensite.sensors.thermocouple import ThermocoupleSensor as ThermocoupleSensor
    from martensite.sensors.tilt import TiltSensor as TiltSensor
    from martensite.sensors.voltage import VoltageSensor as VoltageSensor
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
    from martensite.simulate.lanes import Lanes as Lanes
    from martensite.simulate.measures.base import measure as measure
    from martensite.simulate.point import Leg as Leg
    from martensite.simulate.point import PointResult as PointResult
    from martensite.simulate.point import material_point as material_point
    from martensite.simulate.result import Result as Result
    from martensite.sizing.candidates import size_wire as size_wire
    from martensite.sizing.design.designed import Designed as Designed
    from martensite.sizing.design.optimise import optimise_design as optimise_design
    from martensite.sizing.design.scan import scan as _scan_designs
    from martensite.sizing.design.search import Search as _DesignSearch
    from martensite.sizing.request import WireRequest as WireRequest
    from martensite.sweep.backends.base import StoppedError as StoppedError
    from martensite.sweep.indices import Sensitivity as _SensitivityIndices
    from martensite.sweep.indices import sensitivity as _sensitivity_indices
    from martensite.sweep.pareto import ParetoFront as ParetoFront
    from martensite.sweep.pareto import pareto_front as pareto_front
    from martensite.sweep.table import SweepTable as SweepTable
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
    open_bench = _open_bench
    linearised_plant = _linearised_plant
    mean_readings = _mean_readings
    LqrSizes = _LqrSizes
    SteadyPoint = _SteadyPoint
    steady_point = _steady_point
    steady_point_at = _steady_point_at
    TuningSearch = _TuningSearch
    TuningGoal = _TuningGoal
    PlanPrice = _PlanPrice
    PlanSearch = _PlanSearch
    LearningTask = _LearningTask
    BlockChain = _BlockChain
    EstimateOptions = _EstimateOptions
    estimate_model = _estimate_model
    model_uncertainty = _model_uncertainty
    search_structures = _search_structures
    validate_model = _validate_model
    DesignSearch = _DesignSearch
    scan_designs = _scan_designs
    sensitivity_indices = _sensitivity_indices
    SensitivityIndices = _SensitivityIndices

_HOME = {
    "Actuator": "system.actuator",
    "AdiabaticEnds": "thermal.ends",
    "Air": "thermal.fluids.air",
    "AirTable": "thermal.fluids.air_table",
    "Alarm": "simulate.alarms",
    "AmbientStep": "bench.faults.ambient_step",
    "AntagonisticPulley": "mechanisms.pulley",
    "Averaging": "control.averaging",
    "AxialWire": "elements.axial_wire",
    "Batch": "simulate.batch",
    "BeamModes": "mechanisms.shared.beam_modes",
    "BeamMotor": "mechanisms.beam_motor",
    "Bench": "bench.bench",
    "BiasSpring": "mechanisms.bias_spring",
    "BlockChain": "identify.chains.chain:Chain",
    "Brinson": "laws.brinson",
    "Bundle": "elements.bundle",
    "CCore": "export.c_core",
    "CantileverBeam": "mechanisms.shared.beam_modes",
    "Carrier": "signals.carrier",
    "Cascade": "controllers.cascade",
    "Chain": "elements.chain",
    "Checks": "bench.supervisors.checks.base",
    "ChurchillBernstein": "thermal.churchill_bernstein",
    "ChurchillChu": "thermal.churchill_chu",
    "ClampedEnds": "thermal.ends",
    "CoilSpring": "elements.coil_spring",
    "CombinedCooling": "thermal.combined",
    "Consistency": "bench.consistency",
    "Constant": "signals.constant",
    "ConstantCooling": "thermal.constant",
    "ConstantPower": "controllers.constant_power",
    "ControlledModel": "control.closed_loop",
    "Controllers": "bench.parts",
    "Correction": "controllers.correction",
    "CurrentSensor": "sensors.current",
    "CurrentSource": "electrical.current",
    "CycleEnergies": "control.analysis.energy",
    "DeadWeight": "mechanisms.dead_weight",
    "DesignSearch": "sizing.design.search:Search",
    "Designed": "sizing.design.designed",
    "Direct": "controllers.direct",
    "Draught": "bench.faults.draught",
    "Drift": "bench.faults.drift",
    "DropOut": "bench.faults.drop_out",
    "Elahinia": "laws.elahinia",
    "EncoderSensor": "sensors.encoder",
    "Environment": "thermal.base",
    "Estimate": "characterise.estimate",
    "EstimateOptions": "identify.chains.options:Options",
    "Experiment": "identify.fitting.experiment",
    "ExtendedKalman": "observers.extended",
    "Faults": "bench.parts",
    "Feedforward": "controllers.feedforward",
    "FilmFit": "characterise.film_coefficient",
    "FilmPoints": "characterise.film_points",
    "FilmReport": "characterise.film_report",
    "Finger": "mechanisms.finger",
    "FirstOrder": "control.rules.formulas",
    "Fit": "identify.fitting.fit",
    "Fmu": "export.fmu.archive",
    "ForceSensor": "sensors.force",
    "FrequencyResponse": "control.analysis.frequency",
    "FurstSeeleckeResistance": "electrical.furst_seelecke",
    "Gains": "controllers.pid",
    "GainsAt": "controllers.scheduled_pid",
    "Group": "system.actuator",
    "Guard": "bench.supervisors.guard",
    "GyroscopeSensor": "sensors.gyroscope",
    "HBridge": "electrical.h_bridge",
    "Hand": "mechanisms.hand",
    "Held": "signals.held",
    "IdealSensor": "sensors.ideal",
    "IdentifiedHysteresis": "control.design.inverse_hysteresis",
    "InfraredSensor": "sensors.infrared",
    "InputError": "errors",
    "Integrating": "control.rules.formulas",
    "InverseModel": "observers.inverse",
    "InversePlay": "controllers.inverse_play",
    "Lagoudas": "laws.lagoudas",
    "Lanes": "simulate.lanes",
    "LatchedOnOff": "controllers.latched",
    "LeFevreEde": "thermal.lefevre_ede",
    "LearningTask": "export.learning_task:Task",
    "Leg": "simulate.point",
    "Lever": "mechanisms.lever",
    "LiangRogers": "laws.liang_rogers",
    "Limits": "elements.limits",
    "LinearAmplifier": "electrical.linear_amplifier",
    "LogDecrement": "characterise.free_vibration",
    "Loop": "simulate.closed_loop",
    "LoopRuns": "control.search.loop_runs",
    "LqrSizes": "control.design.lqr:Sizes",
    "Machine": "system.machine",
    "MartensiteError": "errors",
    "Material": "materials.base",
    "Mismatch": "bench.supervisors.checks.mismatch",
    "MixtureResistance": "electrical.mixture",
    "Morgan": "thermal.morgan",
    "Mosfet": "electrical.mosfet",
    "MotorConstants": "characterise.motor_constants",
    "Mounted": "bench.mounted",
    "Mpc": "controllers.mpc",
    "MujocoBridge": "export.mujoco_bridge",
    "MujocoResult": "export.mujoco_result",
    "MullerAchenbachSeelecke": "laws.mas",
    "MullerAchenbachSeeleckeHybrid": "laws.mas_hybrid",
    "MullerAchenbachSeeleckePolycrystal": "laws.mas_polycrystal",
    "NoCurrent": "bench.supervisors.checks.open_circuit",
    "Observers": "bench.parts",
    "Oil": "thermal.fluids.oil",
    "OnOff": "controllers.on_off",
    "OpenCircuit": "bench.faults.open_circuit",
    "OverCurrent": "bench.supervisors.checks.above",
    "OverForce": "bench.supervisors.checks.above",
    "OverStress": "bench.supervisors.checks.above",
    "Overheat": "bench.supervisors.checks.above",
    "ParallelPlatform": "mechanisms.parallel_platform",
    "ParetoFront": "sweep.pareto",
    "PerLengthResistance": "electrical.per_length",
    "Pid": "controllers.pid",
    "PidGains": "controllers.pid",
    "PidLaw": "controllers.pid",
    "PlanPrice": "controllers.planning:Price",
    "PlanSearch": "controllers.planning:Search",
    "Plants": "control.search.perturbed",
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
    "RealtimeStep": "bench.realtime",
    "Record": "signals.records",
    "Regulator": "control.design.lqr",
    "ResistanceSensor": "sensors.resistance",
    "Result": "simulate.result",
    "Ribbon": "elements.ribbon",
    "Rise": "characterise.time_constant",
    "Sampled": "signals.sampling.sampled",
    "Scenario": "io.scenario",
    "Schedule": "controllers.scheduled_pid",
    "ScheduledPid": "controllers.scheduled_pid",
    "Sensitivity": "simulate.batch",
    "SensitivityIndices": "sweep.indices:Sensitivity",
    "SensorLost": "bench.supervisors.checks.sensor_lost",
    "SensorStuck": "bench.supervisors.checks.sensor_stuck",
    "Sensors": "bench.parts",
    "Shaken": "observers.shaken",
    "Sine": "signals.sine",
    "SlidingMode": "controllers.sliding_mode",
    "SmaEnv": "export.gymnasium",
    "SmaVectorEnv": "export.gymnasium_vector",
    "SolveError": "errors",
    "SpectralPeak": "characterise.spectrum",
    "Speeds": "control.analysis.speed",
    "Stage": "identify.chains.stages",
    "Staircase": "signals.staircase",
    "StateFeedback": "controllers.state_feedback",
    "SteadyPoint": "control.design.operating_point:OperatingPoint",
    "Step": "signals.step",
    "StoppedError": "sweep.backends.base",
    "Stuck": "bench.faults.stuck",
    "SupplySag": "bench.faults.supply_sag",
    "SweepTable": "sweep.table",
    "System": "system.single",
    "Table": "signals.table",
    "Tanaka": "laws.tanaka",
    "TangentFit": "characterise.tangent_fit",
    "TangentPoints": "characterise.tangent_points",
    "TendonActuator": "export.mujoco_bridge",
    "TensileTestingMachine": "mechanisms.testing_machine",
    "ThermalBound": "bench.supervisors.checks.thermal_bound",
    "ThermocoupleSensor": "sensors.thermocouple",
    "TiltSensor": "sensors.tilt",
    "Triangle": "signals.triangle",
    "TunedBench": "control.search.bench_tuning",
    "Tuning": "control.tuning",
    "TuningGoal": "control.search.goals:Goal",
    "TuningSearch": "control.search.gain_search:Search",
    "TwoLevel": "controllers.two_level",
    "UnscentedKalman": "observers.unscented",
    "VoltageSensor": "sensors.voltage",
    "VoltageSource": "electrical.voltage",
    "Water": "thermal.fluids.water",
    "Wire": "elements.wire",
    "WireRequest": "sizing.request",
    "Wish": "identify.fitting.free",
    "Workspace": "mechanisms.shared.platform_workspace",
    "alarm_names": "bench.supervisors.checks.base",
    "beam_modes": "mechanisms.shared.beam_modes",
    "best_rules": "control.rules.rule_starts",
    "bridge_of": "export.mjcf",
    "c_core": "export.c_core",
    "c_loop": "export.c_loop",
    "checks_for": "bench.supervisors.from_sensors",
    "compare": "io.compare",
    "compare_averaging": "control.averaging",
    "consistency": "bench.consistency",
    "detrended": "signals.sampling.trends",
    "draw_plants": "control.search.perturbed",
    "energy_per_cycle": "control.analysis.energy",
    "estimate_model": "identify.chains.estimate:estimate",
    "fit": "io.fitting.api",
    "fit_film": "characterise.film_coefficient",
    "fit_rise": "characterise.time_constant",
    "frequency_response": "control.analysis.frequency",
    "gains_by_relay": "control.rules.relay",
    "gains_by_rule": "control.rules.formulas",
    "gains_by_tests": "control.rules.rule_starts",
    "guard_for": "bench.supervisors.from_plant",
    "holding_tensions": "export.mujoco_rest",
    "identify_hysteresis": "control.design.inverse_hysteresis",
    "identify_stages": "identify.chains.stages",
    "in_readings": "control.design.linear",
    "judge_film": "characterise.film_report",
    "linearise": "identify.chains.linearise",
    "linearised_plant": "control.design.linear:linearised",
    "load": "io.scenario",
    "load_material": "materials.base",
    "load_wires": "materials.wires",
    "log_decrement": "characterise.free_vibration",
    "loop_tests": "control.rules.rule_starts",
    "lqr": "control.design.lqr",
    "material_names": "materials.base",
    "material_point": "simulate.point",
    "mean_readings": "control.design.linear:mean_of",
    "measure": "simulate.measures.base",
    "modal_numbers": "mechanisms.beam_motor",
    "model_uncertainty": "identify.chains.uncertainty:uncertainty",
    "motor_constants": "characterise.motor_constants",
    "moving_average": "characterise.moving_average",
    "natural_frequency": "characterise.spectrum",
    "open_bench": "bench.run:opened",
    "open_result": "io.netcdf",
    "open_sweep": "io.sweeps.dataset",
    "optimise_design": "sizing.design.optimise",
    "over_plants": "control.search.over_plants",
    "pareto_front": "sweep.pareto",
    "parse_chain": "identify.chains.written",
    "per_sample": "controllers.pid",
    "pid_values": "control.rules.rule_starts",
    "plant_state_space": "export.control_systems",
    "plateaus": "io.staircase",
    "platform_angles": "mechanisms.shared.platform_kinematics",
    "platform_lengths": "mechanisms.shared.platform_kinematics",
    "plot_bench": "plot.bench",
    "plot_correlation": "plot.fit_knowledge",
    "plot_energy": "plot.energy",
    "plot_film": "plot.film_fit",
    "plot_fit": "plot.fit",
    "plot_fit_loops": "plot.fit",
    "plot_fit_residuals": "plot.fit_residuals",
    "plot_frequency_response": "plot.frequency",
    "plot_likelihood": "plot.fit_likelihood",
    "plot_model": "plot.model",
    "plot_model_loop": "plot.model",
    "plot_model_tests": "plot.model_tests",
    "plot_pareto": "plot.pareto",
    "plot_point": "plot.law_paths",
    "plot_profile": "plot.profile",
    "plot_search": "plot.fit_knowledge",
    "plot_sensitivity": "plot.sensitivity",
    "plot_singular_values": "plot.fit_knowledge",
    "plot_speeds": "plot.speeds",
    "plot_sweep": "plot.sweep",
    "plot_tangents": "plot.tangents",
    "plot_tuning": "plot.tuning",
    "plot_workspace": "plot.workspace",
    "points_from_power": "characterise.film_points",
    "problem": "identify.fitting.problem",
    "profiled": "identify.fitting.profiled",
    "reachable_angles": "mechanisms.shared.platform_workspace",
    "read_model": "io.model_files",
    "read_problem": "io.fitting.api",
    "read_sampled": "io.sampled_files",
    "read_silverbox": "io.public_benchmarks",
    "read_sweep": "io.sweeps.reading",
    "read_table": "io.tables",
    "read_wiener_hammerstein": "io.public_benchmarks",
    "relay_test": "control.rules.relay",
    "render_mujoco": "export.mujoco_render",
    "resampled": "signals.sampling.resampling",
    "save": "io.netcdf",
    "scan_designs": "sizing.design.scan:scan",
    "search_structures": "identify.chains.search:search",
    "sensitivity": "simulate.batch",
    "sensitivity_indices": "sweep.indices:sensitivity",
    "simulate": "simulate.api",
    "simulate_batch": "simulate.batch",
    "simulate_bench": "bench.run",
    "simulate_controlled": "simulate.controlled",
    "simulate_loop": "simulate.closed_loop",
    "size_wire": "sizing.candidates",
    "solve": "identify.fitting.solve",
    "speeds": "control.analysis.speed",
    "static_curve": "identify.chains.linearise",
    "steady_point": "control.design.operating_point:operating_point",
    "steady_point_at": "control.design.operating_point:operating_point_at",
    "steady_running": "characterise.motor_tests",
    "step_test": "control.rules.step_test",
    "sweep": "io.sweeps.api",
    "table_waveform": "signals.records",
    "tangent_fit": "characterise.tangent_fit",
    "tangent_points": "characterise.tangent_points",
    "tendon_signals": "export.mjcf",
    "to_control": "export.control_systems",
    "to_fmu": "export.fmu.archive",
    "to_mjcf": "export.mjcf",
    "to_mjcf_snippet": "export.mjcf_snippet",
    "to_nonlinear_system": "export.control_systems",
    "to_state_space": "export.control_systems",
    "tune": "control.tuning",
    "tune_bench": "control.search.bench_tuning",
    "unwrap_counter": "io.staircase",
    "validate_model": "identify.chains.validation:validate",
    "winding_resistance": "characterise.motor_tests",
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
