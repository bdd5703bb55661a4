"""Static blocks compute what their formulas say.

Source of truth: the same formulas in NumPy and SciPy, on whole arrays.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from martensite.base.errors import InputError, MartensiteError, ParameterError
from martensite.identify.blocks.gain import Gain, UnitGain
from martensite.identify.blocks.networks import SigmoidNetwork, TanhNetwork, WaveletNetwork
from martensite.identify.blocks.piecewise_linear import PiecewiseLinear
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.saturation import DeadZone, Saturation
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.identify.blocks.spline import Spline
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.chain_text import parse_block, parse_chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Sampled

RANGE: dict[str, Any] = {"low": -2.0, "high": 6.0}
X = np.linspace(-5.0, 9.0, 57)
R = (X - 2.0) / 4.0
RNG = np.random.default_rng(8)


def outputs(block, theta, at=X):
    """Outputs at many inputs, on plain floats."""
    return np.array([block.value(floats, list(theta), float(x)) for x in at])


def parsed(text: str) -> Any:
    """The blocks of a chain, of whatever kind they are."""
    return parse_chain(text)


def shown(block, theta):
    """What people read, by name."""
    return {name: value for name, value, _ in block.describe_numbers(np.array(theta))}


class TestPiecewiseLinear:
    BLOCK = PiecewiseLinear(knots=6.0, **RANGE)
    THETA = RNG.normal(size=10)

    def test_it_is_interpolation_and_goes_on_at_the_ends(self):
        rows = shown(self.BLOCK, self.THETA)
        knots = np.array([rows[f"knot{i}"] for i in range(1, 7)])
        values = np.concatenate([[0.0], self.THETA[1:6]]) + self.THETA[0]
        assert (knots[0], knots[-1]) == (-2.0, pytest.approx(6.0))
        meant = np.interp(X, knots, values)
        slopes = np.diff(values) / np.diff(knots)
        meant += slopes[0] * np.minimum(X - knots[0], 0.0)
        meant += slopes[-1] * np.maximum(X - knots[-1], 0.0)
        assert outputs(self.BLOCK, self.THETA) == pytest.approx(meant, abs=1e-12)
        assert [rows[f"output{i}"] for i in range(1, 7)] == pytest.approx(values)

    @pytest.mark.parametrize("seed", range(4))
    def test_knots_are_sorted_whatever_the_numbers_are(self, seed):
        theta = np.random.default_rng(seed).uniform(-500.0, 500.0, 10)
        rows = shown(self.BLOCK, theta)
        gaps = np.diff([rows[f"knot{i}"] for i in range(1, 7)])
        assert gaps.sum() == pytest.approx(8.0)
        assert gaps.min() >= 0.02 * 8.0 / 5.0 * (1.0 - 1e-9)

    def test_knots_that_are_fixed_are_even(self):
        block = PiecewiseLinear(knots=5.0, inner="fixed", **RANGE)
        assert len(block.numbers()) == 5
        rows = shown(block, np.arange(5.0))
        assert [rows[f"knot{i}"] for i in range(1, 6)] == pytest.approx([-2, 0, 2, 4, 6])

    def test_without_offset_it_has_one_number_less_and_passes_zero(self):
        block = self.BLOCK.with_parts(offset="no")
        with_it = outputs(self.BLOCK, [0.0, *self.THETA[1:]])
        at_zero = outputs(self.BLOCK, [0.0, *self.THETA[1:]], np.zeros(1))
        assert outputs(block, self.THETA[1:]) == pytest.approx(with_it - at_zero, abs=1e-12)


class TestLimits:
    @pytest.mark.parametrize("gain", ["free", "one"])
    def test_saturation(self, gain):
        block = Saturation(gain=gain, **RANGE)
        theta = [0.3, 1.4, 0.2, np.log(0.5)] if gain == "free" else [0.3, 0.2, np.log(0.5)]
        rise = 1.4 if gain == "free" else 4.0
        assert outputs(block, theta) == pytest.approx(0.3 + rise * np.clip(R, -0.3, 0.7))
        assert shown(block, theta)["lower limit"] == pytest.approx(2.0 - 4.0 * 0.3)
        assert shown(block, theta)["upper limit"] == pytest.approx(2.0 + 4.0 * 0.7)
        assert shown(block, theta)["gain"] == pytest.approx(rise / 4.0)
        assert shown(block, theta)["output at zero"] == pytest.approx(0.3 - rise * 0.3)

    def test_dead_zone(self):
        theta = [0.3, 1.4, 0.2, np.log(0.5)]
        zone = np.where(R > 0.7, R - 0.7, np.where(R < -0.3, R + 0.3, 0.0))
        assert outputs(DeadZone(**RANGE), theta) == pytest.approx(0.3 + 1.4 * zone)

    @pytest.mark.parametrize("cls", [Saturation, DeadZone])
    def test_limits_never_change_places(self, cls):
        for log_half in (-1e300, -40.0, 40.0, 1e300):
            rows = shown(cls(**RANGE), [0.0, 1.0, 0.5, log_half])
            assert rows["lower limit"] < rows["upper limit"]

    @pytest.mark.parametrize("cls", [Saturation, DeadZone])
    def test_it_starts_where_a_fit_can_move_both_limits(self, cls):
        block = cls(**RANGE)
        slopes = ChainEngine([block], 1.0, compiled=False).jacobian(block.start(), X[:, None])[1]
        assert (np.abs(slopes[:, 0]).max(axis=0) > 0.0).all()


def test_a_fit_finds_limits():
    """Those of a dead zone before a lag, and of a saturation after it, from noisy outputs."""
    u = np.repeat(RNG.uniform(-2.0, 3.0, 30), 20)
    w = np.where(u > 0.5, u - 0.5, np.where(u < -0.7, u + 0.7, 0.0))
    x = lfilter([0.0, 0.1], [1.0, -0.9], w)
    y = 2.0 * np.clip(x, -0.6, 1.2) + 0.3 + 0.01 * RNG.normal(size=len(u))
    record = Sampled("made up", 0.1, u, y, ("u",), ("y",))
    found = estimate_chain(
        "deadzone | oe(1,1,1) | sat", record, Options(starts=6, refined=1, iterations=60, start="zero")
    ).chain
    zone, _, limits = (shown(block, theta) for block, theta in zip(found.blocks, found.split(), strict=True))
    assert [zone["lower limit"], zone["upper limit"]] == pytest.approx([-0.7, 0.5], abs=0.02)
    assert [limits["lower limit"], limits["upper limit"]] == pytest.approx([-0.6, 1.2], abs=0.01)
    assert (limits["gain"], limits["output at zero"]) == pytest.approx((2.0, 0.3), abs=0.02)


class TestNetworks:
    THETA = np.concatenate([[0.7, 1.3], RNG.normal(size=3), RNG.normal(size=3), RNG.normal(size=3)])

    def meant(self, shape, argument):
        """One page of NumPy."""
        a, first, second = self.THETA[2:5], self.THETA[5:8], self.THETA[8:]
        units = sum(a[i] * shape(argument(first[i], second[i])) for i in range(3))
        return 0.7 + 1.3 * R + units

    @pytest.mark.parametrize(
        ("cls", "shape", "argument"),
        [
            (SigmoidNetwork, lambda q: 1 / (1 + np.exp(-q)), lambda b, c: np.exp(b) * (R - c)),
            (WaveletNetwork, lambda q: (1 - q**2) * np.exp(-(q**2) / 2), lambda b, c: np.exp(b) * (R - c)),
            (TanhNetwork, np.tanh, lambda w, v: w * R + v),
        ],
    )
    def test_they_are_their_formulas(self, cls, shape, argument):
        found = outputs(cls(units=3.0, **RANGE), self.THETA)
        assert found == pytest.approx(self.meant(shape, argument), abs=1e-13)

    def test_wavelets_start_on_a_dyadic_frame(self):
        log_b, centres = WaveletNetwork(units=7.0).frame()
        assert centres == pytest.approx([0.0, -0.5, 0.5, -0.75, -0.25, 0.25, 0.75])
        assert np.exp(log_b) == pytest.approx(1.25 * np.array([1, 2, 2, 4, 4, 4, 4]))

    def test_a_level_that_is_not_full_is_spread_over_the_range(self):
        log_b, centres = WaveletNetwork(units=88.0).frame()
        last = centres[63:]
        assert np.exp(log_b[63:]) == pytest.approx(1.25 * 64)
        assert len(set(last)) == 25
        assert abs(last.mean()) < 0.02
        assert np.diff(last).max() <= 2.0 * 3.0 / 64.0 + 1e-12

    def test_88_wavelets(self):
        block = WaveletNetwork(units=88.0, **RANGE)
        assert len(block.numbers()) == 2 + 3 * 88
        theta = block.sample_parameters(np.random.default_rng(0), 10.0, 0.1)
        engine = ChainEngine([block], 0.1, compiled=False)
        y, slopes = engine.jacobian(theta, X[:, None])
        a, b, c = theta[2:90], np.exp(theta[90:178]), theta[178:]
        q = b * (R[:, None] - c)
        bell = np.exp(-(q**2) / 2)
        assert y[:, 0] == pytest.approx(theta[0] + theta[1] * R + ((1 - q**2) * bell) @ a)
        assert slopes[:, 0, 2:90] == pytest.approx((1 - q**2) * bell, abs=1e-12)
        assert slopes[:, 0, 90:178] == pytest.approx(a * (q**2 - 3) * q * q * bell, abs=1e-11)
        assert slopes[:, 0, 178:] == pytest.approx(-a * b * (q**2 - 3) * q * bell, abs=1e-10)

    def test_sigmoids_start_evenly_as_steep_as_their_number_asks(self):
        log_b, centres = SigmoidNetwork(units=4.0).frame()
        assert centres == pytest.approx([-0.75, -0.25, 0.25, 0.75])
        assert np.exp(log_b) == pytest.approx(1.5 * 5.0 / 2.0)

    def test_a_departure_is_scaled_in_height_and_not_in_place(self):
        block = SigmoidNetwork(units=3.0)
        scaled = block.scale_departure(np.ones(11), -2.0)
        assert scaled.tolist() == [-2.0] * 5 + [1.0] * 6


class TestSpline:
    def test_it_is_the_natural_cubic_spline_through_its_knots(self):
        block = Spline(knots=7.0, **RANGE)
        theta = RNG.normal(size=7)
        rows = shown(block, theta)
        knots = [rows[f"knot{i}"] for i in range(1, 8)]
        meant = CubicSpline(knots, [rows[f"output{i}"] for i in range(1, 8)], bc_type="natural")
        inside = (X >= -2.0) & (X <= 6.0)
        assert outputs(block, theta)[inside] == pytest.approx(meant(X[inside]), abs=1e-12)
        above = X > 6.0
        line = meant(6.0) + meant(6.0, 1) * (X[above] - 6.0)
        assert outputs(block, theta)[above] == pytest.approx(line, abs=1e-12)

    def test_derivatives_hold_at_the_ends_of_the_range(self):
        block = Spline(knots=4.0, **RANGE)
        ends = np.array([[-2.0], [6.0]])
        slopes = ChainEngine([Gain(), block], 1.0, compiled=False).jacobian(
            np.concatenate([Gain().line(1.0, 0.0), block.line(3.0, 1.0)]), ends
        )[1]
        assert slopes[:, 0, 0] == pytest.approx([3.0, 3.0])


class TestGainAndUnit:
    def test_gain(self):
        block = Gain(**RANGE)
        assert outputs(block, block.line(-1.5, 0.25)) == pytest.approx(0.25 - 1.5 * X)
        assert shown(block, block.line(-1.5, 0.25)) == {"gain": -1.5, "output at zero": 0.25}
        free = block.with_parts(offset="no")
        assert outputs(free, free.line(-1.5, 0.0)) == pytest.approx(-1.5 * X)

    def test_unit_gain(self):
        assert UnitGain().step(floats, [], [], [3.7], 0.1) == ((3.7,), ())


class TestSideBySide:
    BLOCKS = (Polynomial(degree=2.0), TransferFunction(nb=2.0, nf=2.0), UnitGain())

    def test_every_channel_is_that_of_its_block(self):
        block = SideBySide(blocks=self.BLOCKS)
        u = RNG.normal(size=(20, 3))
        block = block.adapt_to(u, 0.1)
        polynomial: Any = block.blocks[0]
        assert polynomial.low == u[:, 0].min()
        theta = block.sample_parameters(np.random.default_rng(1), 2.0, 0.1)
        found = ChainEngine([block], 0.1, compiled=False).simulate(theta, u)
        parts = block.split(theta, lambda child: len(child.numbers()))
        for i, (child, own) in enumerate(parts):
            alone = ChainEngine([child], 0.1, compiled=False).simulate(own, u[:, i : i + 1])
            assert np.array_equal(found[:, i], alone[:, 0])

    def test_names_have_the_place_of_their_block(self):
        block = SideBySide(blocks=self.BLOCKS)
        assert block.numbers()[:3] == ("1.offset", "1.c1", "1.c2")
        assert block.fixed == ("1.low", "1.high")
        assert [name for name, _, _ in block.describe_numbers(block.start())][3:5] == ["2.omega1", "2.zeta1"]

    def test_none_is_refused(self):
        with pytest.raises(ParameterError, match="at least one block"):
            SideBySide(blocks=())


class TestJoined:
    def test_series_and_sum_are_what_their_blocks_give(self):
        u = RNG.normal(size=(20, 1))
        for text, one in (("[poly2 | oe(2,2,1)]", False), ("[poly2 + oe(2,2,1)]", True)):
            block: Any = parse_block(text).adapt_to(u, 0.1)
            theta = block.sample_parameters(np.random.default_rng(1), 2.0, 0.1)
            found = ChainEngine([block], 0.1, compiled=False).simulate(theta, u)
            made, total = u, 0.0
            for child, own in block.split(theta, lambda child: len(child.numbers())):
                made = ChainEngine([child], 0.1, compiled=False).simulate(own, u if one else made)
                total = total + made
            assert np.allclose(found, total if one else made, atol=1e-12)

    @pytest.mark.parametrize("delay", [0, 1])
    def test_a_linear_loop_is_the_closed_loop(self, delay):
        # y = (1 - a) z / (1 - a q^-1) q^-delay, z = u - g b y, y that of the sample before without a delay
        (block,) = parsed(f"[oe(1,1,{delay}) < gain]")
        theta, u = np.array([0.0, *block.blocks[1].line(2.0, 0.0), 0.7]), np.sin(np.arange(30.0))
        a, g, y = np.exp(-0.1), 0.7 * 2.0, np.zeros(30)
        for k in range(1, 30):
            fed = u[k - delay] - g * y[k - 1]
            y[k] = a * y[k - 1] + (1.0 - a) * fed
        found = ChainEngine([block], 0.1, compiled=False).simulate(theta, u[:, None])
        assert np.allclose(found[:, 0], y, atol=1e-12)

    def test_a_loop_rests_where_both_paths_agree(self):
        (block,) = parsed("[oe(2,2,1) < poly3]")
        theta, u = np.array([0.1, 0.2, 0.3, 1.0, 0.0, 0.5, 0.8]), np.full((5, 1), 0.9)
        y = ChainEngine([block], 0.1, compiled=False).simulate(theta, u)
        assert np.ptp(y) < 1e-12
        fed = ChainEngine([block.blocks[1]], 0.1, compiled=False).simulate(theta[3:-1], y)
        assert y[-1, 0] == pytest.approx(0.9 - 0.8 * fed[-1, 0])

    def test_what_is_fed_back_is_fenced(self):
        block: Any = parse_block("[oe(2,2,1) < poly3]")
        states = np.zeros((3, block.states()))
        states[:, -1] = -1.0, 0.0, 3.0
        made = block.fence_in(block.start(), states, 0.1)
        assert (made.fence_low, made.fence_high) == (-2.0, 4.0)

    def test_bad_joins_are_refused(self):
        for text, words in (
            ("[poly2 & unit + unit]", "one kind of sign"),
            ("[oe(1,1,1) < ss(1,2,2)]", "two blocks of one input and one output"),
            ("[poly2 + ss(1,2,1)]", "must take the same signals"),
            ("[poly2 | ss(1,2,1)]", "takes 2"),
        ):
            with pytest.raises(MartensiteError, match=re.escape(words)):
                parse_block(text)


class TestTexts:
    def test_joined_blocks_are_read_and_written(self):
        text = "[[gain | oe(2,2,1)] < [poly(3) + boucwen]] | [poly(1) & [pwl(5,fixed) & gain]]"
        assert " | ".join(block.text() for block in parse_chain(text)) == text

    def test_of_summed_offsets_one_is_left(self):
        (block,) = parsed("[poly2 + gain + oe]")
        assert [child.offset for child in block.blocks[:2]] == ["yes", "no"]
        (loop,) = parsed("[oe < poly2]")
        assert loop.blocks[1].offset == "no"

    def test_chains_are_read_and_written(self):
        text = "[poly(2) & unit] | [oe(2,2,1) & deadzone] | [pwl(5,fixed) & unit]"
        blocks = parse_chain(text.upper().replace(" ", ""))
        assert " | ".join(block.text() for block in blocks) == text
        assert parse_block("pwl10") == parse_block("pwl( 10 )") == PiecewiseLinear(knots=10.0)
        assert parse_block("[poly3]") == Polynomial(degree=3.0)

    def test_one_offset_is_left_on_every_way(self):
        first, _, last = parsed("[poly2 & poly2 & gain] | ss(2,3,3) | [pwl5 & unit & sat]")
        assert [child.offset for child in first.blocks] == ["no"] * 3
        first, last = parsed("[poly2 & poly2] | [pwl5 & unit]")
        assert [child.offset for child in first.blocks] == ["no", "yes"]
        assert last.blocks[0].offset == "yes"

    def test_one_gain_is_left(self):
        assert [b.gain for b in parsed("deadzone | sat")] == ["one", "free"]

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("poly2 | [oe & gain", "nothing closes the bracket `[`"),
            ("poly2)", "nothing opens the bracket `)`"),
            ("oe(3,3,1] | pwl", "nothing opens the bracket `]`"),
            ("[poly2 & ]", "between square brackets stand blocks"),
            ("[poly2 | & unit]", "between square brackets stand blocks"),
            ("[poly2 & unit] x", "between square brackets stand blocks"),
            ("[poly2 & polly3]", "Did you mean `poly`?"),
            ("sigmoyd3", "Did you mean `sigmoid`?"),
            ("unit3", "`unit` takes none"),
            ("pwl(3,fixed,3)", "`pwl` takes at most 2: knots, inner"),
            ("pwl(3,loose)", "Valid: `fixed`, `free`"),
            ("poly(2.5)", "must be a whole number, but is 2.5"),
            ("poly(x)", "must be plain numbers"),
            ("poly99", "must be between 1 and 15"),
            ("poly2 || oe", "write blocks between bars"),
            ("poly2 oe3", "is no block"),
            ("", "write blocks between bars"),
        ],
    )
    def test_what_is_wrong_is_said(self, text, words):
        with pytest.raises(InputError) as caught:
            parse_chain(text)
        assert words in str(caught.value)
