from martensite.actuators.elements.axial_wire import AxialWire as AxialWire
from martensite.actuators.elements.bundle import Bundle as Bundle
from martensite.actuators.elements.chain import Chain as Chain
from martensite.actuators.elements.coil_spring import CoilSpring as CoilSpring
from martensite.actuators.elements.limits import Limits as Limits
from martensite.actuators.elements.ribbon import Ribbon as Ribbon
from martensite.actuators.elements.wire import Wire as Wire
