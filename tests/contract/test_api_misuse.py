"""Calls that are wrong in Python: each is refused with a sentence, and long objects have short texts.

Source of truth: the table of calls, each with the words that tell what to do.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fences import ROOT

import martensite as ms

m: Any = ms
"""Without types: what is called here is wrong on purpose."""
SCENARIO = ms.load(ROOT / "examples" / "pwm_bias_spring.toml")
SYSTEM: Any = SCENARIO.system
WIRE = {"material": "flexinol-90", "diameter": "0.25 mm", "length": "200 mm"}
ROUND = {"environment": SYSTEM.environment, "source": SYSTEM.source, "mechanism": SYSTEM.mechanism}

CALLS: dict[str, tuple[Callable[[], Any], str]] = {
    "a number as drive": (lambda: m.run(SCENARIO, 0.6, 30), r"the number 0.6; write `ms.Constant\(level=0.6\)`"),
    "a number as drive by name": (lambda: m.run(SCENARIO, {"drive": 0.6}), r"write `ms.Constant\(level=0.6\)`"),
    "a function as drive": (lambda: m.run(SCENARIO, lambda t: t, 30), "`function`; write a class derived from"),
    "an array as drive": (lambda: m.run(SCENARIO, np.ones(3), 30), r"`ndarray`; write `ms.signals.Table\(times"),
    "a class as drive": (lambda: m.run(SCENARIO, ms.Step, 30), r"class `Step`; give an object, such as `Step"),
    "one number as over": (lambda: m.run(SCENARIO, over={"diameter": 3e-4}), r'write `over=\{"diameter": \[0.0003\]'),
    "one text as over": (lambda: m.run(SCENARIO, over={"diameter": "3 mm"}), "needs a list of values for `diameter`"),
    "a list as over": (lambda: m.run(SCENARIO, over=[1.0]), "`over` of `run` must be `Mapping`, but is `list`.$"),
    "nothing as over": (lambda: m.run(SCENARIO, over={}), "`over` is empty; name a parameter"),
    "no values in over": (lambda: m.run(SCENARIO, over={"diameter": []}), "at least one: `element.diameter` 0"),
    "a number as a name in over": (lambda: m.run(SCENARIO, over={3: [1.0]}), "no parameter `3`"),
    "a list as duration": (lambda: m.run(SCENARIO, duration=[1]), "`duration` of `run` must be"),
    "a class as law": (lambda: m.Wire(**WIRE, law=ms.Brinson), r"class `Brinson`; give an object, such as `Brinson"),
    "a source as law": (lambda: m.Wire(**WIRE, law=ms.CurrentSource()), "must be an object of the class `Law`"),
    "a class as element": (lambda: m.System(element=ms.Wire, **ROUND), "`element` of `System` is the class `Wire`"),
    "a text as source": (lambda: m.System(element=SYSTEM.element, **ROUND | {"source": "x"}), "but is the text `x`"),
    "values without names": (lambda: m.Step(0.6), r"write `Step\(low=..., high=..., at=...\)`"),
    "a material without its name": (lambda: m.Wire("flexinol-90"), "`Wire` takes its values by name"),
    "a misspelt name": (lambda: m.Wire(**WIRE, diametre="0.2 mm"), "Did you mean `diameter`"),
    "a misspelt path": (lambda: SYSTEM.with_values({"diametre": 1e-4}), "Did you mean `element.diameter`"),
    "a unit in a level": (lambda: m.Step(high="0.6 A"), "but is `0.6 A`; leave the unit out"),
    "a number as material": (lambda: m.Wire(**WIRE | {"material": 3}), "must be a name or the path of a file"),
    "an actuator as linear system": (
        lambda: m.export.to_state_space(SYSTEM),
        "give an actuator to `plant_state_space`",
    ),
}


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_call_is_a_sentence(call: str) -> None:
    make, words = CALLS[call]
    with pytest.raises(ms.InputError, match=words):
        make()


HAND = ms.load(ROOT / "examples" / "hand.toml")
RECORD = ms.Record("log", {"time": [float(k) for k in range(800)], "force": [1.0] * 800}, {"time": "s", "force": "N"})


@pytest.mark.parametrize("made", [SCENARIO, HAND, RECORD], ids=["wire", "hand", "log"])
def test_long_objects_have_short_texts(made: Any) -> None:
    lines = repr(made).splitlines()
    assert len(lines) < 10 and max(map(len, lines)) < 200
    assert "<table" in made._repr_html_()


def test_long_lists_are_shortened_and_defaults_left_out() -> None:
    assert len(repr(ms.signals.Table(times=tuple(map(float, range(5000))), values=(0.0,) * 5000))) < 200
    assert repr(ms.Step(high=2.0, at=1.0)) == "Step(high=2.0, at=1.0)"


@pytest.mark.parametrize(
    ("package", "name", "place"),
    [
        (ms, "Pid", "ms.control.Pid"),
        (ms, "tangent_fit", "ms.characterise.fit_tangents"),
        (ms.control, "Wire", "ms.Wire"),
    ],
)
def test_a_name_that_has_moved_tells_its_place(package: Any, name: str, place: str) -> None:
    with pytest.raises(AttributeError, match=f"has no attribute '{name}'; it is `{place}`"):
        getattr(package, name)


def test_every_new_name_is_public() -> None:
    from martensite.base.lazy import RENAMED, find_public_name

    assert [new for new in RENAMED.values() if not find_public_name(new)] == []


def test_quantities_of_pint_are_taken_where_text_is() -> None:
    import pint

    units: Any = pint.UnitRegistry()
    cooling = ms.thermal.ConstantCooling(h=units.Quantity(7.0, "mW/cm^2/K"))
    assert ms.Environment(temperature=units.Quantity(22.0, "degC"), cooling=cooling).temperature == 295.15
    assert cooling.h == pytest.approx(70.0)
    path = ROOT / "examples" / "pwm_bias_spring.toml"
    changed = ms.load(path, {"diameter": units.Quantity(300.0, "um")})
    assert changed.system.value_of("diameter") == pytest.approx(3e-4)
    result = ms.run(changed, duration=units.Quantity(500.0, "ms"), samples=3)
    assert result["time"][-1] == 0.5


def test_rates_of_a_coil_and_inertia_of_a_platform() -> None:
    """Of a flat coil k = G d⁴/(8 N D³) with G = E/3; of a thin triangular plate of side s, m s²/24."""
    coil = ms.CoilSpring(
        material="flexinol-90",
        law=SYSTEM.element.law,
        diameter=7.5e-4,
        coil_diameter=4e-3,
        coil_measure="mean",
        turns=10,
        free_length=0.01,
    )
    for phase, modulus in (("austenite", "E_A"), ("martensite", "E_M")):
        expected = coil.law.value_of(modulus) / 3.0 * coil.diameter**4 / (80.0 * coil.coil_diameter**3)
        assert coil.spring_rate(phase) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(ms.InputError, match="No phase named `hot`"):
        coil.spring_rate("hot")
    platform: Any = ms.load(ROOT / "examples" / "closed_loop_platform.toml").system.mechanism
    assert platform.plate_inertia() == pytest.approx(platform.mass * platform.side**2 / 24.0)


TEXT = (ROOT / "examples" / "pwm_bias_spring.toml").read_text("utf-8")


def test_files_of_windows_are_read_or_refused(tmp_path: Path) -> None:
    """Notepad puts a mark in front of UTF-8, and may write UTF-16."""
    path = tmp_path / "a.toml"
    path.write_text(TEXT, "utf-8-sig")
    assert ms.load(path).title == SCENARIO.title
    for code, words in (("utf-16", "written in UTF-16; save it as UTF-8"), ("latin-1", "is not UTF-8 .byte 2.")):
        path.write_bytes("# µ".encode(code))
        with pytest.raises(ms.InputError, match=words):
            ms.load(path)


def test_a_change_may_name_a_number_by_its_ending() -> None:
    """As in a sweep: `diameter` is `element.diameter`, where it is the only one."""
    path = ROOT / "examples" / "pwm_bias_spring.toml"
    changed = ms.load(path, {"diameter": "0.2 mm", "element.length": "0.3 m"})
    assert (changed.system.value_of("diameter"), changed.system.value_of("length")) == (2e-4, 0.3)
    assert 'diameter = "0.2 mm"' in changed.text
    for name, words in (
        ("diametre", "Did you mean `element.diameter`"),
        ("drive.waveform.high", "must be a finite number with a unit, but is inf"),
    ):
        with pytest.raises(ms.InputError, match=words):
            ms.load(path, {name: float("inf")})
