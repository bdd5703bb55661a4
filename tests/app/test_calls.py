"""The interface of the bench as a client sees it."""

from pathlib import Path

from app_server import Bench

TEXT = (Path(__file__).parents[2] / "examples/constant_power.toml").read_text("utf-8")


def test_a_scenario_runs(bench: Bench) -> None:
    found = bench.call("run", {"text": TEXT, "changes": {"element.diameter": "0.2 mm"}})
    assert "error" not in found, found
    assert 'diameter = "0.2 mm"' in found["text"]
    assert len(found["times"]) == len(found["columns"]["temperature"]) > 1001
    assert found["outputs"]["temperature"]["display_unit"] == "degC"


def test_a_refusal_is_a_sentence(bench: Bench) -> None:
    found = bench.call("run", {"text": TEXT, "changes": {"element.diametr": "0.2 mm"}})
    assert "Did you mean `diameter`" in found["error"]
    assert found["kind"] == "input"


def test_a_refusal_names_no_folder_of_the_installation(bench: Bench) -> None:
    found = bench.call("run", {"text": TEXT, "changes": {"element.material": "nosuch.toml"}})
    assert "There is no material file `nosuch.toml`" in found["error"]
