"""The public names: what is promised to stay.

Source of truth: `public_names.txt`, written by hand whenever the promise is to change, against what
the stubs of the packages say and what the modules define.
"""

from __future__ import annotations

import inspect
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType

import pytest

import martensite
from martensite.base.lazy import list_public_names

PROMISED = {
    name: set(names.split())
    for name, _, names in (
        line.partition(":") for line in Path(__file__).with_name("public_names.txt").read_text("utf-8").splitlines()
    )
}


def find_package(name: str) -> ModuleType:
    """The package that a line of the promise is about."""
    return martensite if name == "ms" else getattr(martensite, name.removeprefix("ms."))


@pytest.mark.parametrize("name", PROMISED)
def test_the_names_are_those_that_are_promised(name: str) -> None:
    assert set(dir(find_package(name))) == PROMISED[name]


def test_few_names_stand_at_the_top_and_the_rest_in_packages() -> None:
    assert len(dir(martensite)) <= 45
    inner = {n for n in dir(martensite) if isinstance(getattr(martensite, n), ModuleType)}
    assert {f"ms.{name}" for name in inner} - {"ms.testing"} == set(PROMISED) - {"ms"}


@pytest.mark.parametrize("name", PROMISED)
def test_every_name_is_what_its_module_defines(name: str) -> None:
    package = find_package(name)
    named = package.__name__
    import_module(named)
    for public, (home, own) in list_public_names(named).items():
        found = getattr(package, public)
        assert inspect.unwrap(found) is getattr(import_module(home), own)
        if isinstance(found, type | FunctionType) and found.__module__ != "builtins":
            assert found.__module__ == home, f"`{public}` is defined in {found.__module__}"


def test_a_name_that_is_nowhere_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = martensite.nothing  # type: ignore[attr-defined]


def test_importing_is_light_and_packages_stay_packages() -> None:
    code = (
        "import sys, martensite as ms;"
        "ms.control, ms.fit, ms.simulate;"
        "heavy = {'numpy', 'pint', 'xarray', 'typer', 'rich'} & sys.modules.keys();"
        "import martensite.simulate.api, martensite.simulate.result;"
        "print(len(heavy), type(ms.simulate).__name__, hasattr(ms, 'nothing'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0", "module", "False"]
