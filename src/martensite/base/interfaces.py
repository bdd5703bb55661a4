"""Check that a class defines all methods of its kind, and build the message for missing ones.

A base marks a method by `abc.abstractmethod`, or by `require_where` if only classes with some flag need it. A part is
checked when it is registered, and at the latest when it is created: a missing method is reported where the class is
written, not in the middle of a run. The package uses no metaclass, because it would slow down every `isinstance`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from typing import Any, TypeVar

from martensite.base.errors import MissingMethodError

F = TypeVar("F", bound=Callable[..., Any])


def require_where(flag: str) -> Callable[[F], F]:
    """Return a decorator: classes whose attribute `flag` is true must define the method."""

    def mark(method: F) -> F:
        method.require_where = flag  # type: ignore[attr-defined]
        return method

    return mark


def require_methods(cls: type[Any]) -> None:
    """Raise `MissingMethodError` unless a class defines all that its bases ask for."""
    if "is_complete" not in vars(cls):
        missing = _find_missing(cls)
        if missing:
            raise make_missing_error(cls, missing)
        cls.is_complete = True


def make_missing_error(cls: type[Any], names: Iterable[str]) -> MissingMethodError:
    """Return an error whose sentence says which methods a class lacks, and what they must give."""
    missing = [(name, *_find_base(cls, name)) for name in names]
    asked = "; ".join(f"`{_write_call(name, f)}`: {_read_purpose(f)}" for name, _, f in missing)
    bases = {f"`{base.__qualname__}` in {base.__module__}": None for _, base, _ in missing}
    near = "".join(_suggest_names(cls, (name for name, _, _ in missing)))
    return MissingMethodError(
        f"`{cls.__qualname__}` in {cls.__module__} must define {asked} (see {' and '.join(bases)}).{near}"
    )


def _find_missing(cls: type[Any]) -> list[str]:
    """Return the names of the methods that a class must define and does not, in the order of its bases."""
    asked = {
        name: None for base in reversed(cls.__mro__) for name, value in vars(base).items() if _is_required(value, cls)
    }
    return [name for name in asked if _is_required(_find_attribute(cls, name), cls)]


def _is_required(value: Any, cls: type[Any]) -> bool:
    """Return whether a base requires a class to define an attribute."""
    flag = getattr(value, "require_where", None)
    return bool(getattr(value, "__isabstractmethod__", False) or (flag and getattr(cls, flag)))


def _find_attribute(cls: type[Any], name: str) -> Any:
    """Return an attribute as it is written in the nearest class that has it."""
    return next(vars(base)[name] for base in cls.__mro__ if name in vars(base))


def _find_base(cls: type[Any], name: str) -> tuple[type[Any], Any]:
    """Return the base that describes a method, and the method."""
    method = _find_attribute(cls, name)
    base = next(base for base in reversed(cls.__mro__) if vars(base).get(name) is method)
    return base, getattr(method, "fget", method)


def _write_call(name: str, method: Any) -> str:
    """Return a method with the arguments that it takes after `self`."""
    code = method.__code__
    given = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    return f"{name}({', '.join(given)})"


def _read_purpose(method: Any) -> str:
    return (method.__doc__ or "").strip().partition("\n")[0].rstrip(".")


def _suggest_names(cls: type[Any], missing: Iterable[str]) -> Iterator[str]:
    """Yield the questions about methods that no base knows and whose names are nearly those that miss."""
    known = {name for base in cls.__mro__[1:] for name in vars(base)}
    own = [name for name in vars(cls) if name not in known]
    for name in missing:
        for near in get_close_matches(name, own, n=1):
            yield f" Is `{near}` meant as `{name}`?"
