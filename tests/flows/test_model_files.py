"""Models as files, as plants of simulations and scenarios, and in python-control."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from command import Command

from martensite.base.errors import DataError, InputError, ParameterError
from martensite.base.parameters import part
from martensite.export.control_systems import to_control, to_state_space
from martensite.identify.blocks.base import BLOCKS, AbstractStatic
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.linearise import linearise_chain, operating_point
from martensite.identify.chains.plant import ModelMechanism, build_plant
from martensite.scenario.model_files import model_provenance, model_text, read_model, write_model
from martensite.scenario.scenario import load
from martensite.signals.base import AbstractDrive
from martensite.signals.sampling.sampled import Sampled
from martensite.signals.sine import Sine
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.controlled_run import simulate_controlled

pytestmark = pytest.mark.usefixtures("c_compiler")
DT = 0.05
SCENARIO = """
[model]
file = "stage.json"
[drive]
waveform = { kind = "step", high = "40 %", at = "0.7 s" }
[run]
duration = "3 s"
samples = 61
"""


@pytest.fixture(scope="module")
def chain():
    blocks = parse_chain("poly2 | oe(2,2,1) | poly1")
    blocks = tuple(
        b.with_parts(high=40.0 if i else 100.0) if isinstance(b, AbstractStatic) else b for i, b in enumerate(blocks)
    )
    theta = np.concatenate([b.start() for b in blocks])
    theta = theta + 0.1 * np.random.default_rng(1).normal(size=len(theta))
    units = {"duty": "%", "position": "mm"}
    return Chain(blocks, theta, DT, ("duty",), ("position",), units, name="stage")


# ---------------------------------------------------------------- files


def test_a_model_reads_back_exactly(chain, tmp_path):
    path, about = tmp_path / "stage.json", {"records": ["a"], "fit": 97.25}
    write_model(replace(chain, taps=((0, 0), (2, 0)), output_names=("w", "y")), path, about)
    back = read_model(path)
    assert back.theta.tobytes() == chain.theta.tobytes()
    assert (back.blocks, back.interval, back.units) == (chain.blocks, DT, chain.units)
    assert (back.taps, back.output_names, back.name) == (((0, 0), (2, 0)), ("w", "y"), "stage")
    assert json.loads(path.read_text("utf-8"))["provenance"] == about


@pytest.mark.parametrize("name", BLOCKS.names())
def test_every_block_reads_back_exactly(name, tmp_path):
    block = BLOCKS[name]()
    theta = np.random.default_rng(2).normal(size=len(block.numbers()))
    if block.fixed and not isinstance(block.fixed, property):
        block = block.with_fixed_values([v + 0.1 * (k + 1) / 3 for k, v in enumerate(block.fixed_values())])
    inputs, outputs = (
        tuple(f"{kind}{k}" for k in range(count)) for kind, count in (("u", block.inputs), ("y", block.outputs))
    )
    made = Chain((block,), theta, 1.0 / 3.0, inputs, outputs)
    write_model(made, tmp_path / "m.json")
    back = read_model(tmp_path / "m.json")
    assert back.blocks == made.blocks and back.theta.tolist() == theta.tolist()
    assert back.interval == 1.0 / 3.0


def test_provenance_of_an_estimate_holds_records_fits_and_options(tmp_path):
    u = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, 20), 10)
    record = Sampled("r", DT, u, 2.0 * u + 1.0, ("u",), ("y",))
    found = estimate_chain("poly1", record, Options(starts=1, iterations=10))
    about = model_provenance(found)
    write_model(found.chain, tmp_path / "m.json", about)
    (row,) = json.loads((tmp_path / "m.json").read_text("utf-8"))["provenance"]["records"]
    assert row["sha256_of_numbers"] == record.hash
    assert row["fit_percent"]["y"] > 99.9 and about["options"]["starts"] == 1
    assert record.hash != record.with_outputs(record.outputs + 1e-15 + 1e-9).hash


def damaged(text):
    """Texts of broken files, and what is said of each."""
    document = json.loads(text)
    number = document["blocks"][0]["numbers"]
    yield text[:200], "not valid JSON"
    yield "[]", "no model file"
    yield json.dumps({**document, "version": 99}), "version 99"
    yield json.dumps({k: v for k, v in document.items() if k != "interval"}), "lacks interval"
    yield json.dumps({**document, "interval": "0.05"}), "`interval` must be a finite number"
    yield text.replace('"transfer-function"', '"transfer-funktion"'), "Did you mean"
    yield text.replace(f"{number['c1']!r}", "NaN"), "NaN is no number"
    yield text.replace('"c2"', '"c9"'), "free parameters of block 1"
    yield text.replace('"nf": 2.0', '"nf": -2.0'), "nf"
    yield json.dumps({**document, "taps": [[7, 0]]}), "no output 0 of block 7"
    yield json.dumps({**document, "outputs": ["a", "b"]}), "1 outputs, but 2 are named"
    yield json.dumps({**document, "blocks": 3}), "damaged"
    yield json.dumps({**document, "blocks": [{"kind": "polynomial"}]}), "damaged"


def test_damaged_files_are_refused_in_a_sentence(chain, tmp_path):
    path = tmp_path / "m.json"
    for text, words in damaged(model_text(chain)):
        path.write_text(text)
        with pytest.raises(DataError) as caught:
            read_model(path)
        assert words in str(caught.value)
    path.write_text(model_text(chain))
    assert read_model(path).text() == chain.text(), "the file itself must be sound"
    with pytest.raises(DataError, match=r"no model file .*Did you mean `m.json`"):
        read_model(tmp_path / "n.json")


def test_what_no_file_can_hold_is_refused(chain, tmp_path):
    class Own(Polynomial):
        short = "own"
        registered_name = ""

    with pytest.raises(InputError, match="no registered name"):
        model_text(Chain((Own(),), np.zeros(3), DT))
    with pytest.raises(InputError, match="plain values"):
        model_text(chain, {"when": object()})
    with pytest.raises(InputError, match="not finite"):
        model_text(chain.with_theta(chain.theta * np.nan))
    with pytest.raises(DataError, match=r"ends in \.json"):
        write_model(chain, tmp_path / "m.pkl")


# ---------------------------------------------------------------- plants


def held(chain, high, at, count):
    """The input of a step, in the unit of the chain, and what the chain makes of it."""
    u = np.where(np.arange(count) >= at, high, 0.0)
    return chain.simulate(u)[:, 0]


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_model_runs_under_a_waveform_sample_by_sample(chain, runtime):
    found = simulate(build_plant(chain), Step(high=0.4, at=0.7), 3.0, samples=61, runtime=runtime)
    assert found.steps == 60 and found.accuracy is None and found.unit("position") == "m"
    assert np.allclose(1e3 * np.array(found["position"]), held(chain, 40.0, 14, 61), atol=1e-12)
    thin = simulate(build_plant(chain), Step(high=0.4, at=0.7), 3.0, samples=21, runtime=runtime)
    assert thin["position"].tolist() == found["position"][::3].tolist() and thin.steps == 60


def test_numbers_of_a_plant_are_those_of_its_chain(chain):
    other = build_plant(chain).with_values({"b1_c1": 2.5 * chain.theta[0]})
    assert isinstance(other.mechanism, ModelMechanism)
    assert other.mechanism.model.theta[0] == 2.5 * chain.theta[0]
    wave = Sine(high=0.4, frequency=0.5)
    changed = simulate(other, wave, 3.0, samples=61)
    u = 100.0 * np.array([wave.value(k * DT) for k in range(61)])
    expected = other.mechanism.model.simulate(u)[:, 0]
    assert np.allclose(1e3 * np.array(changed["position"]), expected, atol=1e-6)
    assert not np.allclose(expected, chain.simulate(u)[:, 0], atol=1e-3)


class Proportional(AbstractDrive):
    """Kp (r - y) in the unit of the drive."""

    measured: str = part("name of the output")

    def init(self):
        return None

    def __call__(self, time, measurement, memory):
        return 5.0 * (0.01 - measurement[self.measured]), memory


def test_a_model_closes_a_loop_with_a_controller(chain):
    period, count = 2 * DT, 40
    found = simulate_controlled(build_plant(chain), Proportional(measured="position"), count * period, period)
    state, y, u = operating_point(chain, 0.0).state, [], 0.0
    for _ in range(count):
        seen = chain.engine.simulate(chain.theta, np.array([[u]]), state.copy())[0, 0]
        u = 100.0 * 5.0 * (0.01 - 1e-3 * seen)
        y.append(chain.engine.simulate(chain.theta, np.full((2, 1), u), state)[0, 0])
    assert np.allclose(1e3 * np.array(found["position"][:-1]), y, atol=1e-10)
    with pytest.raises(ParameterError, match=r"whole number of samples of 0\.05 s"):
        simulate_controlled(build_plant(chain), Proportional(measured="position"), 1.0, 0.125)


def test_signals_of_one_name_are_refused(chain):
    with pytest.raises(InputError, match="inputs and outputs of the same name: duty"):
        build_plant(replace(chain, output_names=("duty",)))


def test_a_scenario_takes_a_model_file(chain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_model(chain, tmp_path / "stage.json")
    path = tmp_path / "model.toml"
    path.write_text(SCENARIO)
    found = load(path).run(runtime="c")
    assert np.allclose(1e3 * np.array(found["position"]), held(chain, 40.0, 14, 61), atol=1e-12)
    report = Command("run").report("model.toml", "--no-figure")
    assert report["columns"]["position"]["unit"] == "m"
    assert (tmp_path / "model.nc").is_file()
    signals = SCENARIO.replace("[drive]\nwaveform =", "[signals]\nduty =")
    path.write_text(signals)
    np.testing.assert_equal(load(path).run().columns, load(path).run().columns)
    for wrong, words in (
        (SCENARIO + '[mechanism]\nkind = "bias-spring"\n', "not both"),
        (SCENARIO.replace('file = "stage.json"', ""), "needs `file`"),
        (SCENARIO.replace("stage.json", "stag.json"), "Did you mean `stage.json`"),
        (signals.replace("duty =", "duti ="), "Did you mean `duty`"),
        (SCENARIO.replace("40 %", "40 V"), "V"),
    ):
        path.write_text(wrong)
        with pytest.raises(InputError) as caught:
            load(path)
        assert words in str(caught.value)


# ---------------------------------------------------------------- python-control


def test_python_control_runs_the_same_model(chain):
    control = pytest.importorskip("control")
    system = to_control(chain)
    u = np.random.default_rng(4).uniform(0.0, 40.0, 80)
    found = control.input_output_response(system, DT * np.arange(80), u, operating_point(chain, u[0]).state)
    assert system.dt == DT
    assert np.allclose(found.outputs, chain.simulate(u)[:, 0], atol=1e-12)


def test_python_control_gets_the_linear_system(chain):
    control = pytest.importorskip("control")
    linear = linearise_chain(chain, 20.0)
    system = to_state_space(chain, 20.0)
    assert control.dcgain(system) == pytest.approx(linear.gain()[0, 0])
    assert np.allclose(np.sort_complex(system.poles()), np.sort_complex(linear.poles()))


def test_without_python_control_a_sentence_says_how_to_get_it(chain, monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(InputError, match=r"pip install .*\[control\]'"):
        to_control(chain)
