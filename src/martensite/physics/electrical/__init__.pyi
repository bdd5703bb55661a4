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
from martensite.physics.electrical.temperature import PrescribedTemperature as PrescribedTemperature
from martensite.physics.electrical.voltage import VoltageSource as VoltageSource
