from martensite.identify.blocks.bouc_wen import BoucWen as BoucWen
from martensite.identify.blocks.duhem import Duhem as Duhem
from martensite.identify.blocks.generalised_prandtl_ishlinskii import (
    GeneralisedPrandtlIshlinskii as GeneralisedPrandtlIshlinskii,
)
from martensite.identify.blocks.play import Play as Play
from martensite.identify.blocks.prandtl_ishlinskii import PrandtlIshlinskii as PrandtlIshlinskii
from martensite.identify.blocks.transfer_function import TransferFunction as TransferFunction
from martensite.identify.chains.best_linear import fit_linear_model as fit_linear_model
from martensite.identify.chains.chain import Chain as _BlockChain
from martensite.identify.chains.chain_text import parse_chain as parse_chain
from martensite.identify.chains.engine import ChainEngine as ChainEngine
from martensite.identify.chains.estimate import estimate_chain as _estimate_model
from martensite.identify.chains.goals import Options as _EstimateOptions
from martensite.identify.chains.linearise import linearise_chain as linearise_chain
from martensite.identify.chains.linearise import static_curve as static_curve
from martensite.identify.chains.plant import build_plant as build_plant
from martensite.identify.chains.scores import compute_rms as compute_rms
from martensite.identify.chains.stages import ModelStage as ModelStage
from martensite.identify.chains.stages import identify_stages as identify_stages
from martensite.identify.chains.uncertainty import estimate_chain_uncertainty as _model_uncertainty
from martensite.identify.chains.validation import validate_chain as _validate_model
from martensite.identify.ladder.climb import climb_ladder as climb_ladder
from martensite.identify.operators.play import PlaySum as PlaySum
from martensite.scenario.identify_logs import identify_log as identify_log
from martensite.scenario.model_files import model_provenance as model_provenance
from martensite.scenario.model_files import read_model as read_model
from martensite.scenario.model_files import write_model as write_model
from martensite.show.pages import write_model_report as write_model_report

BlockChain = _BlockChain
estimate_model = _estimate_model
EstimateOptions = _EstimateOptions
model_uncertainty = _model_uncertainty
validate_model = _validate_model
