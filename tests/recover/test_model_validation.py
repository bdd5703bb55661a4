"""Scores, tests of residuals, and uncertainty of chains, on records whose truth is known."""

from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from martensite.base.errors import DataError, ParameterError
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.correlations import correlate_residuals
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.information_matrix import invert_normal, sum_blocks
from martensite.identify.chains.record_parts import find_rising, split_by_direction
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.chains.uncertainty import estimate_chain_uncertainty, measure_coverage
from martensite.identify.chains.validation import compare_validations, validate_chain
from martensite.search.levenberg_marquardt import minimise_cost
from martensite.show.figures.model import plot_model, plot_model_loop, plot_model_tests, thin_line
from martensite.show.figures.model_blocks import plot_linear_blocks, plot_static_blocks
from martensite.show.pages import write_model_report
from martensite.show.summaries.identification import summarise_model
from martensite.signals.sampling.sampled import Sampled

pytestmark = pytest.mark.usefixtures("c_compiler")
DT = 0.05


@pytest.fixture(scope="module")
def truth():
    blocks = parse_chain("oe(2,2,1) | poly2")
    theta = np.concatenate([b.start() for b in blocks])
    theta = theta + np.array([0.1, 0.0, 0.2, 0.1, 0.0, 0.15])
    return Chain(blocks, theta, DT, units={"u": "%", "y": "mm"}, name="truth")


def coloured(rng, count, size=0.05, memory=0.9):
    """Noise of first order that has forgotten its start."""
    white = rng.normal(size=count + 300)
    return size * np.asarray(lfilter([1.0], [1.0, -memory], white))[300:]


def recorded(chain, rng, levels=60, hold=40, noise=0.05):
    u = np.repeat(rng.uniform(-1.0, 1.0, levels), hold)
    y = chain.simulate(u)[:, 0] + coloured(rng, len(u), noise)
    return Sampled("steps", DT, u, y, ("u",), ("y",), {"u": "%", "y": "mm"})


# ---------------------------------------------------------------- scores


def test_scores_are_those_of_the_definition_and_leave_out_what_is_missing(truth):
    record = recorded(truth, np.random.default_rng(0))
    record.outputs[500:700] = np.nan
    record.outputs[3] += 50.0
    found = validate_chain(truth, record, skip=10)
    kept = np.r_[10:500, 700 : len(record)]
    y, e = record.outputs[kept, 0], (found.outputs - record.outputs)[kept, 0]
    one = found.score()
    assert one.rms == pytest.approx(np.sqrt(np.mean(e**2)))
    assert one.fit_percent == found.fit
    assert found.fit == pytest.approx(100 * (1 - np.linalg.norm(e) / np.linalg.norm(y - y.mean())))
    assert one.maximum == np.max(np.abs(e)) < 1.0 and one.samples == len(kept)
    parts = [found.score(part=name).samples for name in ("rising", "falling")]
    assert sum(parts) == one.samples and min(parts) > 0
    assert found.best().rms < one.rms < found.worst().rms
    assert found.to_dict()["scores"][0]["rms"] == one.rms


def test_an_input_rises_until_it_comes_back_by_more_than_its_noise():
    assert find_rising([0, 0, 5, 5, 5, 0, 0, 5, 5, 0.0]).astype(int).tolist() == [0, 0, 1, 1, 1, 0, 0, 1, 1, 0]
    t = np.linspace(0.0, 1.0, 201)
    noisy = np.where(t < 0.5, t, 1.0 - t) + 0.005 * np.random.default_rng(0).normal(size=201)
    assert np.mean(find_rising(noisy, 0.1) == (t < 0.5)) > 0.97
    assert np.mean(find_rising(noisy, 1e-6) == (t < 0.5)) < 0.9, "without a threshold noise turns"


def test_masks_replace_the_direction_of_the_input(truth):
    record = recorded(truth, np.random.default_rng(1))
    hot = record.inputs[:, 0] > 0.0
    assert validate_chain(truth, record, masks={"hot": hot}).score(part="hot").samples == hot.sum()
    with pytest.raises(DataError, match="Mask `hot` needs"):
        split_by_direction(record, {"hot": hot[:5]})
    with pytest.raises(ParameterError, match="between 0 and 1"):
        split_by_direction(record, reversal=2.0)


# ---------------------------------------------------------------- tests of residuals


def test_bands_of_correlation_hold_for_coloured_inputs_and_residuals():
    rng, inside, plain = np.random.default_rng(2), [], []
    for _ in range(60):
        u = np.repeat(rng.uniform(-1.0, 1.0, 60), 40)
        found = correlate_residuals(coloured(rng, len(u)), u, DT)
        assert found is not None
        inside.append(np.mean(np.abs(found.values) <= found.band(0.95)))
        plain.append(np.mean(np.abs(found.values) <= 1.96 / np.sqrt(len(u))))
    assert 0.90 < np.mean(inside) < 0.98
    assert np.mean(plain) < 0.6, "the band of white signals must fail here"


def test_a_model_of_the_right_order_passes_and_one_that_lacks_a_pole_does_not(truth):
    rng, passed, failed = np.random.default_rng(3), 0, 0
    short = Chain(parse_chain("oe(1,1,1) | poly2"), np.array([0.3, 0.1, 1.0, 0.15]), DT)
    for _ in range(20):
        record = recorded(truth, rng)
        passed += validate_chain(truth, record).explained
        failed += not validate_chain(short, record).explained
    assert passed >= 18 and failed == 20


def test_it_says_in_words_what_fails(truth):
    record = recorded(truth, np.random.default_rng(4))
    shifted = record.with_outputs(record.outputs + 3.0)
    assert any("off by a constant -2.9 mm" in s for s in validate_chain(truth, shifted).failures)
    bent = truth.with_theta(truth.theta + np.array([0, 0, 0, 0, 0, 1.0]))
    long = recorded(truth, np.random.default_rng(5), levels=300)
    assert any("bend of a static block" in s for s in validate_chain(bent, long).failures)
    uneven = record.outputs[:, 0] + np.where(find_rising(record.inputs[:, 0]), 0.4, 0.0)
    words = validate_chain(truth, record.with_outputs(uneven)).failures
    assert any("uneven" in s and "while rising" in s for s in words)
    fine = validate_chain(truth, record)
    assert not fine.failures and "find nothing" in " ".join(fine.sentences)
    assert "best and worst" in compare_validations([fine, validate_chain(truth, shifted)])
    with pytest.raises(DataError, match="at least 10"):
        validate_chain(truth, record, skip=len(record) - 3)


# ---------------------------------------------------------------- uncertainty


def fitted(truth, rng):
    record = recorded(truth, rng, levels=75)
    squares = ResidualSquares(truth.engine, [RecordResidual(record)])
    return truth.with_theta(minimise_cost(squares, truth.theta, 30).theta), squares


def test_bands_of_blocks_hold_under_coloured_noise_and_those_of_white_noise_do_not(truth):
    rng = np.random.default_rng(5)
    clean = recorded(truth, rng, noise=0.0)
    samples, model, white, errors = [], [], [], []
    for _ in range(30):
        chain, squares = fitted(truth, rng)
        whole, plain = (estimate_chain_uncertainty(chain, squares), estimate_chain_uncertainty(chain, squares, 1))
        band = whole.band(clean)
        away = np.abs(band.outputs - clean.outputs)
        model.append(np.mean(away <= band.model))
        white.append(np.mean(away <= plain.band(clean).model))
        noisy = clean.with_outputs(clean.outputs + coloured(rng, len(clean))[:, None])
        samples.append(measure_coverage(band, noisy)[0])
        errors.append((chain.theta - truth.theta) / whole.errors)
    assert 0.93 <= np.mean(samples) <= 0.97
    assert 0.88 <= np.mean(model) <= 0.99
    assert np.mean(white) < 0.6, "independent residuals would make the band far too narrow"
    middle = np.median(np.abs(errors), axis=0) / 0.6745  # 1 for normal errors of this size
    assert 0.6 < np.min(middle) and np.max(middle) < 1.5


def test_sums_do_not_depend_on_how_the_record_is_cut(truth):
    record = recorded(truth, np.random.default_rng(6), levels=110, hold=41)  # over one chunk
    squares = ResidualSquares(truth.engine, [RecordResidual(record, skip=7)])
    found = sum_blocks(squares, truth.theta, [64])
    y, slopes = truth.engine.jacobian(truth.theta, record.inputs)
    scale = squares.aims[0].scale()[0]
    errors, rows = scale * (record.outputs - y)[:, 0], scale * slopes[:, 0]
    errors[:7], rows[:7] = 0.0, 0.0
    scores = [rows[k : k + 64].T @ errors[k : k + 64] for k in range(0, len(record), 64)]
    assert found.blocks == len(scores) and len(record) > 4096
    assert np.allclose(found.middle, sum(np.outer(g, g) for g in scores))
    assert np.allclose(found.square, rows.T @ rows)


def test_directions_that_the_records_leave_open_are_named_and_not_drawn():
    blocks = parse_chain("poly1 | poly2")
    chain = Chain(blocks, np.array([2.0, 0.5, 0.7, 0.1]), DT)
    u = np.random.default_rng(7).uniform(-1.0, 1.0, 400)
    noise = 0.1 * np.random.default_rng(8).normal(size=(400, 1))
    record = Sampled("r", DT, u, chain.simulate(u) + noise, ("u",), ("y",))
    found = estimate_chain_uncertainty(chain, ResidualSquares(chain.engine, [RecordResidual(record)]))
    (flat,) = found.flat
    assert set(flat.names) == {"1.c1", "2.c1", "2.c2"}
    assert "not determined separately" in flat.sentence
    assert np.isinf(found.errors[0]) and np.isfinite(found.errors[1])
    assert found.blocks == (1,), "white residuals count one by one"
    assert np.isinf([row.error for row in found.describe_numbers() if row.name == "c1"]).all()
    moves = np.array([one.theta - chain.theta for one in found.draws(500, seed=1)])
    assert np.linalg.matrix_rank(moves, tol=1e-9) == 3
    assert np.allclose(np.cov(moves.T), found.covariance, atol=0.2 * found.covariance.max())


def test_a_number_without_effect_is_named_alone():
    found = invert_normal(np.diag([4.0, 0.0, 9.0]), ("a", "b", "c"))
    assert [one.names for one in found.flat] == [("b",)]
    assert "no effect" in found.flat[0].sentence
    assert np.allclose(found.matrix, np.diag([0.25, 0.0, 1.0 / 9.0]))


def test_directions_of_many_numbers_are_parted():
    """Of 30 numbers two pairs enter as sums alone."""
    rows = np.random.default_rng(13).normal(size=(200, 30))
    rows[:, 4], rows[:, 9] = rows[:, 20], 2.0 * rows[:, 21]
    found = invert_normal(rows.T @ rows, [f"n{i}" for i in range(30)])
    assert {frozenset(one.names) for one in found.flat} == {frozenset({"n4", "n20"}), frozenset({"n9", "n21"})}
    assert all(one.more == 0 for one in found.flat) and found.null.shape == (30, 2)


def test_errors_are_told_in_the_units_of_what_is_shown(truth):
    chain, squares = fitted(truth, np.random.default_rng(9))
    found = estimate_chain_uncertainty(chain, squares)
    omega = next(row for row in found.describe_numbers() if row.name == "omega1")
    assert omega.unit == "rad/s"
    assert omega.error == pytest.approx(omega.value * found.errors[0], rel=1e-6)
    assert any("coloured" in s for s in found.sentences)
    with pytest.raises(ParameterError, match="at least 1 sample"):
        estimate_chain_uncertainty(chain, squares, 0)


def test_errors_of_estimates_are_their_scatter_for_any_initial_state():
    """The truth: the scatter of a time constant over records that do not begin in steady state, with white noise."""
    u = np.repeat(np.random.default_rng(20).uniform(0.5, 1.0, 30), 20)
    y = lfilter([0.0, 0.05], [1.0, -0.95], u)  # from 0, far below the steady state of the first input
    estimates: list[Any] = []
    for seed in range(12):
        noisy = y + np.random.default_rng(seed).normal(0.0, 0.01, len(u))
        record = Sampled("steps", DT, u, noisy, ("u",), ("y",), {"u": "1", "y": "mm"})
        estimates.append(estimate_chain("oe(1,1,1)", [record], Options(starts=1, start="estimate")))
    found = [next(x for x in one.uncertainty.describe_numbers() if x.name == "tau") for one in estimates]
    scatter = np.std([x.value for x in found], ddof=1)
    assert 0.5 < np.mean([x.error for x in found]) / scatter < 2.0
    one = validate_chain(estimates[0].chain, estimates[0].records[0])
    band = estimates[0].uncertainty.band(one.record, state=one.state)
    assert band.outputs == pytest.approx(one.outputs, rel=1e-12)
    assert 0.9 < measure_coverage(band, one.record)[0] < 0.99
    blocks: list[Any] = [*summarise_model([one], estimates[0].uncertainty).blocks]
    (said,) = (x.text for x in blocks if "95 % band" in str(x))
    assert f"{100.0 * measure_coverage(band, one.record)[0]:.1f} %" in said


# ---------------------------------------------------------------- figures


def test_figures_show_what_they_say(truth):
    record = recorded(truth, np.random.default_rng(10))
    chain, squares = fitted(truth, np.random.default_rng(11))
    found = validate_chain(chain, record)
    band = estimate_chain_uncertainty(chain, squares).band(record)
    figure = plot_model(found, band)
    measured, computed = figure.axes[1].lines[:2]
    assert np.array_equal(computed.get_ydata(), found.outputs[thin_line(found.outputs[:, 0]), 0])
    assert np.array_equal(measured.get_xdata(), record.times[thin_line(record.outputs[:, 0])])
    assert f"{found.fit:.2f} %" in figure.axes[1].get_title("left")
    assert len(plot_model_loop(found).axes) == 2
    titles = [axes.get_title("left") for axes in plot_model_tests(found).axes]
    assert titles[1] == "y with u: nothing left"
    static = plot_static_blocks(chain, record).axes[0]
    line = static.lines[1]
    assert np.min(np.asarray(line.get_xdata())) >= chain.before(1, record).min() - 1e-12
    assert [axes.get_ylabel() for axes in plot_linear_blocks(chain).axes] == ["step response", "gain [dB]", "phase [°]"]


def test_a_report_tells_scores_faults_and_numbers(truth, tmp_path):
    record = recorded(truth, np.random.default_rng(10), levels=20)
    chain, squares = fitted(truth, np.random.default_rng(11))
    shifted = record.with_outputs(record.outputs + 3.0)
    found = validate_chain(chain, shifted)
    write_model_report([found], tmp_path / "m.md", estimate_chain_uncertainty(chain, squares))
    text = (tmp_path / "m.md").read_text()
    assert f"{found.fit:.2f}" in text and "off by a constant" in text and "omega1" in text
    assert {"record0.png", "loop0.png", "tests0.png", "static.png", "linear.png"} == {
        path.name for path in (tmp_path / "m_figures").iterdir()
    }
    with pytest.raises(DataError, match="at least one validation"):
        write_model_report([], tmp_path / "m.md")


def test_a_thinned_line_keeps_its_extremes():
    values = np.random.default_rng(12).normal(size=50_000)
    places = thin_line(values)
    assert len(places) < 8000
    assert {int(np.argmax(values)), int(np.argmin(values))} <= set(places.tolist())
