from martensite.actuators.elements.axial_wire import AxialWire as AxialWire
from martensite.actuators.elements.coil_spring import CoilSpring as CoilSpring
from martensite.actuators.elements.limits import ElementLimits as ElementLimits
from martensite.actuators.elements.ribbon import Ribbon as Ribbon
from martensite.actuators.elements.rows import Bundle as Bundle
from martensite.actuators.elements.rows import LinkChain as LinkChain
from martensite.actuators.elements.wire import Wire as Wire
