"""Named paths of a material point, scaled by a law.

A named path consists of one or several curves, each with a start and legs. Default values follow from simulations
of the law (`simulate.transformation_points`): transformation temperatures without load, and stress and strain at
the end of a transformation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from martensite.base.errors import ParameterError, UnknownNameError
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.compiled_law import AUSTENITE
from martensite.simulate.path_layout import Choices, Guide, ThermomechanicalPath, format_celsius, format_megapascal


@dataclass(frozen=True)
class NamedPath:
    """Function that lays out paths, with its options."""

    name: str
    uses: tuple[str, ...]
    """Fields of `Choices` that the function reads, except phase state and rates."""
    plane: tuple[str, str]
    """Recommended plot columns: horizontal, vertical."""
    lay: Callable[[Guide], list[ThermomechanicalPath]]

    @property
    def summary(self) -> str:
        """Return the first line of its description."""
        return (self.lay.__doc__ or "").partition("\n")[0]


PATHS: dict[str, NamedPath] = {}
"""All named paths."""
LOOP, RECOVERY = ("strain", "stress"), ("temperature", "strain")


def register_path(
    name: str, *uses: str, plane: tuple[str, str]
) -> Callable[[Callable[[Guide], list[ThermomechanicalPath]]], Callable[[Guide], list[ThermomechanicalPath]]]:
    """Return the decorator that registers a function under a name."""

    def file_under(lay: Callable[[Guide], list[ThermomechanicalPath]]) -> Callable[[Guide], list[ThermomechanicalPath]]:
        PATHS[name] = NamedPath(name, uses, plane, lay)
        return lay

    return file_under


def find_path(name: str) -> NamedPath:
    """Return a named path; raise `UnknownNameError` if the name is unknown."""
    if name not in PATHS:
        raise UnknownNameError("path", name, PATHS)
    return PATHS[name]


def build_paths(name: str, law: AbstractLaw, choices: Choices | None = None) -> list[ThermomechanicalPath]:
    """Return the paths of a name, scaled by a law.

    Args:
        name: a name from `PATHS`.
        law: law of the material point.
        choices: values that replace defaults of the law.

    Raises:
        UnknownNameError: no path has that name.
        ParameterError: the law lacks a required transformation.
    """
    path = find_path(name)
    chosen = choices or Choices()
    idle = next(
        (
            n
            for n in ("temperatures", "stresses", "strain")
            if n not in path.uses and getattr(chosen, n) not in ((), None)
        ),
        None,
    )
    if idle is not None:
        raise ParameterError(f"The path `{name}` takes no {idle}; its settings are {', '.join(path.uses)}.")
    return path.lay(Guide(law, chosen))


# ---------------------------------------------------------------- the paths


@register_path("superelastic", "temperatures", "stresses", plane=LOOP)
def build_superelastic(guide: Guide) -> list[ThermomechanicalPath]:
    """Load austenite to a stress and unload it, at each of several temperatures.

    Temperatures: A_f + 10, 25 and 40 K. Stress: the first given value for all temperatures, else beyond the end of
    each transformation.
    """
    fractions = guide.choices.fractions or AUSTENITE

    def course(temperature: float) -> ThermomechanicalPath:
        peak = guide.load(temperature, fractions)
        legs = guide.stress(peak, peak), guide.stress(peak, 0.0)
        return ThermomechanicalPath(format_celsius(temperature), 0.0, temperature, fractions, legs)

    return [course(temperature) for temperature in guide.hot(10.0, 25.0, 40.0)]


@register_path("tension", "temperatures", "strain", plane=LOOP)
def build_tension(guide: Guide) -> list[ThermomechanicalPath]:
    """Stretch to a strain and return to the start, at each of several temperatures.

    Temperatures: one with stable martensite, and A_f + 15 K. Strain: beyond the end of the transformation. A
    specimen with residual strain goes slack.
    """
    temperatures = guide.choices.temperatures or (guide.cold_state[0], *guide.hot(15.0))

    def course(temperature: float) -> ThermomechanicalPath:
        near = abs(temperature - guide.cold_state[0]) < 1e-9
        fractions = guide.choices.fractions or (guide.cold_state[1] if near else AUSTENITE)
        peak = guide.choices.strain or guide.top(temperature, fractions).strain + 0.004
        rest = guide.rest(temperature, fractions)
        legs = guide.strain(peak - rest, peak), guide.strain(peak - rest, rest)
        return ThermomechanicalPath(format_celsius(temperature), 0.0, temperature, fractions, legs)

    return [course(temperature) for temperature in temperatures]


@register_path("isobaric", "stresses", plane=RECOVERY)
def build_isobaric(guide: Guide) -> list[ThermomechanicalPath]:
    """Cool austenite and heat it again, at each of several constant stresses.

    Stresses: 50, 100 and 200 MPa. Temperatures: from above A_f at the highest stress to below M_f at the lowest.
    """
    stresses = guide.choices.stresses or (50e6, 100e6, 200e6)
    hot = max(guide.marks_at(stress).A_f for stress in stresses) + 10.0
    cold = min(guide.marks_at(stress).M_f for stress in stresses) - 10.0
    legs = guide.heat(hot, cold), guide.heat(cold, hot)
    fractions = guide.choices.fractions or AUSTENITE
    return [ThermomechanicalPath(format_megapascal(stress), stress, hot, fractions, legs) for stress in stresses]


@register_path("free-recovery", "temperatures", "stresses", plane=RECOVERY)
def free_recovery(guide: Guide) -> list[ThermomechanicalPath]:
    """Load and unload cold, then heat without load: the strain recovers.

    Temperature: by default below M_f if stress orients twinned martensite, else between M_s and A_s. Stress: beyond
    the end of the transformation.
    """
    return [_build_recovery(guide, "load, unload, heat", cool=False)]


@register_path("shape-memory", "temperatures", "stresses", plane=RECOVERY)
def shape_memory(guide: Guide) -> list[ThermomechanicalPath]:
    """Load and unload cold, heat without load and cool again: the one-way effect.

    Temperature and stress as for free-recovery.
    """
    return [_build_recovery(guide, "load, unload, heat, cool", cool=True)]


def _build_recovery(guide: Guide, label: str, *, cool: bool) -> ThermomechanicalPath:
    temperature, fractions = guide.cold_state
    peak, hot = guide.load(temperature, fractions), guide.marks.A_f + 20.0
    legs = [guide.stress(peak, peak), guide.stress(peak, 0.0), guide.heat(temperature, hot)]
    if cool:
        legs.append(guide.heat(hot, temperature))
    return ThermomechanicalPath(label, 0.0, temperature, fractions, tuple(legs))


@register_path("constrained-recovery", "temperatures", "strain", plane=("temperature", "stress"))
def constrained_recovery(guide: Guide) -> list[ThermomechanicalPath]:
    """Stretch and unload cold, clamp, heat to A_f + 60 K and cool: the recovery stress.

    Temperature: as for free-recovery. Strain: half of the strain that completes the transformation.
    """
    temperature, fractions = guide.cold_state
    peak = guide.choices.strain or 0.5 * guide.top(temperature, fractions).strain
    hot = guide.marks.A_f + 60.0
    unload = guide.stress(peak / guide.choices.rates.strain * guide.choices.rates.stress, 0.0)
    legs = (
        guide.strain(peak, peak),
        unload,
        guide.heat(temperature, hot, "strain"),
        guide.heat(hot, temperature, "strain"),
    )
    return [ThermomechanicalPath("stretch, unload, clamp, heat, cool", 0.0, temperature, fractions, legs)]


@register_path("minor-loops", "stresses", plane=RECOVERY)
def minor_loops(guide: Guide) -> list[ThermomechanicalPath]:
    """Run a complete thermal cycle at constant stress, then partial heatings from cold.

    Stress: 100 MPa. The partial heatings end 75, 60, 45 and 30 % of the way from A_s to A_f.
    """
    stresses = guide.choices.stresses or (100e6,)

    def course(stress: float) -> ThermomechanicalPath:
        marks = guide.marks_at(stress)
        hot, cold = marks.A_f + 10.0, marks.M_f - 10.0
        turns: Sequence[float] = [
            hot,
            *(marks.A_s + share * (marks.A_f - marks.A_s) for share in (0.75, 0.6, 0.45, 0.3)),
        ]
        legs = [guide.heat(hot, cold)]
        for turn in turns:
            legs += [guide.heat(cold, turn), guide.heat(turn, cold)]
        fractions = guide.choices.fractions or AUSTENITE
        return ThermomechanicalPath(format_megapascal(stress), stress, hot, fractions, tuple(legs))

    return [course(stress) for stress in stresses]
