"""Model and simulate shape-memory-alloy actuators.

    import martensite as ms
    result = ms.load("finger.toml").run()

The names below are imported when they are first used, so that `import martensite` costs
nothing; their home modules (`martensite.physics.laws.liang_rogers`, …) may be imported just as
well.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

# A subpackage becomes an attribute on its first import and never again: bring that about here
# and free the name, so that `martensite.simulate` is the function whatever is imported later.
for _name in ("simulate", "fit", "design", "scenario"):
    import_module(f"martensite.{_name}")
    globals().pop(_name, None)

if TYPE_CHECKING:
    from martensite.actuators.assembly.actuator import Actuator as Actuator
    from martensite.actuators.assembly.actuator import Group as Group
    from martensite.actuators.assembly.machine import Machine as Machine
    from martensite.actuators.assembly.single import System as System
    from martensite.actuators.elements.axial_wire import AxialWire as AxialWire
    from martensite.actuators.elements.bundle import Bundle as Bundle
    from martensite.actuators.elements.chain import Chain as Chain
    from martensite.actuators.elements.coil_spring import CoilSpring as CoilSpring
    from martensite.actuators.elements.limits import Limits as Limits
    from martensite.actuators.elements.ribbon import Ribbon as Ribbon
    from martensite.actuators.elements.wire import Wire as Wire
    from martensite.actuators.mechanics.beam_modes import BeamModes as BeamModes
    from martensite.actuators.mechanics.beam_modes import CantileverBeam as CantileverBeam
    from martensite.actuators.mechanics.beam_modes import beam_modes as beam_modes
    from martensite.actuators.mechanics.platform_kinematics import Plates as Plates
    from martensite.actuators.mechanics.platform_kinematics import (
        platform_angles as platform_angles,
    )
    from martensite.actuators.mechanics.platform_kinematics import (
        platform_lengths as platform_lengths,
    )
    from martensite.actuators.mechanics.platform_workspace import Workspace as Workspace
    from martensite.actuators.mechanics.platform_workspace import (
        reachable_angles as reachable_angles,
    )
    from martensite.actuators.mechanisms.beam_motor import BeamMotor as BeamMotor
    from martensite.actuators.mechanisms.beam_motor import modal_numbers as modal_numbers
    from martensite.actuators.mechanisms.bias_spring import BiasSpring as BiasSpring
    from martensite.actuators.mechanisms.dead_weight import DeadWeight as DeadWeight
    from martensite.actuators.mechanisms.finger import Finger as Finger
    from martensite.actuators.mechanisms.hand import Hand as Hand
    from martensite.actuators.mechanisms.lever import Lever as Lever
    from martensite.actuators.mechanisms.parallel_platform import (
        ParallelPlatform as ParallelPlatform,
    )
    from martensite.actuators.mechanisms.pulley import AntagonisticPulley as AntagonisticPulley
    from martensite.actuators.mechanisms.testing_machine import (
        TensileTestingMachine as TensileTestingMachine,
    )
    from martensite.base.errors import InputError as InputError
    from martensite.base.errors import MartensiteError as MartensiteError
    from martensite.base.errors import SolveError as SolveError
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
    from martensite.control.checks.above import OverCurrent as OverCurrent
    from martensite.control.checks.above import OverForce as OverForce
    from martensite.control.checks.above import Overheat as Overheat
    from martensite.control.checks.above import OverStress as OverStress
    from martensite.control.checks.base import Checks as Checks
    from martensite.control.checks.base import alarm_names as alarm_names
    from martensite.control.checks.mismatch import Mismatch as Mismatch
    from martensite.control.checks.open_circuit import NoCurrent as NoCurrent
    from martensite.control.checks.sensor_lost import SensorLost as SensorLost
    from martensite.control.checks.sensor_stuck import SensorStuck as SensorStuck
    from martensite.control.checks.thermal_bound import ThermalBound as ThermalBound
    from martensite.control.controllers.cascade import Cascade as Cascade
    from martensite.control.controllers.constant_power import ConstantPower as ConstantPower
    from martensite.control.controllers.correction import Correction as Correction
    from martensite.control.controllers.direct import Direct as Direct
    from martensite.control.controllers.feedforward import Feedforward as Feedforward
    from martensite.control.controllers.inverse_play import InversePlay as InversePlay
    from martensite.control.controllers.latched import LatchedOnOff as LatchedOnOff
    from martensite.control.controllers.mpc import Mpc as Mpc
    from martensite.control.controllers.on_off import OnOff as OnOff
    from martensite.control.controllers.pid import Gains as Gains
    from martensite.control.controllers.pid import Pid as Pid
    from martensite.control.controllers.pid import PidGains as PidGains
    from martensite.control.controllers.pid import PidLaw as PidLaw
    from martensite.control.controllers.pid import per_sample as per_sample
    from martensite.control.controllers.planning import Price as _PlanPrice
    from martensite.control.controllers.planning import Search as _PlanSearch
    from martensite.control.controllers.scheduled_pid import GainsAt as GainsAt
    from martensite.control.controllers.scheduled_pid import Schedule as Schedule
    from martensite.control.controllers.scheduled_pid import ScheduledPid as ScheduledPid
    from martensite.control.controllers.sliding_mode import SlidingMode as SlidingMode
    from martensite.control.controllers.state_feedback import StateFeedback as StateFeedback
    from martensite.control.controllers.two_level import TwoLevel as TwoLevel
    from martensite.control.faults.ambient_step import AmbientStep as AmbientStep
    from martensite.control.faults.draught import Draught as Draught
    from martensite.control.faults.drift import Drift as Drift
    from martensite.control.faults.drop_out import DropOut as DropOut
    from martensite.control.faults.open_circuit import OpenCircuit as OpenCircuit
    from martensite.control.faults.stuck import Stuck as Stuck
    from martensite.control.faults.supply_sag import SupplySag as SupplySag
    from martensite.control.loop.bench import Bench as Bench
    from martensite.control.loop.consistency import Consistency as Consistency
    from martensite.control.loop.consistency import consistency as consistency
    from martensite.control.loop.mounted import Mounted as Mounted
    from martensite.control.loop.parts import Controllers as Controllers
    from martensite.control.loop.parts import Faults as Faults
    from martensite.control.loop.parts import Observers as Observers
    from martensite.control.loop.parts import Sensors as Sensors
    from martensite.control.loop.realtime import RealtimeStep as RealtimeStep
    from martensite.control.loop.run import opened as _open_bench
    from martensite.control.loop.run import simulate_bench as simulate_bench
    from martensite.control.observers.extended import ExtendedKalman as ExtendedKalman
    from martensite.control.observers.inverse import InverseModel as InverseModel
    from martensite.control.observers.shaken import Shaken as Shaken
    from martensite.control.observers.unscented import UnscentedKalman as UnscentedKalman
    from martensite.control.sensors.current import CurrentSensor as CurrentSensor
    from martensite.control.sensors.encoder import EncoderSensor as EncoderSensor
    from martensite.control.sensors.force import ForceSensor as ForceSensor
    from martensite.control.sensors.gyroscope import GyroscopeSensor as GyroscopeSensor
    from martensite.control.sensors.ideal import IdealSensor as IdealSensor
    from martensite.control.sensors.infrared import InfraredSensor as InfraredSensor
    from martensite.control.sensors.position import PositionSensor as PositionSensor
    from martensite.control.sensors.resistance import ResistanceSensor as ResistanceSensor
    from martensite.control.sensors.thermocouple import ThermocoupleSensor as ThermocoupleSensor
    from martensite.control.sensors.tilt import TiltSensor as TiltSensor
    from martensite.control.sensors.voltage import VoltageSensor as VoltageSensor
    from martensite.control.supervisors.from_plant import guard_for as guard_for
    from martensite.control.supervisors.from_sensors import checks_for as checks_for
    from martensite.control.supervisors.guard import Guard as Guard
    from martensite.design.analysis.energy import CycleEnergies as CycleEnergies
    from martensite.design.analysis.energy import energy_per_cycle as energy_per_cycle
    from martensite.design.analysis.frequency import FrequencyResponse as FrequencyResponse
    from martensite.design.analysis.frequency import frequency_response as frequency_response
    from martensite.design.analysis.speed import Speeds as Speeds
    from martensite.design.analysis.speed import speeds as speeds
    from martensite.design.backends.base import StoppedError as StoppedError
    from martensite.design.optimise.designed import Designed as Designed
    from martensite.design.optimise.optimise import optimise_design as optimise_design
    from martensite.design.optimise.scan import scan as _scan_designs
    from martensite.design.optimise.search import Search as _DesignSearch
    from martensite.design.rules.formulas import FirstOrder as FirstOrder
    from martensite.design.rules.formulas import Integrating as Integrating
    from martensite.design.rules.formulas import gains_by_rule as gains_by_rule
    from martensite.design.rules.relay import gains_by_relay as gains_by_relay
    from martensite.design.rules.relay import relay_test as relay_test
    from martensite.design.rules.rule_starts import best_rules as best_rules
    from martensite.design.rules.rule_starts import gains_by_tests as gains_by_tests
    from martensite.design.rules.rule_starts import loop_tests as loop_tests
    from martensite.design.rules.rule_starts import pid_values as pid_values
    from martensite.design.rules.step_test import step_test as step_test
    from martensite.design.sizing.candidates import size_wire as size_wire
    from martensite.design.sizing.request import WireRequest as WireRequest
    from martensite.design.sweep.api import sweep as sweep
    from martensite.design.sweep.dataset import open_sweep as open_sweep
    from martensite.design.sweep.indices import Sensitivity as _SensitivityIndices
    from martensite.design.sweep.indices import sensitivity as _sensitivity_indices
    from martensite.design.sweep.pareto import ParetoFront as ParetoFront
    from martensite.design.sweep.pareto import pareto_front as pareto_front
    from martensite.design.sweep.reading import read_sweep as read_sweep
    from martensite.design.sweep.table import SweepTable as SweepTable
    from martensite.design.synthesis.inverse_hysteresis import (
        IdentifiedHysteresis as IdentifiedHysteresis,
    )
    from martensite.design.synthesis.inverse_hysteresis import (
        identify_hysteresis as identify_hysteresis,
    )
    from martensite.design.synthesis.linear import in_readings as in_readings
    from martensite.design.synthesis.linear import linearised as _linearised_plant
    from martensite.design.synthesis.linear import mean_of as _mean_readings
    from martensite.design.synthesis.lqr import Regulator as Regulator
    from martensite.design.synthesis.lqr import Sizes as _LqrSizes
    from martensite.design.synthesis.lqr import lqr as lqr
    from martensite.design.synthesis.operating_point import OperatingPoint as _SteadyPoint
    from martensite.design.synthesis.operating_point import operating_point as _steady_point
    from martensite.design.synthesis.operating_point import operating_point_at as _steady_point_at
    from martensite.design.tuning.averaging import Averaging as Averaging
    from martensite.design.tuning.averaging import compare_averaging as compare_averaging
    from martensite.design.tuning.bench_tuning import TunedBench as TunedBench
    from martensite.design.tuning.bench_tuning import tune_bench as tune_bench
    from martensite.design.tuning.closed_loop import ControlledModel as ControlledModel
    from martensite.design.tuning.gain_search import Search as _TuningSearch
    from martensite.design.tuning.goals import Goal as _TuningGoal
    from martensite.design.tuning.loop_runs import LoopRuns as LoopRuns
    from martensite.design.tuning.over_plants import over_plants as over_plants
    from martensite.design.tuning.perturbed import Plants as Plants
    from martensite.design.tuning.perturbed import draw_plants as draw_plants
    from martensite.design.tuning.tuning import Tuning as Tuning
    from martensite.design.tuning.tuning import tune as tune
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
    from martensite.fit.api import fit as fit
    from martensite.fit.api import read_problem as read_problem
    from martensite.fit.experiment import Experiment as Experiment
    from martensite.fit.fit import Fit as Fit
    from martensite.fit.free import Wish as Wish
    from martensite.fit.material_files import write_material as write_material
    from martensite.fit.problem import Problem as Problem
    from martensite.fit.problem import problem as problem
    from martensite.fit.profiled import profiled as profiled
    from martensite.fit.solve import solve as solve
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
    from martensite.identify.operators.play import PlaySum as PlaySum
    from martensite.physics.electrical.current import CurrentSource as CurrentSource
    from martensite.physics.electrical.furst_seelecke import (
        FurstSeeleckeResistance as FurstSeeleckeResistance,
    )
    from martensite.physics.electrical.h_bridge import HBridge as HBridge
    from martensite.physics.electrical.linear_amplifier import LinearAmplifier as LinearAmplifier
    from martensite.physics.electrical.mixture import MixtureResistance as MixtureResistance
    from martensite.physics.electrical.mosfet import Mosfet as Mosfet
    from martensite.physics.electrical.per_length import PerLengthResistance as PerLengthResistance
    from martensite.physics.electrical.power import PowerSource as PowerSource
    from martensite.physics.electrical.power_pwm import PowerPwm as PowerPwm
    from martensite.physics.electrical.pwm import PwmVoltage as PwmVoltage
    from martensite.physics.electrical.temperature import (
        PrescribedTemperature as PrescribedTemperature,
    )
    from martensite.physics.electrical.voltage import VoltageSource as VoltageSource
    from martensite.physics.fluids.air import Air as Air
    from martensite.physics.fluids.air_table import AirTable as AirTable
    from martensite.physics.fluids.oil import Oil as Oil
    from martensite.physics.fluids.water import Water as Water
    from martensite.physics.laws.brinson import Brinson as Brinson
    from martensite.physics.laws.elahinia import Elahinia as Elahinia
    from martensite.physics.laws.lagoudas import Lagoudas as Lagoudas
    from martensite.physics.laws.liang_rogers import LiangRogers as LiangRogers
    from martensite.physics.laws.mas import MullerAchenbachSeelecke as MullerAchenbachSeelecke
    from martensite.physics.laws.mas_hybrid import (
        MullerAchenbachSeeleckeHybrid as MullerAchenbachSeeleckeHybrid,
    )
    from martensite.physics.laws.mas_polycrystal import (
        MullerAchenbachSeeleckePolycrystal as MullerAchenbachSeeleckePolycrystal,
    )
    from martensite.physics.laws.tanaka import Tanaka as Tanaka
    from martensite.physics.materials.base import Material as Material
    from martensite.physics.materials.base import load_material as load_material
    from martensite.physics.materials.base import material_names as material_names
    from martensite.physics.materials.wires import load_wires as load_wires
    from martensite.physics.thermal.base import Environment as Environment
    from martensite.physics.thermal.churchill_bernstein import (
        ChurchillBernstein as ChurchillBernstein,
    )
    from martensite.physics.thermal.churchill_chu import ChurchillChu as ChurchillChu
    from martensite.physics.thermal.combined import CombinedCooling as CombinedCooling
    from martensite.physics.thermal.constant import ConstantCooling as ConstantCooling
    from martensite.physics.thermal.ends import AdiabaticEnds as AdiabaticEnds
    from martensite.physics.thermal.ends import ClampedEnds as ClampedEnds
    from martensite.physics.thermal.lefevre_ede import LeFevreEde as LeFevreEde
    from martensite.physics.thermal.morgan import Morgan as Morgan
    from martensite.physics.thermal.polynomial import PolynomialCooling as PolynomialCooling
    from martensite.physics.thermal.radiation import Radiation as Radiation
    from martensite.scenario.compare import compare as compare
    from martensite.scenario.model_files import read_model as read_model
    from martensite.scenario.model_files import write_model as write_model
    from martensite.scenario.netcdf import open_result as open_result
    from martensite.scenario.netcdf import save as save
    from martensite.scenario.public_benchmarks import read_silverbox as read_silverbox
    from martensite.scenario.public_benchmarks import (
        read_wiener_hammerstein as read_wiener_hammerstein,
    )
    from martensite.scenario.sampled_files import read_sampled as read_sampled
    from martensite.scenario.sampled_files import write_sampled as write_sampled
    from martensite.scenario.scenario import Scenario as Scenario
    from martensite.scenario.scenario import load as load
    from martensite.scenario.staircase import plateaus as plateaus
    from martensite.scenario.staircase import unwrap_counter as unwrap_counter
    from martensite.scenario.tables import read_table as read_table
    from martensite.show.figures.bench import plot_bench as plot_bench
    from martensite.show.figures.energy import plot_energy as plot_energy
    from martensite.show.figures.film_fit import plot_film as plot_film
    from martensite.show.figures.fit import plot_fit as plot_fit
    from martensite.show.figures.fit import plot_fit_loops as plot_fit_loops
    from martensite.show.figures.fit_knowledge import plot_correlation as plot_correlation
    from martensite.show.figures.fit_knowledge import plot_search as plot_search
    from martensite.show.figures.fit_knowledge import plot_singular_values as plot_singular_values
    from martensite.show.figures.fit_likelihood import plot_likelihood as plot_likelihood
    from martensite.show.figures.fit_residuals import plot_fit_residuals as plot_fit_residuals
    from martensite.show.figures.frequency import plot_frequency_response as plot_frequency_response
    from martensite.show.figures.law_paths import plot_point as plot_point
    from martensite.show.figures.model import plot_model as plot_model
    from martensite.show.figures.model import plot_model_loop as plot_model_loop
    from martensite.show.figures.model_tests import plot_model_tests as plot_model_tests
    from martensite.show.figures.pareto import plot_pareto as plot_pareto
    from martensite.show.figures.profile import plot_profile as plot_profile
    from martensite.show.figures.sensitivity import plot_sensitivity as plot_sensitivity
    from martensite.show.figures.speeds import plot_speeds as plot_speeds
    from martensite.show.figures.sweep import plot_sweep as plot_sweep
    from martensite.show.figures.tangents import plot_tangents as plot_tangents
    from martensite.show.figures.tuning import plot_tuning as plot_tuning
    from martensite.show.figures.workspace import plot_workspace as plot_workspace
    from martensite.show.reports.fit_report import write_report as write_report
    from martensite.show.reports.model_report import write_model_report as write_model_report
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
    "Actuator": "actuators.assembly.actuator",
    "AdiabaticEnds": "physics.thermal.ends",
    "Air": "physics.fluids.air",
    "AirTable": "physics.fluids.air_table",
    "Alarm": "simulate.alarms",
    "AmbientStep": "control.faults.ambient_step",
    "AntagonisticPulley": "actuators.mechanisms.pulley",
    "Averaging": "design.tuning.averaging",
    "AxialWire": "actuators.elements.axial_wire",
    "Batch": "simulate.batch",
    "BeamModes": "actuators.mechanics.beam_modes",
    "BeamMotor": "actuators.mechanisms.beam_motor",
    "Bench": "control.loop.bench",
    "BiasSpring": "actuators.mechanisms.bias_spring",
    "BlockChain": "identify.chains.chain:Chain",
    "Brinson": "physics.laws.brinson",
    "Bundle": "actuators.elements.bundle",
    "CCore": "export.c_core",
    "CantileverBeam": "actuators.mechanics.beam_modes",
    "Carrier": "signals.carrier",
    "Cascade": "control.controllers.cascade",
    "Chain": "actuators.elements.chain",
    "Checks": "control.checks.base",
    "ChurchillBernstein": "physics.thermal.churchill_bernstein",
    "ChurchillChu": "physics.thermal.churchill_chu",
    "ClampedEnds": "physics.thermal.ends",
    "CoilSpring": "actuators.elements.coil_spring",
    "CombinedCooling": "physics.thermal.combined",
    "Consistency": "control.loop.consistency",
    "Constant": "signals.constant",
    "ConstantCooling": "physics.thermal.constant",
    "ConstantPower": "control.controllers.constant_power",
    "ControlledModel": "design.tuning.closed_loop",
    "Controllers": "control.loop.parts",
    "Correction": "control.controllers.correction",
    "CurrentSensor": "control.sensors.current",
    "CurrentSource": "physics.electrical.current",
    "CycleEnergies": "design.analysis.energy",
    "DeadWeight": "actuators.mechanisms.dead_weight",
    "DesignSearch": "design.optimise.search:Search",
    "Designed": "design.optimise.designed",
    "Direct": "control.controllers.direct",
    "Draught": "control.faults.draught",
    "Drift": "control.faults.drift",
    "DropOut": "control.faults.drop_out",
    "Elahinia": "physics.laws.elahinia",
    "EncoderSensor": "control.sensors.encoder",
    "Environment": "physics.thermal.base",
    "Estimate": "characterise.estimate",
    "EstimateOptions": "identify.chains.options:Options",
    "Experiment": "fit.experiment",
    "ExtendedKalman": "control.observers.extended",
    "Faults": "control.loop.parts",
    "Feedforward": "control.controllers.feedforward",
    "FilmFit": "characterise.film_coefficient",
    "FilmPoints": "characterise.film_points",
    "FilmReport": "characterise.film_report",
    "Finger": "actuators.mechanisms.finger",
    "FirstOrder": "design.rules.formulas",
    "Fit": "fit.fit",
    "Fmu": "export.fmu.archive",
    "ForceSensor": "control.sensors.force",
    "FrequencyResponse": "design.analysis.frequency",
    "FurstSeeleckeResistance": "physics.electrical.furst_seelecke",
    "Gains": "control.controllers.pid",
    "GainsAt": "control.controllers.scheduled_pid",
    "Group": "actuators.assembly.actuator",
    "Guard": "control.supervisors.guard",
    "GyroscopeSensor": "control.sensors.gyroscope",
    "HBridge": "physics.electrical.h_bridge",
    "Hand": "actuators.mechanisms.hand",
    "Held": "signals.held",
    "IdealSensor": "control.sensors.ideal",
    "IdentifiedHysteresis": "design.synthesis.inverse_hysteresis",
    "InfraredSensor": "control.sensors.infrared",
    "InputError": "base.errors",
    "Integrating": "design.rules.formulas",
    "InverseModel": "control.observers.inverse",
    "InversePlay": "control.controllers.inverse_play",
    "Lagoudas": "physics.laws.lagoudas",
    "Lanes": "simulate.lanes",
    "LatchedOnOff": "control.controllers.latched",
    "LeFevreEde": "physics.thermal.lefevre_ede",
    "LearningTask": "export.learning_task:Task",
    "Leg": "simulate.point",
    "Lever": "actuators.mechanisms.lever",
    "LiangRogers": "physics.laws.liang_rogers",
    "Limits": "actuators.elements.limits",
    "LinearAmplifier": "physics.electrical.linear_amplifier",
    "LogDecrement": "characterise.free_vibration",
    "Loop": "simulate.closed_loop",
    "LoopRuns": "design.tuning.loop_runs",
    "LqrSizes": "design.synthesis.lqr:Sizes",
    "Machine": "actuators.assembly.machine",
    "MartensiteError": "base.errors",
    "Material": "physics.materials.base",
    "Mismatch": "control.checks.mismatch",
    "MixtureResistance": "physics.electrical.mixture",
    "Morgan": "physics.thermal.morgan",
    "Mosfet": "physics.electrical.mosfet",
    "MotorConstants": "characterise.motor_constants",
    "Mounted": "control.loop.mounted",
    "Mpc": "control.controllers.mpc",
    "MujocoBridge": "export.mujoco_bridge",
    "MujocoResult": "export.mujoco_result",
    "MullerAchenbachSeelecke": "physics.laws.mas",
    "MullerAchenbachSeeleckeHybrid": "physics.laws.mas_hybrid",
    "MullerAchenbachSeeleckePolycrystal": "physics.laws.mas_polycrystal",
    "NoCurrent": "control.checks.open_circuit",
    "Observers": "control.loop.parts",
    "Oil": "physics.fluids.oil",
    "OnOff": "control.controllers.on_off",
    "OpenCircuit": "control.faults.open_circuit",
    "OverCurrent": "control.checks.above",
    "OverForce": "control.checks.above",
    "OverStress": "control.checks.above",
    "Overheat": "control.checks.above",
    "ParallelPlatform": "actuators.mechanisms.parallel_platform",
    "ParetoFront": "design.sweep.pareto",
    "PerLengthResistance": "physics.electrical.per_length",
    "Pid": "control.controllers.pid",
    "PidGains": "control.controllers.pid",
    "PidLaw": "control.controllers.pid",
    "PlanPrice": "control.controllers.planning:Price",
    "PlanSearch": "control.controllers.planning:Search",
    "Plants": "design.tuning.perturbed",
    "Plates": "actuators.mechanics.platform_kinematics",
    "PlaySum": "identify.operators.play",
    "PointResult": "simulate.point",
    "PolynomialCooling": "physics.thermal.polynomial",
    "PositionSensor": "control.sensors.position",
    "PowerPwm": "physics.electrical.power_pwm",
    "PowerSource": "physics.electrical.power",
    "PrescribedTemperature": "physics.electrical.temperature",
    "Problem": "fit.problem",
    "PulseWidthModulation": "signals.pwm",
    "PwmVoltage": "physics.electrical.pwm",
    "Radiation": "physics.thermal.radiation",
    "Ramp": "signals.ramp",
    "RealtimeStep": "control.loop.realtime",
    "Record": "signals.records",
    "Regulator": "design.synthesis.lqr",
    "ResistanceSensor": "control.sensors.resistance",
    "Result": "simulate.result",
    "Ribbon": "actuators.elements.ribbon",
    "Rise": "characterise.time_constant",
    "Sampled": "signals.sampling.sampled",
    "Scenario": "scenario.scenario",
    "Schedule": "control.controllers.scheduled_pid",
    "ScheduledPid": "control.controllers.scheduled_pid",
    "Sensitivity": "simulate.batch",
    "SensitivityIndices": "design.sweep.indices:Sensitivity",
    "SensorLost": "control.checks.sensor_lost",
    "SensorStuck": "control.checks.sensor_stuck",
    "Sensors": "control.loop.parts",
    "Shaken": "control.observers.shaken",
    "Sine": "signals.sine",
    "SlidingMode": "control.controllers.sliding_mode",
    "SmaEnv": "export.gymnasium",
    "SmaVectorEnv": "export.gymnasium_vector",
    "SolveError": "base.errors",
    "SpectralPeak": "characterise.spectrum",
    "Speeds": "design.analysis.speed",
    "Stage": "identify.chains.stages",
    "Staircase": "signals.staircase",
    "StateFeedback": "control.controllers.state_feedback",
    "SteadyPoint": "design.synthesis.operating_point:OperatingPoint",
    "Step": "signals.step",
    "StoppedError": "design.backends.base",
    "Stuck": "control.faults.stuck",
    "SupplySag": "control.faults.supply_sag",
    "SweepTable": "design.sweep.table",
    "System": "actuators.assembly.single",
    "Table": "signals.table",
    "Tanaka": "physics.laws.tanaka",
    "TangentFit": "characterise.tangent_fit",
    "TangentPoints": "characterise.tangent_points",
    "TendonActuator": "export.mujoco_bridge",
    "TensileTestingMachine": "actuators.mechanisms.testing_machine",
    "ThermalBound": "control.checks.thermal_bound",
    "ThermocoupleSensor": "control.sensors.thermocouple",
    "TiltSensor": "control.sensors.tilt",
    "Triangle": "signals.triangle",
    "TunedBench": "design.tuning.bench_tuning",
    "Tuning": "design.tuning.tuning",
    "TuningGoal": "design.tuning.goals:Goal",
    "TuningSearch": "design.tuning.gain_search:Search",
    "TwoLevel": "control.controllers.two_level",
    "UnscentedKalman": "control.observers.unscented",
    "VoltageSensor": "control.sensors.voltage",
    "VoltageSource": "physics.electrical.voltage",
    "Water": "physics.fluids.water",
    "Wire": "actuators.elements.wire",
    "WireRequest": "design.sizing.request",
    "Wish": "fit.free",
    "Workspace": "actuators.mechanics.platform_workspace",
    "alarm_names": "control.checks.base",
    "beam_modes": "actuators.mechanics.beam_modes",
    "best_rules": "design.rules.rule_starts",
    "bridge_of": "export.mjcf",
    "c_core": "export.c_core",
    "c_loop": "export.c_loop",
    "checks_for": "control.supervisors.from_sensors",
    "compare": "scenario.compare",
    "compare_averaging": "design.tuning.averaging",
    "consistency": "control.loop.consistency",
    "detrended": "signals.sampling.trends",
    "draw_plants": "design.tuning.perturbed",
    "energy_per_cycle": "design.analysis.energy",
    "estimate_model": "identify.chains.estimate:estimate",
    "fit": "fit.api",
    "fit_film": "characterise.film_coefficient",
    "fit_rise": "characterise.time_constant",
    "frequency_response": "design.analysis.frequency",
    "gains_by_relay": "design.rules.relay",
    "gains_by_rule": "design.rules.formulas",
    "gains_by_tests": "design.rules.rule_starts",
    "guard_for": "control.supervisors.from_plant",
    "holding_tensions": "export.mujoco_rest",
    "identify_hysteresis": "design.synthesis.inverse_hysteresis",
    "identify_stages": "identify.chains.stages",
    "in_readings": "design.synthesis.linear",
    "judge_film": "characterise.film_report",
    "linearise": "identify.chains.linearise",
    "linearised_plant": "design.synthesis.linear:linearised",
    "load": "scenario.scenario",
    "load_material": "physics.materials.base",
    "load_wires": "physics.materials.wires",
    "log_decrement": "characterise.free_vibration",
    "loop_tests": "design.rules.rule_starts",
    "lqr": "design.synthesis.lqr",
    "material_names": "physics.materials.base",
    "material_point": "simulate.point",
    "mean_readings": "design.synthesis.linear:mean_of",
    "measure": "simulate.measures.base",
    "modal_numbers": "actuators.mechanisms.beam_motor",
    "model_uncertainty": "identify.chains.uncertainty:uncertainty",
    "motor_constants": "characterise.motor_constants",
    "moving_average": "characterise.moving_average",
    "natural_frequency": "characterise.spectrum",
    "open_bench": "control.loop.run:opened",
    "open_result": "scenario.netcdf",
    "open_sweep": "design.sweep.dataset",
    "optimise_design": "design.optimise.optimise",
    "over_plants": "design.tuning.over_plants",
    "pareto_front": "design.sweep.pareto",
    "parse_chain": "identify.chains.written",
    "per_sample": "control.controllers.pid",
    "pid_values": "design.rules.rule_starts",
    "plant_state_space": "export.control_systems",
    "plateaus": "scenario.staircase",
    "platform_angles": "actuators.mechanics.platform_kinematics",
    "platform_lengths": "actuators.mechanics.platform_kinematics",
    "plot_bench": "show.figures.bench",
    "plot_correlation": "show.figures.fit_knowledge",
    "plot_energy": "show.figures.energy",
    "plot_film": "show.figures.film_fit",
    "plot_fit": "show.figures.fit",
    "plot_fit_loops": "show.figures.fit",
    "plot_fit_residuals": "show.figures.fit_residuals",
    "plot_frequency_response": "show.figures.frequency",
    "plot_likelihood": "show.figures.fit_likelihood",
    "plot_model": "show.figures.model",
    "plot_model_loop": "show.figures.model",
    "plot_model_tests": "show.figures.model_tests",
    "plot_pareto": "show.figures.pareto",
    "plot_point": "show.figures.law_paths",
    "plot_profile": "show.figures.profile",
    "plot_search": "show.figures.fit_knowledge",
    "plot_sensitivity": "show.figures.sensitivity",
    "plot_singular_values": "show.figures.fit_knowledge",
    "plot_speeds": "show.figures.speeds",
    "plot_sweep": "show.figures.sweep",
    "plot_tangents": "show.figures.tangents",
    "plot_tuning": "show.figures.tuning",
    "plot_workspace": "show.figures.workspace",
    "points_from_power": "characterise.film_points",
    "problem": "fit.problem",
    "profiled": "fit.profiled",
    "reachable_angles": "actuators.mechanics.platform_workspace",
    "read_model": "scenario.model_files",
    "read_problem": "fit.api",
    "read_sampled": "scenario.sampled_files",
    "read_silverbox": "scenario.public_benchmarks",
    "read_sweep": "design.sweep.reading",
    "read_table": "scenario.tables",
    "read_wiener_hammerstein": "scenario.public_benchmarks",
    "relay_test": "design.rules.relay",
    "render_mujoco": "export.mujoco_render",
    "resampled": "signals.sampling.resampling",
    "save": "scenario.netcdf",
    "scan_designs": "design.optimise.scan:scan",
    "search_structures": "identify.chains.search:search",
    "sensitivity": "simulate.batch",
    "sensitivity_indices": "design.sweep.indices:sensitivity",
    "simulate": "simulate.api",
    "simulate_batch": "simulate.batch",
    "simulate_bench": "control.loop.run",
    "simulate_controlled": "simulate.controlled",
    "simulate_loop": "simulate.closed_loop",
    "size_wire": "design.sizing.candidates",
    "solve": "fit.solve",
    "speeds": "design.analysis.speed",
    "static_curve": "identify.chains.linearise",
    "steady_point": "design.synthesis.operating_point:operating_point",
    "steady_point_at": "design.synthesis.operating_point:operating_point_at",
    "steady_running": "characterise.motor_tests",
    "step_test": "design.rules.step_test",
    "sweep": "design.sweep.api",
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
    "tune": "design.tuning.tuning",
    "tune_bench": "design.tuning.bench_tuning",
    "unwrap_counter": "scenario.staircase",
    "validate_model": "identify.chains.validation:validate",
    "winding_resistance": "characterise.motor_tests",
    "write_material": "fit.material_files",
    "write_model": "scenario.model_files",
    "write_model_report": "show.reports.model_report",
    "write_report": "show.reports.fit_report",
    "write_sampled": "scenario.sampled_files",
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
