from martensite.export.c_core import CCore as CCore
from martensite.export.c_core import build_c_core as build_c_core
from martensite.export.c_example import example_text as example_text
from martensite.export.c_example_inputs import played_by_system as played_by_system
from martensite.export.c_loop import build_c_loop as build_c_loop
from martensite.export.control_systems import plant_state_space as plant_state_space
from martensite.export.control_systems import rest_state as rest_state
from martensite.export.control_systems import to_control as to_control
from martensite.export.control_systems import to_nonlinear_system as to_nonlinear_system
from martensite.export.control_systems import to_state_space as to_state_space
from martensite.export.fmu.archive import Fmu as Fmu
from martensite.export.fmu.archive import to_fmu as to_fmu
from martensite.export.gymnasium import SmaEnv as SmaEnv
from martensite.export.gymnasium_vector import SmaVectorEnv as SmaVectorEnv
from martensite.export.learning_task import LearningTask as _LearningTask
from martensite.export.mjcf import bridge_of as bridge_of
from martensite.export.mjcf import tendon_signals as tendon_signals
from martensite.export.mjcf import to_mjcf as to_mjcf
from martensite.export.mjcf_snippet import to_mjcf_snippet as to_mjcf_snippet
from martensite.export.mujoco_bridge import MujocoBridge as MujocoBridge
from martensite.export.mujoco_bridge import TendonActuator as TendonActuator
from martensite.export.mujoco_render import render_mujoco as render_mujoco
from martensite.export.mujoco_rest import holding_tensions as holding_tensions
from martensite.export.mujoco_result import MujocoResult as MujocoResult

LearningTask = _LearningTask
