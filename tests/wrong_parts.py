"""Parts that are wrong on purpose, by kind: every check of every suite must notice one of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import builders
import numpy as np
import typer

from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import Column, Output
from martensite.actuators.mechanisms.hand import Hand
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.parameters import Number, param
from martensite.control.checks.base import CheckResult
from martensite.control.checks.reading import Overheat, SensorLost
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.relay import OnOff
from martensite.control.faults.plant import SupplySag
from martensite.control.faults.sensor import Stuck
from martensite.control.observers.inverse import InverseModel
from martensite.control.sensors.channel import CurrentSensor
from martensite.control.supervisors.guard import Guard
from martensite.fit.experiment_kinds.base import Proposal, RecognisedExperiment
from martensite.fit.experiment_kinds.isobaric import Isobaric
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.identify.blocks.gain import Gain
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource
from martensite.physics.fluids.base import AbstractFluid, FluidProperties
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import Material, Source, load_material
from martensite.physics.thermal.ends import AbstractEnds
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.records import Record
from martensite.simulate.measures.extremes import Largest
from martensite.studies.base import AbstractStudy, Claim
from martensite.testing import build_example


class Falling(ConstantCooling):
    """Loses less and less."""

    def film(self, xp: Any, temperature: Any, ambient: Any, shape: Any) -> Any:
        return self.h / (1.0 + (temperature - ambient) * (temperature - ambient))


class Heating(ConstantCooling):
    """Takes heat from the colder side."""

    def film(self, xp: Any, temperature: Any, ambient: Any, shape: Any) -> Any:
        return self.h * (temperature - ambient - 20.0) / (abs(temperature - ambient) + 20.0)


class Short(PerLengthResistance):
    """The same for any length."""

    def resistance(self, xp: Any, fraction: Any, strain: Any, temperature: Any, of: Any) -> Any:
        return self.r_A + 0.0 * fraction


class Leaking(CurrentSource):
    """Never off, and cuts out at a high signal."""

    def current(self, xp: Any, drive: Any, resistance: Any) -> Any:
        return xp.where(drive < 15.0, 0.1 + drive, 0.0)


class Lying(CurrentSource):
    """Heats twice as much as its current does, and has a unit that is none."""

    unit = "amps of some kind"

    def heat(self, xp: Any, change: Any, resistance: Any) -> Any:
        found = super().heat(xp, change, resistance)
        return found._replace(mean=2.0 * found.mean)


class Shortening(Wire):
    """Gets shorter under more force, and has no heat capacity."""

    def elongation(self, xp: Any, state: Any, force: Any) -> Any:
        return -super().elongation(xp, state, force)

    def heat_capacity_total(self) -> Any:
        return 0.0

    def heat_loss(self, xp: Any, temperature: Any, environment: Any) -> Any:
        return 1.0 - super().heat_loss(xp, temperature, environment)


class Pushing(BiasSpring):
    """Pushes, and moves the wrong way."""

    def force(self, xp: Any, assembly: Any, spring: Any) -> Any:
        return spring.free - 0.01

    def position(self, xp: Any, assembly: Any, force: Any, elongation: Any) -> Any:
        return elongation + 1.0


class Stuttering(PulseWidthModulation):
    """Forgets its edges or has too many, and puts its mean too high."""

    def edges(self, duration: float) -> list[float]:
        return [duration, 0.31 * duration]

    def moments(self, begin: float, end: float) -> Any:
        found = super().moments(begin, end)
        return found._replace(mean=found.mean + 0.01)

    def value(self, time: float) -> float:
        return super().value(time) + (10.0 if 0.31 < time / 6.0 < 0.310001 else 0.0)


class Tangled(AbstractMultibody):
    """Two angles, and everything wrong."""

    def ports(self) -> tuple[str, ...]:
        return ("a", "b")

    def coordinates(self) -> Any:
        return Hand(offset=1.0, bracket=1.0, knuckle=1.0, preload=1.0).coordinates()[:2]

    def contraction(self, xp: Namespace, position: Column) -> Column:
        first, second = position
        return [first * xp.detach(first) + 0.1, second]  # a path whose slope is hidden

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (q, p), (v, w), (a, b) = motion
        grows: Scalar = q * (w * w + v * v)
        return [0.3 + p - v + a + 2.0 * b + grows, -p - w + 2.0 * a + b + grows]

    def start_forces(self, xp: Namespace) -> Column:
        return [0.0, 0.0]


class Forgetful(AntagonisticPulley):
    """Says that its joint holds less than it does."""

    def energy(self, xp: Namespace, motion: Motion) -> Any:
        found = super().energy(xp, motion)
        return found._replace(springs=0.7 * found.springs)


class Unspeaking(DeadWeight):
    """Shows its position in a unit that there is not."""

    def outputs(self) -> dict[str, Output]:
        return {"position": Output("cubit", "position of the mechanism", "x")}


class Growing(LiangRogers):
    """Has more than all of its martensite, and tells the wrong memory."""

    def fractions(self, memory: Any) -> Fractions:
        return Fractions(1.5 * memory.fraction, memory.fraction)


class Careless(LiangRogers):
    """0/0 at the finish lines."""

    def follow(self, xp: Any, move: Any, stress: Any, temperature: Any, dt: Any) -> Fractions:
        found = super().follow(xp, move, stress, temperature, dt)
        return Fractions(*(x * move.scale / move.scale for x in found))


class Hurried(LiangRogers):
    """A history rule, and yet more happens in more time."""

    def follow(self, xp: Any, move: Any, stress: Any, temperature: Any, dt: Any) -> Fractions:
        found = super().follow(xp, move, stress, temperature, dt)
        return Fractions(*(x * (1.0 - 0.01 * xp.minimum(dt, 1.0)) for x in found))


class Unclosed(LiangRogers):
    """Remembers no return point."""

    def commit(self, xp: Any, memory: Any, *move: Any) -> Any:
        return super().commit(xp, memory, *move)._replace(points=memory.points)


class Softening(LiangRogers):
    """Gets shorter under more stress."""

    def compliance(self, xp: Any, fractions: Any) -> Any:
        return -super().compliance(xp, fractions)


class Backwards(LiangRogers):
    """Says what is left of austenite for martensite."""

    def fractions(self, memory: Any) -> Fractions:
        return Fractions(1.0 - memory.fraction, 0.0)


class Unlimited(CurrentSource):
    """Does not keep its limit."""

    def current(self, xp: Any, drive: Any, resistance: Any) -> Any:
        return drive


class Loud(PulseWidthModulation):
    """Goes beyond its levels."""

    def value(self, time: float) -> float:
        return 2.0 * super().value(time)


# ---------------------------------------------------------------- surroundings


class Insulating(AbstractEnds):
    """Less than the surface loses, and less in a stronger wind."""

    def conductance(self, xp: Any, film: Any, shape: Any) -> Any:
        return 1e-4 / (1.0 + film)


class Strange(AbstractFluid):
    """Properties below zero, a jump, and no end."""

    def span(self) -> tuple[float, float]:
        return 300.0, 400.0

    def film_properties(self, xp: Any, temperature: Any) -> FluidProperties:
        jump = xp.where(temperature > 350.0, 1.0, 0.0)
        return FluidProperties(0.02, -1e-5, 0.7 + jump, 1e-3)

    def properties(self, xp: Any, temperature: Any) -> FluidProperties:
        return self.film_properties(xp, temperature)._replace(expansion=1.0 / temperature)


# ---------------------------------------------------------------- sensors


class Inattentive(CurrentSensor):
    """Lags by a share of a step, however long it is."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        felt = state[0] + 0.1 * (truth[0] - state[0])
        return self.curve(xp, felt) + self.offset + self.noise * noise, (felt,)


class Creeping(CurrentSensor):
    """Never rests."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value + dt, after


class Noisy(CurrentSensor):
    """Has a tenth more noise than it declares, which it declares in another unit."""

    noise: Number = param("mA", "standard deviation of a reading", low=0.0, default=5e-3)

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        return super().step(xp, state, truth, 1.1 * noise, dt)


class Hoarding(CurrentSensor):
    """Remembers more and more."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value, (*after, *state)


class Boundless(CurrentSensor):
    """Knows no range."""

    def digits(self, xp: Any, value: Any) -> Any:
        return value


class Coarse(CurrentSensor):
    """Rounds to other steps than it declares."""

    def digits(self, xp: Any, value: Any) -> Any:
        return super().digits(xp, 0.7 * value) / 0.7


class Dividing(CurrentSensor):
    """Divides by the time that has gone by."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        value, after = super().step(xp, state, truth, noise, dt)
        return value + 0.0 / dt, after


class Deciding(CurrentSensor):
    """Decides by a value, which a traced kernel cannot."""

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        return super().step(xp, state, truth if truth[0] > 0.1 else [0.0], noise, dt)


# ---------------------------------------------------------------- observers


class GrowingObserver(InverseModel):
    """Remembers ever more."""

    def update(self, xp: Any, memory: Any, *given: Any) -> Any:
        guess, after = super().update(xp, memory, *given)
        return guess, [*after, 0.0]


class Naive(InverseModel):
    """Believes a reading whatever it is."""

    def update(self, xp: Any, memory: Any, readings: Any, *given: Any) -> Any:
        guess, after = super().update(xp, memory, readings, *given)
        return [guess[0], readings["resistance"], *guess[2:]], after


class Restless(InverseModel):
    """Gets warmer and warmer, and decides by a value."""

    def update(self, xp: Any, memory: Any, readings: Any, *given: Any) -> Any:
        guess, after = super().update(xp, memory, readings, *given)
        return [guess[0] + (1e-3 if readings["resistance"] > 0.0 else 0.0), *guess[1:]], after


class Guessing(InverseModel):
    """Reads what is not there."""

    def reads(self) -> tuple[str, ...]:
        return ("resistance", "colour")


# ---------------------------------------------------------------- controllers


class Timed(Pid):
    """Another controller outside than on the bench, and never at rest."""

    def __call__(self, time: float, measurement: Any, memory: Any) -> tuple[float, Any]:
        signal, memory = super().__call__(time, measurement, memory)
        return signal + 1e-3 * (time > 0.1), memory


class GrowingController(Pid):
    """Remembers ever more."""

    def answer(self, xp: Any, memory: Any, *given: Any) -> tuple[Any, Any]:
        signal, after = super().answer(xp, tuple(memory)[:3], *given)
        return signal, (*memory, after[0])


class Hasty(Pid):
    """Divides by the time between samples, and has no limits."""

    def answer(self, xp: Any, memory: Any, reference: Any, readings: Any, dt: Any) -> Any:
        signal, after = super().answer(xp, memory, reference, readings, dt)
        return signal + (reference - readings[self.measured]) / dt, after


class Assuming(OnOff):
    """Does not say what it cannot read."""

    def __call__(self, time: float, measurement: Any, memory: Any) -> tuple[float, Any]:
        return self.high, memory


# ---------------------------------------------------------------- checks, supervisors, faults


class Undecided(Overheat):
    """Trips and clears at once, without a number for its alarm, and counts."""

    alarm = 0

    def look(self, xp: Any, memory: Any, *given: Any) -> CheckResult:
        return CheckResult(True, True, (*memory, 1.0))


class Sleeping(SensorLost):
    """Never trips, and decides by a value."""

    def look(self, xp: Any, memory: Any, wanted: Any, readings: Any, dt: Any) -> CheckResult:
        return CheckResult(False, bool(readings[self.reading] > 0.0), ())


class Leaky(Guard):
    """Lets a little less pass than it says, whether or not something is wrong."""

    def judge(self, xp: Any, memory: Any, *given: Any) -> Any:
        found = super().judge(xp, memory, *given)
        return found._replace(signals={n: 0.99 * u for n, u in found.signals.items()})


class Believing(Guard):
    """Makes a signal of a reading, and decides by it."""

    def judge(self, xp: Any, memory: Any, wanted: Any, readings: Any, dt: Any) -> Any:
        found = super().judge(xp, memory, wanted, readings, dt)
        more = max(readings["temperature"], 0.0)
        return found._replace(signals={n: u + 0.0 * more for n, u in found.signals.items()})


class Early(SupplySag):
    """Begins a little before its time, and never ends."""

    def active(self, xp: Any, time: Any) -> Any:
        return time >= 0.4 * self.start


class Mute(Stuck):
    """Does nothing, and decides by a value."""

    def reading(self, xp: Any, sensor: str, reading: Any, last_reading: Any, active: Any) -> Any:
        return reading if reading > 0.0 else last_reading


# ---------------------------------------------------------------- blocks and measures


class Deaf(Polynomial):
    """Has no slope by what enters it, and another text."""

    def value(self, xp: Any, theta: Any, x: Any) -> Any:
        return super().value(xp, theta, xp.detach(x)) + 0.1

    def text(self) -> str:
        return "poly7"

    def scaled(self, departure: Any, factor: float) -> Any:
        return departure


class Miscounting(Gain):
    """Says that it has a state."""

    def states(self) -> int:
        return 1


class Exploding(Polynomial):
    """Grows beyond floats, and draws without a seed."""

    def value(self, xp: Any, theta: Any, x: Any) -> Any:
        return super().value(xp, theta, x) + xp.exp(1e3 * theta[0] * theta[0])

    def drawn(self, rng: Any, duration: float, dt: float) -> Any:
        return 1e-3 * np.random.default_rng().random(len(self.numbers()))


class Drifting(TransferFunction):
    """Does not rest, and takes its structure from a record."""

    def step(self, xp: Any, theta: Any, state: Any, x: Any, dt: Any) -> Any:
        y, after = super().step(xp, theta, state, x, dt)
        return y, tuple(one + 0.01 for one in after)

    def adapt_to(self, x: Any, dt: float) -> Any:
        return self.with_parts(nb=2.0)


class Doubled(Largest):
    """With slopes twice as large, in a unit that is none."""

    def unit(self, unit: str) -> str:
        return "furlongs of some kind"

    def derivatives(self, table: Any) -> np.ndarray:
        return 2.0 * super().derivatives(table) / abs(table.values).max()

    def columns(self, system: Any) -> tuple[str, ...]:
        return (self.of,)


class Neighbourly(Largest):
    """Mixes the runs."""

    def value(self, table: Any) -> np.ndarray:
        return super().value(table) + table.values.max()


def spoil_material(**values: float) -> Material:
    """A material with other numbers, and without its words."""
    good = load_material("flexinol-90")
    numbers = {n: replace(good.values[n], value=v) for n, v in values.items()}
    return replace(good, values=good.values | numbers)


def thin_material() -> Material:
    """One of few numbers, of no source."""
    good = load_material("flexinol-90")
    few = {name: good.values[name] for name in ("density", "E_A")}
    return replace(good, limits="", values=few, law=None, sources={"x": Source("nobody1900", "")})


MODEL = builders.problem_a()


class Unsourced(AbstractStudy):
    """No words, an unknown source, no claim, and a digest with a key of its own."""

    cites = ("nobody-1900",)

    def claims(self) -> list[Claim]:
        return []

    def digest(self) -> dict[str, str]:
        return {"moral": "none"}

    def figure(self, path: Path) -> None:
        """Draw nothing."""


class Wordless(Isobaric):
    """Has no meaning."""

    meaning = ""


class Overtaken(Isobaric):
    """Its example is one of a stroke as well."""

    def make_example(self) -> list[Record]:
        (one,) = super().make_example()
        return [replace(one, columns=one.columns | {"duty": one["temperature"]}, units=one.units | {"duty": "1"})]


class Greedy(Isobaric):
    """Recognises all logs."""

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment:
        return RecognisedExperiment(self, "", "temperature", ("strain",))


class Idle(Isobaric):
    """Proposes no scenario."""

    def propose(self, experiment: Any, records: Any, assumptions: Any) -> Iterator[Proposal]:
        yield from ()


class Stubborn(Isobaric):
    """Assumes a length that is given."""

    def propose(self, experiment: Any, records: Any, assumptions: Any) -> Iterator[Proposal]:
        assumptions.sentences.append("`element.length` is assumed to be 100 mm: without effect.")
        yield from super().propose(experiment, records, assumptions)


def make_wrong_command() -> Any:
    """Return a command without help and options, in a file that imports NumPy."""

    def write_all(scenario: str) -> None:
        pass

    app = typer.Typer()
    app.command()(write_all)
    return typer.main.get_command(app)


WRONG: dict[str, list[Any]] = {
    "experiment": [Wordless(), Overtaken(), Greedy(), Idle(), Stubborn()],
    "command": [make_wrong_command()],
    "exporter": [make_wrong_command()],
    "cooling": [Falling(h=10.0), Heating(h=10.0)],
    "ends": [Insulating()],
    "fluid": [Strange()],
    "resistance": [build_example(Short)],
    "drive": [
        build_example(Leaking),
        build_example(Lying),
        CurrentSource(current_limit=0.3),
        Unlimited(current_limit=0.3),
    ],
    "element": [build_example(Shortening)],
    "mechanism": [build_example(Pushing), Tangled(), build_example(Forgetful), build_example(Unspeaking)],
    "waveform": [build_example(Stuttering), build_example(Loud)],
    "law": [
        build_example(Growing),
        build_example(Careless),
        build_example(Hurried),
        build_example(Unclosed, history="return-point"),
        build_example(Softening),
        build_example(Backwards),
        build_example(builders.PrintedFormula, history="restart"),
        build_example(LiangRogers, C_A=20e6, C_M=5e6),
    ],
    "sensor": [Inattentive(), Creeping(), Noisy(), Hoarding(), Boundless(), Coarse(), Dividing(), Deciding()],
    "observer": [cls(model=MODEL) for cls in (GrowingObserver, Naive, Restless, Guessing)],
    "controller": [build_example(cls) for cls in (Timed, GrowingController, Hasty, Assuming)],
    "check": [build_example(Undecided), build_example(Sleeping)],
    "supervisor": [build_example(Leaky), build_example(Believing)],
    "fault": [build_example(Early), build_example(Mute)],
    "block": [Deaf(), Miscounting(), Exploding(), Drifting()],
    "measure": [Doubled(), Neighbourly()],
    "study": [Unsourced()],
    "material": [spoil_material(A_s=400.0, C_A=1e12), thin_material()],
}
