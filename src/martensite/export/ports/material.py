"""A point of a material as a system: strain and temperature in, stress out.

Strain [-] counts from the host's start, at the first temperature under the stress `preload`. Then

    σ = [ε + ε₀ - ε_free(ξ, T)]/C(ξ),    ε₀ = ε_free(ξ₀, T₀) + C(ξ₀) σ₀ - ε(0),

and the step is the fixed point of `martensite.physics.laws.coupling`, as in `martensite.simulate.material_point`.
Strains include thermal strain: the host must not add any. Tension is positive.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.actuators.assembly.base import DriveSignal
from martensite.actuators.elements.base import ELEMENTS, AbstractElement
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.actuators.mechanisms.base import AbstractMechanism, Output
from martensite.base.errors import InputError, ParameterError
from martensite.base.parameters import Number, option, param, part
from martensite.export.ports.element import choose_actuator
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.coupling import StepReport, advance_memory

OUTPUTS = {
    "stress": Output("Pa", "axial stress", "σ"),
    "heat": Output("J/m^3", "latent heat released in the last step; less than 0 where it was taken up", "q"),
    "martensite_fraction": Output("1", "martensite fraction", "ξ"),
    "oriented_fraction": Output("1", "net oriented martensite fraction", "ξ_S"),
    "law_strain": Output("1", "strain from unloaded austenite at the reference temperature", "ε"),
}


PROBES = (1e-7, 1e-3)
"""Changes of strain [-] and temperature [K] for central differences of a split step."""


class PointState(NamedTuple):
    """State of a point; the first two fields are the inputs of the last step."""

    strain: Scalar
    """Host strain at the end of the last step [-]."""
    temperature: Scalar
    """Temperature at the end of the last step [K]."""
    mounted: Scalar
    """Strain of the law at zero host strain [-]."""
    heat: Scalar
    """Latent heat released in the last step [J/m³]."""
    memory: Any
    """Memory of the law."""
    worn: Any
    """State of wear by cycles (`laws.wear`)."""


class MaterialPort(AbstractSystem):
    """The material of an element, for a host with its own geometry and heat balance."""

    element: AbstractElement = part("the element whose material it is", ELEMENTS)
    preload: Number = param("Pa", "stress at zero strain, at the start", low=-1e10, high=1e10, default=0.0)
    compressed: str = option("what it does under compression", "carries", "slack", default="carries")

    def check(self) -> None:
        """Raise `ParameterError` if the element has several phase states."""
        if not isinstance(self.element, AbstractLumped):
            raise ParameterError(
                f"A material is taken from an element with one phase state, but `{self.element.registered_name}` "
                "has several; use that of `wire`."
            )

    @property
    def mechanism(self) -> AbstractMechanism:  # type: ignore[override]
        """Raise `InputError`: a material has no mechanism."""
        raise InputError("A material has no mechanism: the host makes elements of it.")

    def actuators(self) -> dict[str, Actuator]:
        """Return an empty table: the host makes the elements."""
        return {}

    def drives(self) -> list[DriveSignal]:
        """Return strain and temperature at the end of a step."""
        return [DriveSignal("strain", "1", True), DriveSignal("temperature", "K", True)]

    def label(self, port: str, name: str) -> str:
        """Return the plain name."""
        return name

    def drive_at(self, port: str) -> str:
        """Return `strain`."""
        return "strain"

    def outputs(self) -> dict[str, Output]:
        """Return stress, heat and state."""
        return dict(OUTPUTS)

    def description(self) -> str:
        """Return the description, such as `material (brinson), which carries compression`."""
        side = "carries compression" if self.compressed == "carries" else "goes slack under compression"
        return f"material ({self.element.law.registered_name}), which {side}"

    def list_cautions(self) -> list[str]:
        """Return cautions for the host."""
        law = self.element.law
        if self.compressed == "slack" or not law.tension_only:
            return []
        name = law.registered_name
        remedy = '; try its `compression = "symmetric"`' if "compression" in law.declarations else ""
        return [f"Caution: `{name}` knows tension only: compression drives its martensite back{remedy}."]

    def sample_time(self) -> float:
        """Return 0: steps may have any length."""
        return 0.0

    def convergence_scales(self) -> dict[str, float]:
        """Return the scales of stress and fraction."""
        return {"stress": 1e6, "martensite_fraction": 0.01}

    def init(self, xp: Namespace, *drives: Scalar) -> PointState:
        """Return the state under the preload at the first temperature, at any start strain of the host."""
        strain, temperature = drives
        memory, worn = self._lumped.warm_up(xp, self.preload, temperature)
        law = self._law(xp, worn)
        mounted = law.strain(xp, law.fractions(memory), self.preload, temperature) - strain
        return PointState(strain, temperature, mounted, 0.0, memory, worn)

    def step(self, xp: Namespace, state: PointState, *drives: Any, dt: Scalar) -> tuple[PointState, StepReport]:
        """Advance to a strain and a temperature in dt [s]."""
        strain, temperature = drives
        law, wear = self._law(xp, state.worn), self._lumped.wear

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            elastic = strain + state.mounted - law.free_strain(xp, fractions, temperature)
            stress = elastic / law.compliance(xp, fractions)
            if self.compressed == "slack":  # taut at 0, where a host begins: its stiffness is that of the material
                stress = xp.where(stress < 0.0, 0.0, stress)
            return stress, temperature

        memory, report = advance_memory(xp, law, state.memory, settle, dt)
        end, worn = law.fractions(memory), state.worn
        if wear is not None:
            worn = wear.advance(xp, worn, end, memory.stress, memory.temperature, dt)
        latent = law.heat(xp, self._latent(), memory.stress, memory.temperature)
        share = law.released_fraction(end) - law.released_fraction(law.fractions(state.memory))
        return PointState(strain, temperature, state.mounted, latent * share, memory, worn), report

    def observe(self, xp: Namespace, state: PointState, *drives: Scalar) -> list[Scalar]:
        """Return the outputs in the order of `outputs`."""
        law, memory = self._law(xp, state.worn), state.memory
        fractions = law.fractions(memory)
        strain = law.strain(xp, fractions, memory.stress, memory.temperature)
        return [memory.stress, state.heat, *fractions[:2], strain]

    @property
    def _lumped(self) -> Any:
        return self.element

    def _law(self, xp: Namespace, worn: Any) -> AbstractLaw:
        return self._lumped.apply_wear(xp, worn).law

    def _latent(self) -> Scalar:
        """Return the latent heat per volume [J/m³]; 0 for an element without one."""
        density, latent = (getattr(self.element, name, 0.0) for name in ("density", "latent_heat"))
        return density * latent


def build_material_port(
    system: AbstractSystem, *, port: str | None = None, preload: float = 0.0, compressed: str = "carries"
) -> MaterialPort:
    """Return the material of an element of a system.

    Args:
        system: the system.
        port: port of the element; may be omitted for a single one.
        preload: stress [Pa] at zero host strain.
        compressed: `carries` compression (a bar), or goes `slack` (a wire).

    Raises:
        InputError: the port does not exist, or several ports need a choice.
        ParameterError: the element has several phase states.
    """
    actuator, _ = choose_actuator(system, port)
    return MaterialPort(element=actuator.element, preload=preload, compressed=compressed)  # pyrefly: ignore[missing-argument]
