"""Testing machine: grips the element and makes its force or its elongation follow a signal.

The signal `command` is a force F_c, a stress σ_c, a travel u_c of the crosshead, or a strain ε_c. At the end of every
step

    force, stress         F = F_c  or  σ_c A
    elongation, strain    e - e₀ + (F - F₀)/k = u_c  or  ε_c l     while taut, else F = 0

with the elongation e of the element, e₀ as mounted under the force F₀ (the preload, or the first command if that is a
force or a stress), the stiffness k of frame and grips in series, and the section A and gauge length l of the test
report. These two belong to the report, not to the element; without them only forces and travels are possible. Nothing
is approximated: the element meets a given force, or a straight load line, vertical for rigid frame and grips. No
element can be pushed.

While taut the crosshead travels by e - e₀ + (F - F₀)/k in every mode. Without an extensometer a test reports this as
elongation, which is why its moduli are too low.

Source: equilibrium of springs in series. Sign convention: command and travel are positive in tension and zero as
mounted; position is that of the grip and grows as the element shortens.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.elements.base import AbstractElement, Effort, Pull, Spring
from martensite.actuators.mechanisms.base import (
    MECHANISMS,
    AbstractMechanism,
    Column,
    Load,
    MechanicalEnergy,
    Mechanics,
    Output,
    Readout,
)
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport

UNITS = {"force": "N", "stress": "Pa", "elongation": "m", "strain": "1"}
"""Control -> unit of its command."""
SIZES = {"stress": "section", "strain": "gauge_length"}
"""Control -> factor from its command to a force or a travel."""


class MountedElement(NamedTuple):
    """Element as mounted."""

    elongation: Scalar
    """e₀ [m]"""
    force: Scalar
    """F₀ [N]"""


@MECHANISMS.register("testing-machine")
class TensileTestingMachine(AbstractMechanism):
    """Tensile testing machine whose `command` prescribes force, stress, elongation or strain."""

    typical_scenario = "tensile-test"

    control: str = option("what the signal `command` prescribes", *UNITS)
    preload: Number = param(
        "N",
        "force F₀ under which the element is mounted if a travel is prescribed",
        low=0.0,
        high=1e6,
        default=0.0,
        typical="3 N",
    )
    stiffness: Number = param(
        "N/m",
        "stiffness k of frame and grips together; rigid if left out",
        above=0.0,
        default=math.inf,
        typical="1e4 N/m",
    )
    section: Number = param(
        "m^2", "section A that makes a force of a prescribed stress", above=0.0, default=math.inf, typical="5 m^2"
    )
    gauge_length: Number = param(
        "m", "length l that makes an elongation of a prescribed strain", above=0.0, default=math.inf, typical="100 mm"
    )

    def check(self) -> None:
        """Raise `ParameterError` if the section or length of a stress or strain is missing."""
        name = SIZES.get(self.control)
        if name is not None and math.isinf(getattr(self, name)):
            raise ParameterError(
                f'`testing-machine` with control = "{self.control}" needs `{name}` '
                f"[{self.declarations[name].unit}]; none given."
            )

    @override
    def signals(self) -> dict[str, str]:
        return {"command": UNITS[self.control]}

    @override
    def outputs(self) -> dict[str, Output]:
        return {
            "position": Output("m", "position of the mechanism", "x"),
            "crosshead": Output("m", "travel of the crosshead, frame and grips included", "x_c"),
        }

    @override
    def convergence_scales(self) -> dict[str, float]:
        return {"position": 1e-6}

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [self.preload]

    @override
    def first_forces(self, xp: Namespace, signals: Column) -> Column:
        return [xp.maximum(self._target(signals), 0.0)] if self._pulls else [self.preload]

    @override
    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> MountedElement:
        return MountedElement(elongations[0], self.first_forces(xp, signals)[0])

    @override
    def advance(
        self, xp: Namespace, memory: MountedElement, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[MountedElement, list[Any], StepReport]:
        ((element, state, heating),) = loads
        pull = self._pull(memory, signals)
        after, report = element.advance(xp, state, heating, pull, dt)
        return memory, [after], report

    @override
    def observe(self, xp: Namespace, memory: MountedElement, loads: Sequence[Load], signals: Column) -> Readout:
        (load,) = loads
        force = load.meet_pull(xp, self._pull(memory, signals))
        give = (force - memory.force) * (1.0 / self.stiffness)
        travel = self._travel(xp, memory, load.element, load.state, force, signals)
        return [force], [give - travel, travel]

    def mechanics(self, xp: Namespace, memory: MountedElement, loads: Sequence[Load], signals: Column) -> Mechanics:
        """Return ½ F²/k of frame and grips, and the work against the crosshead drive."""
        ((element, state, _),) = loads
        force = element.force(state)
        travel = self._travel(xp, memory, element, state, force, signals)
        spring = MechanicalEnergy(springs=(0.5 / self.stiffness) * force * force)
        taut = memory.elongation - element.elongation(xp, state, force)
        slack = (force - memory.force) * (1.0 / self.stiffness) - travel
        ways = (xp.where(force > 0.0, taut, slack),)
        return Mechanics(spring, ways, outside=(Effort(-force, travel),))

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Return the element between grips; the crosshead pulls the upper grip, by a spring if compliant."""
        element = reading.lengths["element"]
        grip, thick = element - reading.outputs["position"], 0.02 * element
        head, wide = 1.3 * element + reading.outputs["crosshead"], 0.3 * element
        sides = [((x, 0.0, -thick), (x, 0.0, 1.6 * element)) for x in (-wide, wide)]
        rod = ((0.0, 0.0, grip), (0.0, 0.0, head))
        return [
            draw_bar("base", thick, (-wide, 0.0, -thick), (wide, 0.0, -thick), kind="wall"),
            *(draw_bar(f"column {k}", 0.6 * thick, *s, kind="ground") for k, s in enumerate(sides, 1)),
            draw_bar("crosshead", thick, (-wide, 0.0, head), (wide, 0.0, head)),
            DrawingShape("element", "wire", ((0.0, 0.0, 0.0), rod[0]), 0.0, "element"),
            DrawingShape("frame and grips", "spring" if self.stiffness < math.inf else "link", rod, thick),
            DrawingShape("grip", "slider", (rod[0],), thick),
        ]

    @property
    def _pulls(self) -> bool:
        """Return True if a force is prescribed, not a travel."""
        return self.control in ("force", "stress")

    def _target(self, signals: Column) -> Scalar:
        """Return the prescribed force [N] or travel [m]."""
        (command,) = signals
        size = SIZES.get(self.control)
        return command if size is None else command * getattr(self, size)

    def _travel(
        self,
        xp: Namespace,
        memory: MountedElement,
        element: AbstractElement,
        state: Any,
        force: Scalar,
        signals: Column,
    ) -> Scalar:
        """Return the travel of the crosshead [m] under a force [N]."""
        if not self._pulls:
            return self._target(signals)
        give = (force - memory.force) * (1.0 / self.stiffness)
        return element.elongation(xp, state, force) - memory.elongation + give

    def _pull(self, memory: MountedElement, signals: Column) -> Pull:
        """Return the load line of the machine."""
        target = self._target(signals)

        def prescribe_force(xp: Namespace, spring: Spring) -> Scalar:
            return xp.maximum(target, 0.0)

        def balance_force(xp: Namespace, spring: Spring) -> Scalar:
            give = 1.0 / self.stiffness
            reach = memory.elongation + target + memory.force * give
            return xp.maximum((reach - spring.free) / (spring.compliance + give), 0.0)

        return prescribe_force if self._pulls else balance_force
