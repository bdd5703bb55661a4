"""What a kernel must not do is refused in a sentence: where it stands, what to write instead.

Each line is tried on a node of a graph, and as a law from a file by the command line, where laws
see dual numbers. Exit code 2, no traceback, on plain floats as in C: both run what was traced.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import example
from command import Command
from kernels import Kernel, traced
from one_wire import LIFTED, write_wire

from martensite.base.errors import InputError, KernelError, UnknownOperationError
from martensite.base.parameters import Parametrised
from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace
from martensite.kernels.dual import Dual
from martensite.kernels.namespace import OPERATIONS
from martensite.kernels.traced_numbers import TracedNumber
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.strip_laws import LiangRogers

SCENARIO = write_wire("Lifting 400 g", law='"NAME"', **LIFTED)
MODULE = """\
import math
import statistics
import numpy as np
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.strip_laws import LiangRogers


@LAWS.register("NAME")
class Mine(LiangRogers):
    "A law of my own."

    def remaining_fraction(self, xp, d):
        BODY
"""
LINE = 13
BRANCH, CHOICES = "must not branch on a value", "xp.where(condition, a, b)"
VALUE = "has no value that"
TRAPS = {
    # values
    "return math.sin(d)": ("`math.sin(d)`", VALUE, "write `xp.sin`."),
    "return math.fabs(d)": ("`math.fabs(d)`", VALUE, "write `xp.abs`."),
    "return math.pow(d, 0.5)": (VALUE, "write `xp.power`."),
    "return math.asin(d)": ("`math.asin(d)`", VALUE, "write one of `xp.abs`,"),
    "return float(d)": ("`float(d)`", VALUE),
    "return complex(d).real": (VALUE,),
    "return int(d)": ("`int(d)`", VALUE, "write `xp.nearest(x)`"),
    "return statistics.fmean([d, d])": ("`statistics.fmean([d, d])`", VALUE),
    "print(f'{d:.3f}')": (VALUE, "write `{x}` without a format"),
    "return d + None": ("`d + None`", "but None is none", "a `return` if one is missing"),
    # branches
    "return 1.0 if d > 0.5 else d": ("`d > 0.5`", BRANCH, CHOICES),
    "return d if d else 0.0": (BRANCH, CHOICES),
    "return d > 0.2 and d": (BRANCH, "`xp.both`"),
    "return d > 0.2 or d": (BRANCH, "`xp.either`"),
    "return xp.where(not d > 0.1, d, 0.0)": ("`not d > 0.1`", BRANCH, "`xp.negate`"),
    "return xp.where(0.0 < d < 1.0, d, 0.0)": ("`0.0 < d < 1.0`", BRANCH, "`xp.both`"),
    "while d > 1.0: d = d - 1.0": ("`d > 1.0`", BRANCH),
    "assert d > 0.0": (BRANCH,),
    "return min(d, 1.0)": ("`min(d, 1.0)`", BRANCH, "write `xp.minimum`."),
    "return max(0.0, d)": ("`max(0.0, d)`", BRANCH, "write `xp.maximum`."),
    "return sorted([d, 0.1])[0]": (BRANCH,),
    # powers, sizes, rounding
    "return d**d": ("`d**d`", "only whole numbers", "write `xp.power(x, y)`, for x above 0."),
    "return d**0.5": ("`d**0.5`", "only whole numbers", "`xp.power(x, y)`"),
    "return 2.0**d": ("`2.0**d`", "only whole numbers", "`xp.power(x, y)`"),
    "return pow(d, 0.5)": ("only whole numbers", "write `xp.power`."),
    "return abs(d)": ("`abs(d)`", "write `xp.abs`."),
    "return round(d)": ("`round(d)`", "does not round", "write `xp.nearest`."),
    "return math.floor(d)": ("does not round", "`xp.nearest(x - 0.5)`"),
    "return math.ceil(d)": ("does not round", "`xp.nearest(x + 0.5)`"),
    "return math.trunc(d)": ("does not round", "`xp.nearest(x)`"),
    "return d // 0.1": ("no `//` and no `%`", "`xp.nearest(x / y)`"),
    "return 1.0 % d": ("no `//` and no `%`", "`xp.nearest(x / y)`"),
    "return divmod(d, 1.0)[1]": ("no `//` and no `%`",),
    # counts and items
    "return sum(d for _ in range(d))": ("`range(d)`", "loops are of fixed count"),
    "return (0.0, 1.0)[d]": ("`(0.0, 1.0)[d]`", "must not count or choose by a value"),
    "return [0.0] * d": ("`[0.0] * d`", "computes with numbers, but [0.0] is none"),
    "a, b = d": ("is one number and has no items", "a tuple of numbers"),
    "return sum(d)": ("`sum(d)`", "is one number and has no items"),
    "return len(d)": ("`len(d)`", "is one number and has no items"),
    "return d[0]": ("`d[0]`", "is one number and has no items"),
    # comparisons and conditions
    "return xp.where(d == 0.0, 0.0, d)": ("`d == 0.0`", "write `xp.abs(a - b) <= limit`."),
    "return xp.where(0.0 != d, d, 0.0)": ("`0.0 != d`", "write `xp.abs(a - b) > limit`."),
    "return d in (0.0, 1.0)": ("`d in (0.0, 1.0)`", "are not compared by `==`"),
    "return xp.where((d > 0.1) & (d < 0.5), d, 0.0)": ("not for the conditions", "`xp.both(a, b)`"),
    "return xp.where((d < 0.1) | (d > 0.5), d, 0.0)": ("not for the conditions", "`xp.either("),
    "return xp.where(~(d > 0.1), d, 0.0)": ("not for the conditions", "write `xp.negate(a)`."),
    "return (d > 0.0) * d": ("`(d > 0.0) * d`", "a condition is no number", "`xp.where("),
    "return xp.exp(d > 0.0)": ("a condition is no number", "`xp.where(condition, a, 0.0)`"),
    "return xp.where(d > 0.0, d > 0.5, 1.0)": ("a condition is no number",),
    "return xp.where(d, 1.0, 0.0)": ("is not true or false", "write a comparison: `x > 0.0`."),
    "return xp.where(xp.both(d > 0.0, d), 1.0, 0.0)": ("is not true or false",),
    # NumPy
    "return np.sin(d)": ("`np.sin(d)`", "NumPy", "write `xp.sin`."),
    "return np.maximum(d, 0.0)": ("NumPy", "write `xp.maximum`."),
    "return np.clip(d, 0.0, 1.0)": ("NumPy", "write `xp.clip`."),
    "return np.where(d > 0.1, d, 0.0)": ("`np.where(d > 0.1, d, 0.0)`", "write `xp.where`."),
    "return np.arctan(d)": ("NumPy", "write one of `xp.abs`,"),
    "return np.interp(d, [0, 1], [0, 1])": ("NumPy", "a loop over a tuple of numbers"),
    "return np.array([d, d])[0]": ("`np.array([d, d])`", "a loop over a tuple of numbers"),
    "return (d * np.array([1.0, 2.0]))[0]": ("NumPy", "a loop over a tuple of numbers"),
    "return (np.array([1.0, 2.0]) * d)[0]": ("NumPy", "a loop over a tuple of numbers"),
    # operations that there are not
    "return xp.arctan(d)": ("no operation `arctan`", "Valid: `abs`,"),
    "return xp.maximun(d, 0.0)": ("no operation `maximun`", "Did you mean `maximum`?"),
    "return xp.max(d, 0.0)": ("no operation `max`", "`maximum`"),
}
ALLOWED = (
    "return np.float64(0.5) * d * 2.0",
    "return d * np.float64(1.0)",
    "return d * np.int64(1)",
    "return np.int64(0) + d",
    "return xp.where(np.float64(0.5) < d, d, d)",
    "return 0.0 * d**2 + d",
    "return d ** np.int64(1)",
    "return xp.where(True, d, 0.0)",
    "return sum((0.0 * d, d))",
    "print(f'{d}'); return d",
    "return xp.where(d is None, 0.0, d)",
)
NUMBERS = itertools.count()


class Written:
    """A file with a law, and a scenario with it."""

    def __init__(self, folder: Path, body: str) -> None:
        self.name = f"trap-{next(NUMBERS)}"
        self.file = folder / f"{self.name.replace('-', '_')}.py"
        text = MODULE.replace("NAME", self.name).replace("BODY", body)
        self.file.write_text(text, encoding="utf-8")
        self.scenario = folder / "wire.toml"
        self.scenario.write_text(SCENARIO.replace("NAME", self.name), encoding="utf-8")

    def words(self, *more: str) -> tuple[str, ...]:
        """Arguments of `run`."""
        return str(self.scenario), "--import", str(self.file), "--no-figure", "--force", *more

    def place(self) -> str:
        return f"`Mine.remaining_fraction` ({self.file.name}, line {LINE})"


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    made: list[Written] = []

    def writes(body: str) -> Written:
        made.append(Written(tmp_path, body))
        return made[-1]

    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield writes
    for one in made:
        LAWS._entries.pop(one.name, None)
        sys.modules.pop(one.file.stem, None)


def kernel_of(written: Written) -> Kernel:
    """The method of the law, on a number."""
    law = import_module(written.file.stem).Mine
    return Kernel({"d": (0.0, 1.0)}, lambda _, xp, d: law.remaining_fraction(None, xp, d))


@pytest.mark.parametrize("body", TRAPS)
def test_a_node_refuses(body: str, write: Any) -> None:
    written = write(body)
    with pytest.raises(KernelError) as caught:
        traced(Parametrised(), kernel_of(written))
    sentence = str(caught.value)
    assert written.place() in sentence
    assert all(words in sentence for words in TRAPS[body]), sentence
    assert "\n" not in sentence


@pytest.mark.parametrize("body", [*TRAPS][::9])
def test_the_command_line_refuses(body: str, write: Any) -> None:
    written = write(body)
    sentence = Command("run").refused(*written.words("--runtime", "floats"))
    assert written.place() in sentence
    assert all(words in sentence for words in TRAPS[body]), sentence


@pytest.mark.parametrize("body", ["return math.sin(d)", "return d if d > 0.5 else 0.0"])
def test_c_refuses_with_the_same_sentence(body: str, write: Any, c_compiler: object) -> None:
    written = write(body)
    sentences = [Command("run").refused(*written.words("--runtime", name)) for name in ("c", "floats")]
    assert sentences[0] == sentences[1]


@pytest.mark.parametrize("body", ALLOWED)
def test_what_is_allowed(body: str, write: Any) -> None:
    program = traced(Parametrised(), kernel_of(write(body)))
    values = program.bind_floats()["kernel"](0.7)
    assert values == pytest.approx((0.7,), rel=1e-15)


def test_the_place_is_where_the_mistake_is(write: Any) -> None:
    """Over several lines there is no text; helpers are named themselves, libraries are not."""
    several = write("return (d\n            if d >\n            0.3 else 0.0)")
    assert Command("run").refused(*several.words()).startswith("error: In `Mine.remaining_fraction` (trap_")
    helper = write("h = lambda x: math.exp(x)\n        return h(d)")
    said = Command("run").refused(*helper.words())
    assert f"`math.exp(x)` in `Mine.remaining_fraction.<lambda>` ({helper.file.name}, line {LINE})" in said


def test_a_mechanism_is_named_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("slack_spring.py").write_text(
        "from martensite.actuators.mechanisms.base import MECHANISMS\n"
        "from martensite.actuators.mechanisms.load_line import DeadWeight\n"
        "@MECHANISMS.register('slack-weight')\n"
        "class SlackWeight(DeadWeight):\n"
        "    'A weight.'\n"
        "    def force(self, xp, assembly, spring):\n"
        "        return max(super().force(xp, assembly, spring), 1.0 * spring.free)\n",
        encoding="utf-8",
    )
    text = SCENARIO.replace("NAME", "tanaka").replace("dead-weight", "slack-weight")
    Path("wire.toml").write_text(text, encoding="utf-8")
    said = Command("run").refused("wire.toml", "--import", "slack_spring.py", "--no-figure")
    assert "in `SlackWeight.force` (slack_spring.py, line 7): a kernel must not branch" in said


# ---------------------------------------------------------------- what is left to Python


def test_errors_are_those_of_python_and_of_bad_input() -> None:
    assert issubclass(KernelError, InputError | TypeError)
    assert issubclass(UnknownOperationError, AttributeError)
    with pytest.raises(TypeError):
        float(Dual(1.0, 1.0, 1))


def test_numbers_are_found_in_sets_by_identity() -> None:
    one, other = Dual(1.0, None, 1), Dual(1.0, None, 1)
    assert len({one, other, one}) == 2
    assert isinstance(one, TracedNumber)


def test_dual_numbers_take_arrays() -> None:
    dual: Any = Dual(np.array([1.0, 2.0]), np.array([1.0, 1.0]), 1)
    row: Any = np.array([3.0, 4.0])
    for found in (row * dual, dual * row):
        assert found.value.tolist() == [3.0, 8.0]
        assert found.tangent.tolist() == row.tolist()
    assert (row > dual).tolist() == [True, True]
    assert (row - dual).value.tolist() == [2.0, 2.0]


def test_operations_are_those_of_every_namespace() -> None:
    arrays = ArrayNamespace(np)
    assert all(hasattr(floats, name) and hasattr(arrays, name) for name in OPERATIONS)
    assert not hasattr(floats, "arctan")


def test_a_kernel_on_plain_floats_is_not_looked_at() -> None:
    """Called by hand it is Python: what it may not do is found when it is traced."""

    class Pythonic(LiangRogers):
        """Branches."""

        def remaining_fraction(self, xp: Any, distance: Any) -> Any:
            return max(distance, 0.0)

    assert example(Pythonic).remaining_fraction(floats, 0.25) == 0.25
