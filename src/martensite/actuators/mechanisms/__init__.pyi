from martensite.actuators.mechanics.beam_modes import BeamModes as BeamModes
from martensite.actuators.mechanics.beam_modes import CantileverBeam as CantileverBeam
from martensite.actuators.mechanics.beam_modes import beam_modes as beam_modes
from martensite.actuators.mechanics.beam_modes import exact_omega as exact_omega
from martensite.actuators.mechanics.platform_kinematics import Plates as Plates
from martensite.actuators.mechanics.platform_kinematics import platform_angles as platform_angles
from martensite.actuators.mechanics.platform_kinematics import platform_lengths as platform_lengths
from martensite.actuators.mechanics.platform_workspace import Workspace as Workspace
from martensite.actuators.mechanics.platform_workspace import reachable_angles as reachable_angles
from martensite.actuators.mechanisms.beam_motor import BeamMotor as BeamMotor
from martensite.actuators.mechanisms.beam_motor import modal_numbers as modal_numbers
from martensite.actuators.mechanisms.bias_spring import BiasSpring as BiasSpring
from martensite.actuators.mechanisms.dead_weight import DeadWeight as DeadWeight
from martensite.actuators.mechanisms.finger import Finger as Finger
from martensite.actuators.mechanisms.hand import Hand as Hand
from martensite.actuators.mechanisms.joints import bowstring_arm as bowstring_arm
from martensite.actuators.mechanisms.joints import shorten_bowstring as shorten_bowstring
from martensite.actuators.mechanisms.lever import Lever as Lever
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform as ParallelPlatform
from martensite.actuators.mechanisms.pulley import AntagonisticPulley as AntagonisticPulley
from martensite.actuators.mechanisms.testing_machine import (
    TensileTestingMachine as TensileTestingMachine,
)
