"""Public names that are imported on first use, and optional packages.

A package lists its names and their modules in the stub `__init__.pyi`. Importing the package imports nothing else. If a
call fails and an argument has the wrong type, the error names this argument; successful calls are never checked.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin
from urllib.parse import unquote, urlparse

from martensite.base.errors import InputError

Function = TypeVar("Function", bound=Callable[..., Any])


def import_extra(module: str, extra: str, title: str = "") -> Any:
    """Import a module that belongs to an extra of this package.

    Raises:
        InputError: the module is not installed; the sentence has the line that installs it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(
            f"This needs {title or module}, which is not installed; run `{write_install_line(extra)}`."
        ) from None


def write_install_line(extra: str) -> str:
    """Return the line that installs an extra into this installation (PEP 610, `direct_url.json`)."""
    record: dict[str, Any]
    try:
        record = json.loads(distribution("martensite").read_text("direct_url.json") or "{}")
    except PackageNotFoundError:  # run from a source tree that was not installed
        record = {"url": Path(__file__).parents[3].as_uri(), "dir_info": {"editable": True}}
    url = str(record.get("url", ""))
    if not url.startswith("file:"):
        return f"pip install 'martensite[{extra}]'"
    editable = "-e " if record.get("dir_info", {}).get("editable") else ""
    return f"pip install {editable}'{unquote(urlparse(url).path)}[{extra}]'"


def list_public_names(package: str) -> dict[str, tuple[str, str]]:
    """Return public name -> (module, name in the module) for a package."""
    return _read_stub(Path(str(sys.modules[package].__file__)).with_suffix(".pyi"))


def _read_stub(stub: Path) -> dict[str, tuple[str, str]]:
    body = ast.parse(stub.read_text(encoding="utf-8")).body
    imported = {
        alias.asname or alias.name: (str(node.module), alias.name)
        for node in body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    homes = {name: home for name, home in imported.items() if not name.startswith("_")}
    for node in body:  # an alias, such as `BlockChain = _Chain`
        if isinstance(node, ast.Assign):
            homes[ast.unparse(node.targets[0])] = imported[ast.unparse(node.value)]
    return homes


RENAMED = {
    "Estimate": "MeasuredValue",
    "Limits": "ElementLimits",
    "motor_constants": "estimate_motor_constants",
    "tangent_fit": "fit_tangents",
    "tangent_points": "find_tangent_points",
}
"""Old public name -> new public name."""


def find_public_name(name: str) -> str:
    """Return the place of a public name, such as `ms.control.Pid`, from the stubs; empty if it is unknown."""
    top, new_name = __name__.partition(".")[0], RENAMED.get(name, name)
    own = list_public_names(top)
    if new_name in own:
        return f"ms.{new_name}"
    for inner, (home, last) in own.items():
        stub = Path(Path(str(sys.modules[top].__file__)).parent, *home.split(".")[1:], last, "__init__.pyi")
        if stub.exists() and new_name in _read_stub(stub):
            return f"ms.{inner}.{new_name}"
    return ""


def attach_names(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package from its stub; functions are guarded (`guard_arguments`)."""
    names = list_public_names(package)

    def import_name(name: str) -> Any:
        if name not in names:
            inner = name.startswith("_") or find_spec(f"{package}.{name}") is not None  # asked by an import
            place = "" if inner else find_public_name(name)
            raise AttributeError(f"module {package!r} has no attribute {name!r}{place and f'; it is `{place}`'}")
        home, own = names[name]
        module = import_module(home)
        is_module = hasattr(module, "__path__") and find_spec(f"{home}.{own}") is not None
        value = import_module(f"{home}.{own}") if is_module else getattr(module, own)
        if isinstance(value, FunctionType):
            value = guard_arguments(value)
        setattr(sys.modules[package], name, value)
        return value

    return import_name, lambda: sorted(names)


def guard_arguments(function: Function) -> Function:
    """Wrap a function so that a failed call names an argument of the wrong type."""

    @wraps(function)
    def guarded(*values: Any, **named: Any) -> Any:
        try:
            return function(*values, **named)
        except (AttributeError, TypeError) as error:
            words = describe_mismatch(function, values, named)
            if words is None:
                raise
            raise InputError(words) from error

    return guarded  # type: ignore[return-value]


def describe_mismatch(function: Callable[..., Any], values: tuple[Any, ...], named: dict[str, Any]) -> str | None:
    """Return a sentence about the argument that does not fit its annotation; None if all fit."""
    name = getattr(function, "__name__", "it")
    signature = inspect.signature(function)
    try:
        bound = signature.bind(*values, **named)
    except TypeError as error:
        return f"`{name}` cannot be called so: {error}; its arguments are `{signature}`."
    for argument, value in bound.arguments.items():
        parameter = signature.parameters[argument]
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        classes = _resolve_classes(parameter.annotation, function)
        if classes and not isinstance(value, classes):
            left_out = (type(None), int) if float in classes else (type(None),)
            listed = [one for one in classes if one not in left_out] or classes
            wanted = " or ".join(f"`{one.__name__.removeprefix('Abstract')}`" for one in listed)
            inner = getattr(value, "system", None)
            hint = "; give its `.system`" if inner is not None and isinstance(inner, classes) else ""
            return f"Argument `{argument}` of `{name}` must be {wanted}, but is `{type(value).__name__}`{hint}."
    return None


def _resolve_classes(annotation: Any, function: Callable[..., Any]) -> tuple[type, ...]:
    """Return the classes that an annotation allows; empty if it cannot be checked."""
    if isinstance(annotation, str):
        scope = dict(vars(sys.modules[function.__module__]))
        try:
            annotation = eval(annotation, scope)
        except (NameError, TypeError, AttributeError):  # known to type checkers only
            return ()
    origin: Any = get_origin(annotation)
    if origin in (Union, UnionType):
        inner = [_resolve_classes(one, function) for one in get_args(annotation)]
        return tuple(cls for one in inner for cls in one) if all(inner) else ()
    annotation = origin or annotation
    if annotation is None:
        return (type(None),)
    if annotation is float:
        return (float, int)
    return (annotation,) if isinstance(annotation, type) else ()
