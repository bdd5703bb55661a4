"""Hysteresis of plays: against turning points, without a clock, and inverted."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from everett import Turning, of_plays
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from martensite.base.errors import InputError, ParameterError
from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.blocks.generalised_prandtl_ishlinskii import GeneralisedPrandtlIshlinskii
from martensite.identify.blocks.play import Play
from martensite.identify.blocks.prandtl_ishlinskii import PrandtlIshlinskii
from martensite.identify.blocks.preisach import Preisach
from martensite.identify.chains.chain_text import parse_block
from martensite.identify.operators.play import PlaySum
from martensite.kernels import floats

PI = PrandtlIshlinskii(plays=4.0)
PREISACH = Preisach(levels=3.0, knots=5.0)
GENERALISED = GeneralisedPrandtlIshlinskii(plays=3.0, knots=5.0)
RISING: list[AbstractBlock] = [PI, PrandtlIshlinskii(plays=3.0, thresholds="free"), Play(), PREISACH, GENERALISED]
"""Blocks whose output rises with their input."""
ANY: list[AbstractBlock] = [
    *RISING,
    PrandtlIshlinskii(plays=3.0, weights="free", thresholds="even"),
    Preisach(levels=2.0, knots=4.0, slopes="free"),
]
TURNS = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=12)
SWEEP = [0.0, 1.5, -1.0]
"""From rest to where every play has been pushed down."""
few = hypothesis_settings(max_examples=25)


def named(blocks: Sequence[AbstractBlock]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("block", blocks, ids=[b.text() for b in blocks])


def drawn(block: AbstractBlock, seed: int = 1) -> list[float]:
    return block.sample_parameters(np.random.default_rng(seed), 10.0, 0.1).tolist()


def run(block: AbstractBlock, inputs: Any, seed: int = 1) -> np.ndarray:
    """Outputs of the bare kernel, from rest."""
    theta = drawn(block, seed)
    state = block.rest(floats, theta, [inputs[0]], 1.0)
    made: list[float] = []
    for x in inputs:
        (y,), state = block.step(floats, theta, state, [x], 1.0)
        made.append(y)
    return np.array(made)


def swept(turns: Sequence[float], steps: int) -> np.ndarray:
    """Ways between turning points in equal steps."""
    places = np.arange((len(turns) - 1) * steps + 1) / steps
    return np.interp(places, np.arange(len(turns)), turns)


def line_of(ends: np.ndarray, slopes: np.ndarray) -> Callable[[float], float]:
    """A piecewise linear curve whose end lines go on beyond."""
    knots = np.concatenate([[ends[0] - 9.0], ends, [ends[-1] + 9.0]])
    rises = np.concatenate([slopes[:1], slopes, slopes[-1:]]) * np.diff(knots)
    values = np.concatenate([[0.0], np.cumsum(rises)])
    return lambda s: float(np.interp(s, knots, values))


def by_turning_points(inputs: np.ndarray, forgets: bool = True, seed: int = 1) -> np.ndarray:
    """What the classical form makes of the weights of `PREISACH`, after a sweep through all."""
    theta = np.array(drawn(PREISACH, seed))
    radii = 2.0 * PREISACH.reach * np.arange(4) / 3.0
    sizes = np.exp(np.concatenate([[0.0], theta[2:]]))
    slopes = theta[1] * 4.0 * sizes.reshape(4, 4) / sizes.sum()
    curves = [line_of(np.linspace(r - 1.0, 1.0 - r, 5), own) for r, own in zip(radii, slopes, strict=True)]
    first = run(PREISACH, SWEEP, seed)[-1]
    return Turning(of_plays(list(radii), curves), SWEEP[-1], first, forgets).simulate(inputs.tolist())


def after_sweep(inputs: np.ndarray) -> np.ndarray:
    return run(PREISACH, [*SWEEP, *inputs])[len(SWEEP) :]


NESTED = swept([-1.0, 0.9, -0.6, 0.5, -0.3, 0.2, -0.8, 0.95, -0.9, 1.0, 0.3, 0.6, -0.2], 7)


class TestPreisach:
    def test_plays_are_the_classical_form(self):
        assert np.abs(after_sweep(NESTED) - by_turning_points(NESTED)).max() < 1e-12

    def test_one_that_forgets_nothing_is_another(self):
        assert np.abs(after_sweep(NESTED) - by_turning_points(NESTED, False)).max() > 1e-2

    @given(TURNS)
    @few
    def test_they_are_so_for_any_turning_points(self, turns: list[float]):
        inputs = np.array(turns)
        assert np.abs(after_sweep(inputs) - by_turning_points(inputs)).max() < 1e-12

    def test_many_levels_tend_to_a_smooth_density(self):
        # weight 1 per area of the half plane of (a, b): relays up to half width 0.5
        def everett(a: float, b: float) -> float:
            return 0.5 * (a - b) ** 2 if a - b <= 1.0 else (a - b) - 0.5

        turns = [-1.0, -0.1, -0.8, 0.3, -0.4, -0.2]
        meant = Turning(everett, -1.0, 0.0).simulate(turns)
        worst: list[float] = []
        for levels in (8, 16, 32):
            r = 0.5 * (np.arange(levels) + 0.5) / levels
            plays = PlaySum(tuple(r), (0.0, *np.full(levels, 1.0 / levels)))
            found = plays.simulate(turns, -1.0 + r)
            worst.append(float(np.abs(found - found[0] - meant).max()))
        assert worst[2] < 1e-3
        assert worst[0] / worst[1] > 3.5
        assert worst[1] / worst[2] > 3.5

    def test_slopes_may_fall(self):
        block = PREISACH.with_parts(low=20.0, high=90.0)
        theta = block.line(-2.0, 300.0).tolist()
        (y,), _ = block.step(floats, theta, block.rest(floats, theta, [50.0], 1.0), [50.0], 1.0)
        assert y == pytest.approx(200.0, rel=1e-12)


@named(ANY)
class TestHysteresis:
    @given(turns=TURNS, steps=st.integers(1, 9))
    @few
    def test_only_turning_points_count(self, block: AbstractBlock, turns: list[float], steps: int):
        coarse, fine = run(block, turns), run(block, swept(turns, steps))
        assert np.abs(coarse - fine[::steps]).max() < 1e-12

    def test_inner_loops_are_wiped_out(self, block: AbstractBlock):
        outer = [-1.0, 0.9, -0.7, 0.8, 1.0, -1.0]
        inner = [-1.0, 0.9, -0.7, 0.6, -0.5, 0.4, -0.1, 0.8, 1.0, -1.0]
        assert run(block, inner)[-3:] == pytest.approx(run(block, outer)[-3:], abs=1e-12)

    def test_loops_between_two_inputs_are_congruent(self, block: AbstractBlock):
        loops = swept([-0.3, 0.4, -0.3], 9)
        shapes: list[np.ndarray] = []
        for past in ([-1.0, -0.3], [-1.0, 1.0, -0.3], [0.9, -0.6, 0.7, -0.3]):
            closed = run(block, [*past, 0.4, -0.3, *loops])[len(past) + 2 :]
            shapes.append(closed - closed[0])
        assert np.abs(np.array(shapes) - shapes[0]).max() < 1e-12

    def test_there_is_a_loop(self, block: AbstractBlock):
        up, down = run(block, [-1.0, 1.0, -1.0, 0.0])[-1], run(block, [-1.0, 1.0, 0.0])[-1]
        assert abs(up - down) > 1e-2


class TestMonotone:
    @named(RISING)
    @given(turns=TURNS)
    @few
    def test_outputs_go_with_the_input(self, block: AbstractBlock, turns: list[float]):
        for seed in (1, 2):
            theta = drawn(block, seed)
            if "rise" in block.numbers():
                theta[block.numbers().index("rise")] = 1.5
            state = block.rest(floats, theta, turns[:1], 1.0)
            made: list[float] = []
            for x in turns:
                (y,), state = block.step(floats, theta, state, [x], 1.0)
                made.append(y)
            assert (np.diff(made) * np.sign(np.diff(turns)) >= -1e-14).all()

    def test_free_weights_need_not(self):
        block = PrandtlIshlinskii(plays=1.0, weights="free", thresholds="even")
        state = block.rest(floats, [2.0], [-1.0], 1.0)
        (y,), state = block.step(floats, [2.0], state, [-1.0], 1.0)
        assert block.step(floats, [2.0], state, [-0.9], 1.0)[0][0] < y


class TestGeneralised:
    def test_each_way_has_its_curve(self):
        block = GeneralisedPrandtlIshlinskii(plays=1.0, knots=4.0)
        above, below = [0.0, 0.5, 0.8, 1.0], [0.0, 0.1, 0.6, 1.0]
        shares = np.array([0.5, 0.3 / 0.5, 0.1 / 0.5, 0.5 / 0.7])
        theta = [0.0, 1.0, *np.log(shares / (1.0 - shares))]
        x = np.linspace(-1.0, 1.0, 13)
        state = block.rest(floats, theta, [-1.0], 1.0)
        made: list[float] = []
        for value in [*x, *x[::-1]]:
            (y,), state = block.step(floats, theta, state, [float(value)], 1.0)
            made.append(y)
        knots = np.linspace(-1.0, 1.0, 4)
        for values, found in ((below, made[:13]), (above, made[:12:-1])):
            meant = 2.0 * np.interp(x, knots, values) - 1.0
            assert found == pytest.approx(meant.tolist(), abs=1e-13)

    def test_its_curves_never_cross(self):
        block = GeneralisedPrandtlIshlinskii(plays=1.0, knots=6.0)
        rng = np.random.default_rng(0)
        for _ in range(20):
            logits = rng.normal(0.0, 3.0, 8).tolist()
            found = np.array([block.curves(floats, logits, r) for r in np.linspace(-1, 1, 41)])
            assert (found[:, 0] <= found[:, 1] + 1e-14).all()
            assert (np.diff(found, axis=0) >= -1e-14).all()


class TestInverse:
    PLAYS = PlaySum((0.1, 0.25, 0.6), (0.4, 0.2, 0.3, 0.1))

    def test_it_gives_the_input_back(self):
        x = swept([0.0, 1.0, -0.7, 0.6, -0.2, 0.3, -1.0, 0.9], 25)
        assert np.abs(self.PLAYS.inverse().simulate(self.PLAYS.simulate(x)) - x).max() < 1e-12

    def test_fed_forward_it_makes_the_output_the_command(self):
        command = np.sin(np.arange(300) * 0.07) + 0.4 * np.sin(np.arange(300) * 0.31)
        inputs = self.PLAYS.inverse().simulate(command)
        assert np.abs(self.PLAYS.simulate(inputs) - command).max() < 1e-12

    @given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), TURNS)
    @few
    def test_from_any_state(self, away: list[float], turns: list[float]):
        r = np.array(self.PLAYS.thresholds)
        state = turns[0] + np.cumsum(np.diff(r, prepend=0.0) * away)
        y = self.PLAYS.simulate(turns, state)
        found = self.PLAYS.inverse().simulate(y, self.PLAYS.matching(state))
        assert np.abs(found - turns).max() < 1e-12

    def test_twice_it_is_the_operator(self):
        twice = self.PLAYS.inverse().inverse()
        assert twice.thresholds == pytest.approx(self.PLAYS.thresholds, rel=1e-12)
        assert twice.weights == pytest.approx(self.PLAYS.weights, rel=1e-12)

    @named([b for b in ANY if isinstance(b, PrandtlIshlinskii)])
    def test_the_operator_of_a_block_is_the_block(self, block: PrandtlIshlinskii):
        block = block.with_parts(low=20.0, high=80.0)
        x = swept([25.0, 75.0, 33.0, 60.0, 21.0], 10)
        assert block.operator(np.array(drawn(block))).simulate(x.tolist()) == pytest.approx(run(block, x), rel=1e-13)

    def test_with_positive_weights_there_always_is_one(self):
        for seed in range(5):
            theta = np.random.default_rng(seed).uniform(-12.0, 12.0, len(PI.numbers()))
            PI.operator(theta).inverse()

    def test_others_are_refused(self):
        with pytest.raises(ParameterError, match="no inverse"):
            PlaySum((0.1, 0.2), (0.5, -0.7, 1.2)).inverse()
        with pytest.raises(ParameterError, match="rising thresholds"):
            PlaySum((0.2, 0.1), (0.5, 0.2, 0.3))
        with pytest.raises(ParameterError, match="one weight more"):
            PlaySum((0.1, 0.2), (0.5, 0.5))


class TestNumbers:
    def test_thresholds_are_in_the_unit_of_the_input(self):
        block = PrandtlIshlinskii(plays=4.0, thresholds="even", reach=0.2, low=20.0, high=120.0)
        plays = block.operator(block.start())
        assert plays.thresholds == pytest.approx([5.0, 10.0, 15.0, 20.0])
        assert plays.weights == pytest.approx([0.5, 0.125, 0.125, 0.125, 0.125])
        shown = {name: value for name, value, _ in block.describe_numbers(block.start())}
        assert shown["threshold 2"] == pytest.approx(10.0)
        assert shown["weight of the input"] == pytest.approx(0.5)

    def test_a_free_reach_scales_them(self):
        block = PrandtlIshlinskii(plays=2.0, reach=0.2, low=0.0, high=10.0)
        theta = block.start()
        theta[-1] = np.log(1.5)
        assert block.operator(theta).thresholds == pytest.approx([1.5, 3.0])

    def test_free_steps_add_up(self):
        block = PrandtlIshlinskii(plays=2.0, reach=0.2, low=0.0, high=10.0, thresholds="free")
        theta = block.start()
        theta[-1] = np.log(3.0)
        assert block.operator(theta).thresholds == pytest.approx([1.0, 4.0])

    def test_a_play_has_its_radius(self):
        block = Play(low=0.0, high=10.0)
        assert block.describe_numbers(np.log([0.3])) == [("radius", pytest.approx(1.5), "1")]

    def test_words_stand_behind_numbers(self):
        assert parse_block("pi(3,free,even)") == PrandtlIshlinskii(plays=3.0, weights="free", thresholds="even")
        assert parse_block("pi12") == PrandtlIshlinskii()
        assert parse_block("preisach(4,6)") == Preisach(levels=4.0, knots=6.0)

    @pytest.mark.parametrize("text", ["pi(2.5)", "preisach(2,3.5)", "gpi(1.5,4)"])
    def test_numbers_are_whole(self, text: str):
        with pytest.raises(InputError, match="whole number"):
            parse_block(text)
