"""Feed-forward by inverted models: what it follows, what it misses, and where it ends.

Sources of truth: the plant itself as its own model, the exact inverse of a sum of plays, finite
differences, and the same kernels on floats and in C.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import law_a, problem_a, wire_a

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError
from martensite.control.controllers.base import AbstractController
from martensite.control.controllers.feedforward import Feedforward
from martensite.control.controllers.inverse_play import InversePlay
from martensite.control.controllers.pid import Correction, PidLaw
from martensite.control.controllers.state_feedback import NumberedGains
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.sensors.position import PositionSensor
from martensite.control.synthesis.inverse_hysteresis import fit_rising_curve, identify_hysteresis
from martensite.identify.blocks.gain import Gain
from martensite.identify.blocks.prandtl_ishlinskii import PrandtlIshlinskii
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.estimate import Options
from martensite.identify.chains.plant import build_plant as plant_of
from martensite.identify.operators.play import PlaySum
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.physics.electrical.sources import PowerSource
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Sampled
from martensite.signals.sine import Sine
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.compiled import bind_system

PERIOD = 0.02
SINE = Sine(low=1e-3, high=6e-3, frequency=0.05, phase="low")
LIMITS = PidLaw(low=0.0, high=6.0)
PLANT = problem_a()
OTHER = PLANT.with_values({"environment.cooling.h0": 104.0, "element.latent_heat": 22e3})
"""What the model takes for problem A: stronger cooling, less latent heat."""


def feedforward(**changes) -> Feedforward:
    parts: dict[str, Any] = {"model": PLANT, "feedback": Correction(law=LIMITS), "reference": SINE}
    return Feedforward(measured="position", **(parts | changes))


def followed(controller: AbstractController, plant: AbstractSystem = PLANT, duration: float = 40.0):
    """Reference and position [m] and signal, sample by sample, in C."""
    bench = Bench(plant=plant, period=PERIOD, controllers=Controllers(drive=controller))
    samples = round(duration / PERIOD) + 1
    found = simulate(bench, {"reference": controller.reference}, duration, samples=samples, runtime="c")
    return tuple(np.array(found[name]) for name in ("reference", "position", "drive"))


def rms(apart: np.ndarray) -> float:
    """Over the last period and a half of the sine."""
    return float(np.sqrt(np.mean(apart[500:] ** 2)))


def error(controller: AbstractController, plant: AbstractSystem = PLANT) -> float:
    """Rms error over the last period and a half of the sine [m]."""
    reference, position, _ = followed(controller, plant)
    return rms(reference - position)


# ---------------------------------------------------------------- feedforward


@pytest.mark.usefixtures("c_compiler")
class TestFeedforward:
    def test_the_plant_as_its_own_model_is_followed(self):
        """Where the signal is not at a limit: cooling at the lower turn is as fast as it is."""
        reference, position, signal = followed(feedforward())
        assert rms(reference - position) < 15e-6
        free = (signal > 0.0) & (signal < 6.0)
        free[:500] = False
        inside = np.convolve(free, np.ones(100), "valid") == 100
        away = np.abs(reference - position)[99:][inside]
        assert len(away) > 900
        assert np.quantile(away, 0.98) < 5e-6

    def test_a_wrong_model_is_not_enough_and_feedback_helps(self):
        """The first line could not fail if errors of the model did not matter."""
        alone = error(feedforward(model=OTHER))
        gains = {"Kp": 1000.0, "Ki": 500.0}
        both = error(feedforward(model=OTHER, feedback=Correction(**gains, law=LIMITS)))
        assert alone > 30.0 * error(feedforward())
        assert both < 0.1 * alone
        # feedback of the same gains, beside a feed-forward that says nothing
        only = error(
            InversePlay(
                measured="position",
                reference=SINE,
                knots=(0.0, 1e-6),
                outputs=(-1.0, 1.0),
                feedback=Correction(**gains, law=LIMITS),
            )
        )
        assert both < 0.8 * only


def test_derivatives_go_through_the_inversion():
    """Slopes of the signal by the reference and by the model's state, against differences."""
    controller, seen = feedforward(), {"position": 0.0}
    bench = Bench(plant=PLANT, period=PERIOD, controllers=Controllers(drive=controller))
    functions, size = bind_system(bench)
    state = functions["init"](1e-4)
    for k in range(150):
        state = functions["step"](*state, 1e-4 + 1e-5 * k, PERIOD)[:size]
    memory = list(state[-len(controller.rest(floats, 0.0, seen)) :])
    assert 0.5 < controller.answer(floats, memory, 1.6e-3, seen, PERIOD)[0] < 5.5
    warm = int(np.argmin(np.abs(np.array(memory) - 345.0)))

    def answered(xp: Any, shift: Any) -> Any:
        moved = [*memory[:warm], memory[warm] + shift, *memory[warm + 1 :]]
        return controller.answer(xp, moved, 1.6e-3 + 1e-5 * shift, seen, PERIOD)[0]

    _, slope = value_and_slope(floats, answered, 0.0)
    step = 1e-5
    expected = (answered(floats, step) - answered(floats, -step)) / (2.0 * step)
    assert abs(expected) > 1e-3
    assert slope == pytest.approx(expected, rel=1e-4)


def test_out_of_reach_it_answers_with_the_nearest_limit():
    controller = feedforward()
    for level, limit in ((1.0, 6.0), (-1.0, 0.0)):
        memory = controller.rest(floats, level, {"position": 0.0})
        signal, _ = controller.answer(floats, memory, level, {"position": 0.0}, 0.0)
        assert signal == limit


@pytest.mark.parametrize(
    ("sense", "level", "signal"),
    [("falling", 0.5, 6.0), ("rising", 0.5, 0.0), ("falling", 1.0, 0.0), ("falling", 1.5, 0.0)],
)
def test_a_model_that_does_not_answer_yet_is_driven_the_right_way(sense, level, signal):
    """A cold wire: its fraction is 1 and stays so for longer than the model looks ahead."""
    controller = Feedforward(
        model=PLANT,
        measured="martensite_fraction",
        reference=Constant(level=level),
        sense=sense,
        feedback=Correction(law=LIMITS),
    )
    found, _ = controller(0.0, {"martensite_fraction": 1.0}, controller.init())
    assert found == signal


def test_as_a_drive_it_answers_in_every_sample():
    controller = feedforward(reference=Constant(level=3e-3))
    memory, signals = controller.init(), []
    for k in range(3):
        signal, memory = controller(k * PERIOD, {"position": 0.0}, memory)
        signals.append(signal)
    assert signals == [6.0, 6.0, 6.0]


def test_models_that_do_not_fit_are_refused():
    with pytest.raises(ParameterError, match=r"no output `positon`.*`position`"):
        feedforward(output="positon")
    watched = Bench(plant=PLANT, period=PERIOD, sensors=Sensors(position=MountedSensor(sensor=PositionSensor())))
    with pytest.raises(ParameterError, match="must have one drive, but has drive, noise"):
        feedforward(model=watched)
    with pytest.raises(ParameterError, match="`ahead` of `feedforward` must be a whole number"):
        feedforward(ahead=0)


# ---------------------------------------------------------------- inverse of plays

SUM = PlaySum((0.1, 0.3), (0.5, 0.3, 0.2))


@cache
def played() -> Chain:
    """A model that is a sum of plays and a line."""
    block = PrandtlIshlinskii(plays=2.0, thresholds="free", weights="free", low=0.0, high=1.0)
    steps = np.log(np.array([0.1, 0.2]) / (0.25 / 2.0))
    line = Gain(low=0.0, high=1.0)
    theta = np.concatenate([[0.3, 0.2], steps, line.line(2.0, 0.5)])
    return Chain((block, line), theta, PERIOD, ("drive",), ("position",), {"drive": "1", "position": "m"})


WAY = Table(times=(0.0, 1.0, 1.6, 2.0, 3.0, 4.0), values=(0.5, 1.9, 1.0, 1.4, 0.9, 2.0))


def inverse(**changes) -> InversePlay:
    parts: dict[str, Any] = {"thresholds": SUM.thresholds, "weights": SUM.weights}
    parts |= {"knots": (0.0, 1.0), "outputs": (0.5, 2.5)}
    return InversePlay(measured="position", reference=WAY, **(parts | changes))


def tracked(controller: AbstractController, runtime: str = "floats") -> np.ndarray:
    """Error of what follows [m], a sample later, for a model answers under the signal before."""
    bench = Bench(plant=plant_of(played()), period=PERIOD, controllers=Controllers(drive=controller))
    found = simulate(bench, {"reference": WAY}, 4.0, samples=201, runtime=runtime)
    return np.array(found["reference"]) - np.array(found["position"])


def test_an_inverse_makes_a_line_of_plays():
    assert np.abs(tracked(inverse())).max() < 1e-12
    assert np.abs(tracked(inverse(thresholds=(), weights=(1.0,)))).max() > 0.1


def test_a_curve_is_inverted_between_its_knots():
    controller = inverse(knots=(0.0, 0.5, 1.0), outputs=(1.0, 0.0, -3.0))
    for level, output in ((-0.2, 1.4), (0.25, 0.5), (0.75, -1.5), (1.2, -4.2)):
        assert controller._level(floats, output) == pytest.approx(level, abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"thresholds": (0.3, 0.1)}, "need rising `thresholds`"),
        ({"weights": (0.5, 0.3)}, "one of the `weights` more"),
        ({"weights": (0.5, -0.6, 0.2)}, "sums a_0"),
        ({"outputs": (0.5, 0.5)}, "all rise or all fall"),
        ({"knots": (0.0, 0.5, 1.0)}, "as many `outputs`"),
        ({"knots": 3.0}, "must be a list of numbers"),
    ],
)
def test_what_has_no_inverse_is_refused(changes, sentence):
    with pytest.raises(ParameterError, match=sentence):
        inverse(**changes)


def test_an_identified_loop_is_that_which_made_it():
    chain = played()
    signals = np.concatenate([np.linspace(a, b, 60) for a, b in ((0, 1), (1, 0.2), (0.2, 0.8), (0.8, 0.0))])
    record = Sampled("slow", PERIOD, signals, chain.simulate(signals), ("drive",), ("position",))
    found = identify_hysteresis(record, plays=5, knots=3, options=Options(starts=1, refined=1))
    made = found.simulate(signals)
    assert np.abs(made - record.outputs[:, 0]).max() < 0.02 * np.ptp(made)
    error_of = tracked(found.controller(measured="position", reference=WAY))
    assert np.abs(error_of).max() < 0.05
    with pytest.raises(InputError, match="one input and one output"):
        identify_hysteresis(Sampled("two", 1.0, np.zeros((9, 2)), signals[:9], ("a", "b"), ("y",)))


def test_a_rising_curve_never_turns_back():
    knots, levels = np.array([0.0, 1.0, 2.0, 3.0]), np.linspace(0.0, 3.0, 31)
    exact = fit_rising_curve(knots, levels, np.interp(levels, knots, [1.0, 2.0, 5.0, 6.0]))
    assert exact == pytest.approx([1.0, 2.0, 5.0, 6.0])
    bent = fit_rising_curve(knots, levels, -np.interp(levels, knots, [0.0, 2.0, 1.0, 6.0]))
    assert np.all(np.diff(bent) < 0.0)


# ---------------------------------------------------------------- a wire, slowly

SLOW = 300.0
LEVELS = (0.0, 1.0, 0.3, 0.8, 0.4, 0.9, 0.2, 0.7, 0.3)
BROAD = problem_a(element=wire_a(law_a(A_s=323.0, A_f=363.0, M_s=348.0, M_f=308.0)), source=PowerSource())
"""A wire whose branches are broader than its loop."""


@pytest.mark.usefixtures("c_compiler")
def test_the_loop_of_a_wire_becomes_nearly_a_line():
    """Deviations from the best line: a third of what the curve alone leaves, if it is slow."""
    way = Table(times=tuple(SLOW * k for k in range(9)), values=tuple(2.6 * u for u in LEVELS))
    run = simulate(BROAD, way, 8 * SLOW, step=0.2, samples=801, runtime="c")
    u, y = np.array(run["drive"]), np.array(run["position"])
    record = Sampled("slow", 3.0, u, y, ("power",), ("position",))
    found = identify_hysteresis(record, plays=6, knots=6, options=Options(starts=1, refined=1))
    curve = fit_rising_curve(np.array(found.knots), u, y)
    bare = InversePlay(measured="position", reference=Constant(level=0.0), knots=found.knots, outputs=tuple(curve))

    def bent(controller: InversePlay, leg: float) -> float:
        times = tuple(leg * k for k in range(6))
        ways = Table(times=times, values=(5e-4, 9e-3, 2e-3, 7e-3, 1e-3, 5e-3))
        whole = controller.with_parts(reference=ways, feedback=Correction(law=PidLaw(low=0.0, high=8.0)))
        bench = Bench(plant=BROAD, period=0.2, controllers=Controllers(drive=whole))
        run = simulate(bench, {"reference": ways}, 5 * leg, samples=501, runtime="c")
        r, y = (np.array(run[name])[100:] for name in ("reference", "position"))
        return float(np.std(y - np.polyval(np.polyfit(r, y, 1), r)))

    inverted = found.controller(measured="position", reference=Constant(level=0.0))
    assert bent(inverted, SLOW) < 0.4 * bent(bare, SLOW)
    assert bent(inverted, SLOW) < 0.25e-3
    assert bent(inverted, 10.0) > 2.0 * bent(inverted, SLOW)


# ---------------------------------------------------------------- rows


def test_a_row_is_as_many_parameters_as_it_has_numbers():
    row = NumberedGains.of((1.0, 2.0))
    assert [leaf.path for leaf in row.leaves()] == ["n1", "n2"]
    assert row.with_values({"n2": 5.0}).numbers == (1.0, 5.0)
    assert row.layout() == (2,)
    with pytest.raises(ParameterError, match="Number 2 of a row is `n2`, not `n3`"):
        NumberedGains(n1=1.0, n3=2.0)
