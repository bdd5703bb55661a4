from martensite.design.analysis.energy import CycleEnergies as CycleEnergies
from martensite.design.analysis.energy import energy_per_cycle as energy_per_cycle
from martensite.design.analysis.frequency import FrequencyResponse as FrequencyResponse
from martensite.design.analysis.frequency import frequency_response as frequency_response
from martensite.design.analysis.speed import Speeds as Speeds
from martensite.design.analysis.speed import compute_speeds as compute_speeds
from martensite.design.backends.base import StoppedError as StoppedError
from martensite.design.optimise.designed import Designed as Designed
from martensite.design.optimise.optimise import optimise_design as optimise_design
from martensite.design.optimise.scan import scan as _scan_designs
from martensite.design.optimise.search import Search as _DesignSearch
from martensite.design.rules.formulas import RULES as RULES
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
from martensite.design.sweep.api import run_sweep as run_sweep
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
from martensite.design.synthesis.inverse_hysteresis import rising_curve as rising_curve
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
from martensite.design.tuning.response import steps as steps
from martensite.design.tuning.tuning import Scale as Scale
from martensite.design.tuning.tuning import Tuning as Tuning
from martensite.design.tuning.tuning import tune as tune

scan_designs = _scan_designs
DesignSearch = _DesignSearch
SensitivityIndices = _SensitivityIndices
sensitivity_indices = _sensitivity_indices
linearised_plant = _linearised_plant
mean_readings = _mean_readings
LqrSizes = _LqrSizes
SteadyPoint = _SteadyPoint
steady_point = _steady_point
steady_point_at = _steady_point_at
TuningSearch = _TuningSearch
TuningGoal = _TuningGoal
