from martensite.design.analysis.energy import CycleEnergies as CycleEnergies
from martensite.design.analysis.energy import compute_cycle_energies as compute_cycle_energies
from martensite.design.analysis.frequency import FrequencyResponse as FrequencyResponse
from martensite.design.analysis.frequency import (
    measure_frequency_response as measure_frequency_response,
)
from martensite.design.analysis.speed import Speeds as Speeds
from martensite.design.analysis.speed import compute_speeds as compute_speeds
from martensite.design.backends.base import StoppedError as StoppedError
from martensite.design.optimise.grid_scan import scan_designs as scan_designs
from martensite.design.optimise.optimise import optimise_design as optimise_design
from martensite.design.optimise.optimised_design import OptimisedDesign as OptimisedDesign
from martensite.design.optimise.search import DesignSearch as DesignSearch
from martensite.design.rules.formulas import RULES as RULES
from martensite.design.rules.formulas import FirstOrder as FirstOrder
from martensite.design.rules.formulas import Integrating as Integrating
from martensite.design.rules.formulas import gains_by_rule as gains_by_rule
from martensite.design.rules.relay import gains_by_relay as gains_by_relay
from martensite.design.rules.relay import run_relay_test as run_relay_test
from martensite.design.rules.rule_starts import choose_best_rules as choose_best_rules
from martensite.design.rules.rule_starts import convert_to_pid as convert_to_pid
from martensite.design.rules.rule_starts import gains_by_tests as gains_by_tests
from martensite.design.rules.rule_starts import run_loop_tests as run_loop_tests
from martensite.design.rules.step_test import run_step_test as run_step_test
from martensite.design.sizing.candidates import size_wire as size_wire
from martensite.design.sizing.request import WireRequest as WireRequest
from martensite.design.sweep.api import run_sweep as run_sweep
from martensite.design.sweep.dataset import open_sweep as open_sweep
from martensite.design.sweep.indices import SensitivityIndices as SensitivityIndices
from martensite.design.sweep.indices import compute_sensitivity as compute_sensitivity
from martensite.design.sweep.pareto import ParetoFront as ParetoFront
from martensite.design.sweep.pareto import find_pareto_front as find_pareto_front
from martensite.design.sweep.reading import read_sweep as read_sweep
from martensite.design.sweep.table import SweepTable as SweepTable
from martensite.design.synthesis.inverse_hysteresis import (
    IdentifiedHysteresis as IdentifiedHysteresis,
)
from martensite.design.synthesis.inverse_hysteresis import fit_rising_curve as fit_rising_curve
from martensite.design.synthesis.inverse_hysteresis import (
    identify_hysteresis as identify_hysteresis,
)
from martensite.design.synthesis.linear import average_plants as average_plants
from martensite.design.synthesis.linear import linearise_plant as linearise_plant
from martensite.design.synthesis.linear import realise_readings as realise_readings
from martensite.design.synthesis.lqr import LqrSizes as LqrSizes
from martensite.design.synthesis.lqr import Regulator as Regulator
from martensite.design.synthesis.lqr import design_regulator as design_regulator
from martensite.design.synthesis.operating_point import SteadyPoint as SteadyPoint
from martensite.design.synthesis.operating_point import find_operating_level as find_operating_level
from martensite.design.synthesis.operating_point import find_operating_point as find_operating_point
from martensite.design.tuning.averaging import Averaging as Averaging
from martensite.design.tuning.averaging import compare_averaging as compare_averaging
from martensite.design.tuning.bench_tuning import TunedBench as TunedBench
from martensite.design.tuning.bench_tuning import tune_bench as tune_bench
from martensite.design.tuning.closed_loop import ControlledModel as ControlledModel
from martensite.design.tuning.gain_search import TuningSearch as TuningSearch
from martensite.design.tuning.goals import TuningGoal as TuningGoal
from martensite.design.tuning.loop_runs import LoopRuns as LoopRuns
from martensite.design.tuning.plant_comparison import compare_over_plants as compare_over_plants
from martensite.design.tuning.plant_spread import Plants as Plants
from martensite.design.tuning.plant_spread import draw_plants as draw_plants
from martensite.design.tuning.response import build_steps as build_steps
from martensite.design.tuning.tuning import CostScale as CostScale
from martensite.design.tuning.tuning import ModelTuning as ModelTuning
from martensite.design.tuning.tuning import tune_model as tune_model
