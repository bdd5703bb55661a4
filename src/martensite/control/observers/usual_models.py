"""Other things that a wire may be: the models that a bank compares with the one that is believed.

| name | what is different |
| --- | --- |
| `fan` | heat is lost as many times faster as `fan_factor` says |
| `r_phase` | an R-phase between austenite and martensite, whose resistance is higher by `rphase_rise` |
| `slack` | the element hangs through by `slack_strain` of its length |
| `clamped` | the mechanism does not move |

The R-phase is that of an unknown wire, halfway between M_s and A_s at zero stress and 6 K wide; its other numbers are
the typical ones of the law `r-phase`. It is there for laws with a phase diagram that know none, the last two for a
mechanism of one element on a load line.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED, Number, Parametrised, param, part
from martensite.base.units import parse_quantity
from martensite.control.faults.mechanism import Clamped, HinderedLoadLine, Slack
from martensite.control.faults.plant import Draught, list_placed
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import AbstractResistance, Conductor
from martensite.physics.kinetics.diagram import AbstractPhaseDiagram
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.laws.r_phase import RPhase

AS_MODELLED = "as_modelled"
FAN, RPHASE, SLACK, CLAMPED = USUAL = "fan", "r_phase", "slack", "clamped"
RPHASE_WIDTH = 6.0
"""R_s - R_f of an unknown wire [K]."""


class UsualSizes(NamedTuple):
    """By how much the usual models are different."""

    fan_factor: Scalar
    rphase_rise: Scalar
    slack_strain: Scalar


class RisenResistance(AbstractResistance):
    """A resistance that rises with the R-phase: R (1 + a ξ_R)."""

    three_phases = True

    resistance_model: AbstractResistance = part("resistance without an R-phase")
    rise: Number = param("1", "by which share it is higher where all is R-phase", low=-0.5, high=1.0)

    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """R [ohm] without an R-phase."""
        return self.resistance_model.resistance(xp, fraction, strain, temperature, shape)

    def mix_phases(
        self, xp: Namespace, fraction: Scalar, rphase: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """R [ohm] with it."""
        return (1.0 + self.rise * rphase) * self.resistance(xp, fraction, strain, temperature, shape)


def list_usual_models(
    xp: Namespace, model: AbstractSystem, names: Iterable[str], sizes: UsualSizes
) -> dict[str, AbstractSystem]:
    """Return the model as it is believed, and those of the usual ones that it can be turned into, by name."""
    found, wanted = dict[str, AbstractSystem](), list(names)
    line = model.mechanism
    held = isinstance(line, AbstractLoadLine)
    if isinstance(line, AbstractLoadLine) and {SLACK, CLAMPED} & set(wanted):  # one memory for all: it can be mixed
        hindered = HinderedLoadLine(line=line, slack=0.0, shut=0.0)
        model = model.rebuilt({_find_place(model, line): hindered})
    lengths = {leaf.path: leaf.value for leaf in model.leaves()}
    if FAN in wanted:
        fan = Draught(factor=1.0).rebuilt({"factor": sizes.fan_factor})
        found[FAN] = fan.plant(xp, model, True)
    if RPHASE in wanted and (other := _add_rphases(model, sizes.rphase_rise)):
        found[RPHASE] = other
    if SLACK in wanted and held and "element.length" in lengths:
        lost = sizes.slack_strain * lengths["element.length"]
        found[SLACK] = Slack(length=1.0).rebuilt({"length": lost}).plant(xp, model, True)
    if CLAMPED in wanted and held:
        found[CLAMPED] = Clamped().plant(xp, model, True)
    return {AS_MODELLED: model, **{name: found[name] for name in wanted if name in found}}


def find_wrapped_path(path: str, model: Parametrised) -> str:
    """Return the path of a number in a model in which parts that lead to it are wrapped in others.

    Raises:
        ParameterError: it is not there, or not once.
    """
    paths = [leaf.path for leaf in model.leaves()]
    found = [path] if path in paths else [one for one in paths if _is_wrapped(path.split("."), one.split("."))]
    if len(found) != 1:
        raise ParameterError(f"has {'no' if not found else 'several'} `{path}`, which is estimated")
    return found[0]


def _is_wrapped(path: list[str], longer: list[str]) -> bool:
    rest = iter(longer)
    return path[0] == longer[0] and path[-1] == longer[-1] and all(name in rest for name in path)


def _find_place(model: Parametrised, one: Parametrised) -> str:
    return next(path for path, part in list_placed(model, "") if part is one).rstrip(".")


def _add_rphases(model: AbstractSystem, rise: Scalar) -> AbstractSystem | None:
    """Return the model with an R-phase in every law, if all of them can have one."""
    changed: dict[str, Any] = {}
    for path, one in list_placed(model, ""):
        if isinstance(one, AbstractLaw):
            if not isinstance(one, AbstractPhaseDiagram) or one.rphase:
                return None
            changed[path.rstrip(".")] = _add_rphase(one)
        if isinstance(one, AbstractResistance):
            risen = RisenResistance(resistance_model=one, rise=0.0)
            changed[path.rstrip(".")] = risen.rebuilt({"rise": rise})
    return model.rebuilt(changed)


def _add_rphase(law: AbstractPhaseDiagram) -> RPhase:
    """Return a law with the numbers of another one, and an R-phase of an unknown wire."""
    start = 0.5 * (law.M_s + law.A_s)
    own: Mapping[str, Any] = {"R_s": start, "R_f": start - RPHASE_WIDTH, "E_R": 0.5 * (law.E_A + law.E_M)}
    own = {**own, "eps_R": 0.175 * law.eps_L}
    made = object.__new__(RPhase)
    for name, one in RPhase.declarations.items():
        usual = one.default if one.default is not REQUIRED else one.typical
        usual = parse_quantity(usual, one.unit) if one.kind == "parameter" and isinstance(usual, str) else usual
        made.__dict__[name] = own.get(name, law.__dict__.get(name, usual))
    return made
