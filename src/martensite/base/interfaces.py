"""Check that a class defines all methods of its kind.

A base marks a required method with `abc.abstractmethod`, or with `require_where` if only classes with a flag need it.
Classes are checked when they are registered or created, not in the middle of a run. There is no metaclass because it
would slow down every `isinstance`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, TypeVar

from martensite.base.errors import MissingMethodError

F = TypeVar("F", bound=Callable[..., Any])

if TYPE_CHECKING:
    from typing_extensions import override as override
else:

    def override(method: F) -> F:
        """Mark a method that its base documents; type checkers compare the two (`typing.override` of Python 3.12)."""
        return method


def require_where(flag: str) -> Callable[[F], F]:
    """Return a decorator that requires the method in classes whose attribute `flag` is true."""

    def mark(method: F) -> F:
        method.require_where = flag  # type: ignore[attr-defined]
        return method

    return mark


def require_methods(cls: type[Any]) -> None:
    """Raise `MissingMethodError` unless a class defines all methods that its bases require."""
    if "is_complete" not in vars(cls):
        missing = _find_missing(cls)
        if missing:
            raise make_missing_error(cls, missing)
        cls.is_complete = True


def make_missing_error(cls: type[Any], names: Iterable[str]) -> MissingMethodError:
    """Return an error that names the missing methods of a class and their purpose."""
    missing = [(name, *_find_base(cls, name)) for name in names]
    calls = "; ".join(f"`{_write_call(name, f)}`: {_read_purpose(f)}" for name, _, f in missing)
    bases = {f"`{base.__qualname__}` in {base.__module__}": None for _, base, _ in missing}
    near = "".join(_suggest_names(cls, (name for name, _, _ in missing)))
    return MissingMethodError(
        f"`{cls.__qualname__}` in {cls.__module__} must define {calls} (see {' and '.join(bases)}).{near}"
    )


def _find_missing(cls: type[Any]) -> list[str]:
    required = {
        name: None for base in reversed(cls.__mro__) for name, value in vars(base).items() if _is_required(value, cls)
    }
    return [name for name in required if _is_required(_find_attribute(cls, name), cls)]


def _is_required(value: Any, cls: type[Any]) -> bool:
    flag = getattr(value, "require_where", None)
    return bool(getattr(value, "__isabstractmethod__", False) or (flag and getattr(cls, flag)))


def _find_attribute(cls: type[Any], name: str) -> Any:
    """Return the unbound attribute of the nearest class that has it."""
    return next(vars(base)[name] for base in cls.__mro__ if name in vars(base))


def _find_base(cls: type[Any], name: str) -> tuple[type[Any], Any]:
    """Return the base that describes a method, and the method."""
    method = _find_attribute(cls, name)
    base = next(base for base in reversed(cls.__mro__) if vars(base).get(name) is method)
    return base, getattr(method, "fget", method)


def _write_call(name: str, method: Any) -> str:
    code = method.__code__
    return f"{name}({', '.join(code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount])})"


def _read_purpose(method: Any) -> str:
    return (method.__doc__ or "").strip().partition("\n")[0].rstrip(".")


def _suggest_names(cls: type[Any], missing: Iterable[str]) -> Iterator[str]:
    """Yield questions about unknown methods with names similar to the missing ones."""
    inherited = {name for base in cls.__mro__[1:] for name in vars(base)}
    added = [name for name in vars(cls) if name not in inherited]
    for name in missing:
        for near in get_close_matches(name, added, n=1):
            yield f" Is `{near}` meant as `{name}`?"
