"""Predefined alternative models of a wire for a bank.

| name | difference |
| --- | --- |
| `fan` | the heat loss is `fan_factor` times larger |
| `r_phase` | an R-phase between austenite and martensite with a resistance that is higher by `rphase_rise` |
| `slack` | the element has a slack of `slack_strain` of its length |
| `clamped` | the mechanism does not move |

The R-phase lies halfway between M_s and A_s at zero stress and is 6 K wide; its other parameters are the typical ones
of the law `r-phase`. It needs laws with a phase diagram and without an R-phase. Slack and clamp need a mechanism of one
element on a load line.
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
    """Sizes of the differences."""

    fan_factor: Scalar
    rphase_rise: Scalar
    slack_strain: Scalar


class RisenResistance(AbstractResistance):
    """A resistance that rises with the R-phase: R (1 + a ξ_R)."""

    three_phases = True

    resistance_model: AbstractResistance = part("resistance without an R-phase")
    rise: Number = param("1", "relative rise of the resistance in R-phase", low=-0.5, high=1.0)

    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        return self.resistance_model.resistance(xp, fraction, strain, temperature, shape)

    def mix_phases(
        self, xp: Namespace, fraction: Scalar, rphase: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        return (1.0 + self.rise * rphase) * self.resistance(xp, fraction, strain, temperature, shape)


def list_usual_models(
    xp: Namespace, model: AbstractSystem, names: Iterable[str], sizes: UsualSizes
) -> dict[str, AbstractSystem]:
    """Return the nominal model and the possible alternative models, by name."""
    models, wanted = dict[str, AbstractSystem](), list(names)
    line = model.mechanism
    on_load_line = isinstance(line, AbstractLoadLine)
    if isinstance(line, AbstractLoadLine) and {SLACK, CLAMPED} & set(wanted):  # one memory for all: it can be mixed
        hindered = HinderedLoadLine(line=line, slack=0.0, shut=0.0)
        model = model.rebuilt({_find_place(model, line): hindered})
    lengths = {leaf.path: leaf.value for leaf in model.leaves()}
    if FAN in wanted:
        fan = Draught(factor=1.0).rebuilt({"factor": sizes.fan_factor})
        models[FAN] = fan.plant(xp, model, True)
    if RPHASE in wanted and (other := _add_rphases(model, sizes.rphase_rise)):
        models[RPHASE] = other
    if SLACK in wanted and on_load_line and "element.length" in lengths:
        lost = sizes.slack_strain * lengths["element.length"]
        models[SLACK] = Slack(length=1.0).rebuilt({"length": lost}).plant(xp, model, True)
    if CLAMPED in wanted and on_load_line:
        models[CLAMPED] = Clamped().plant(xp, model, True)
    return {AS_MODELLED: model, **{name: models[name] for name in wanted if name in models}}


def find_wrapped_path(path: str, model: Parametrised) -> str:
    """Return the path of a parameter in a model whose parts are wrapped in others.

    Raises:
        ParameterError: the parameter does not exist, or occurs more than once.
    """
    paths = [leaf.path for leaf in model.leaves()]
    matches = [path] if path in paths else [one for one in paths if _is_wrapped(path.split("."), one.split("."))]
    if len(matches) != 1:
        raise ParameterError(f"has {'no' if not matches else 'several'} `{path}`, which is estimated")
    return matches[0]


def _is_wrapped(path: list[str], longer: list[str]) -> bool:
    rest = iter(longer)
    return path[0] == longer[0] and path[-1] == longer[-1] and all(name in rest for name in path)


def _find_place(model: Parametrised, one: Parametrised) -> str:
    return next(path for path, part in list_placed(model, "") if part is one).rstrip(".")


def _add_rphases(model: AbstractSystem, rise: Scalar) -> AbstractSystem | None:
    changed: dict[str, Any] = {}
    for path, one in list_placed(model, ""):
        if isinstance(one, AbstractLaw):
            if not isinstance(one, AbstractPhaseDiagram) or one.has_rphase:
                return None
            changed[path.rstrip(".")] = _add_rphase(one)
        if isinstance(one, AbstractResistance):
            risen = RisenResistance(resistance_model=one, rise=0.0)
            changed[path.rstrip(".")] = risen.rebuilt({"rise": rise})
    return model.rebuilt(changed)


def _add_rphase(law: AbstractPhaseDiagram) -> RPhase:
    start = 0.5 * (law.M_s + law.A_s)
    values: Mapping[str, Any] = {"R_s": start, "R_f": start - RPHASE_WIDTH, "E_R": 0.5 * (law.E_A + law.E_M)}
    values = {**values, "eps_R": 0.175 * law.eps_L}
    law_with_rphase = object.__new__(RPhase)
    for name, one in RPhase.declarations.items():
        usual = one.default if one.default is not REQUIRED else one.typical
        usual = parse_quantity(usual, one.unit) if one.kind == "parameter" and isinstance(usual, str) else usual
        law_with_rphase.__dict__[name] = values.get(name, law.__dict__.get(name, usual))
    return law_with_rphase
