"""Registries: a name for every law, heat model, mechanism, … found in one folder.

A registry scans its package, so a new file is a new entry with no list to edit. Packages
from elsewhere add entries through the entry-point group `martensite.<package>`, and a
user's own module does so simply by being imported.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from typing import Generic, TypeVar, cast

from martensite.errors import InputError, UnknownNameError

T = TypeVar("T")
C = TypeVar("C")


class Registry(Generic[T]):
    """Named classes of one kind, discovered on first use."""

    def __init__(self, kind: str, package: str, typical: str = "") -> None:
        """A registry of a `kind`, of all that a package holds; `typical` is the name of one of it.

        The typical one is what a form begins with and what examples of other parts are made of.
        """
        self.kind = kind
        self.package = package
        self.typical = typical
        self._entries: dict[str, type[T]] = {}
        self._scanned = False
        self._plugged = False

    def register(self, name: str) -> Callable[[type[C]], type[C]]:
        """Return a decorator that files a class under `name`."""

        def file_under(cls: type[C]) -> type[C]:
            self._entries[name] = cast("type[T]", cls)
            cls.registered_name = name  # type: ignore[attr-defined]
            return cls

        return file_under

    def __getitem__(self, name: str) -> type[T]:
        self._find(name)
        if name not in self._entries:
            self._scan()
        if name not in self._entries:
            self._plug()
        if name not in self._entries:
            raise UnknownNameError(self.kind, name, self._entries)
        return self._entries[name]

    def names(self) -> list[str]:
        """All names, those from installed plug-ins included."""
        self._scan()
        self._plug()
        return sorted(self._entries)

    def _find(self, name: str) -> None:
        """Import the file that is called like an entry, if there is one: others may be heavy."""
        module = name.replace("-", "_")
        own = f"{self.package}.{module}"
        if name not in self._entries and module.isidentifier() and find_spec(own):
            import_module(own)

    def _scan(self) -> None:
        if not self._scanned:
            self._scanned = True
            package = import_module(self.package)
            for module in iter_modules(package.__path__):
                import_module(f"{self.package}.{module.name}")

    def _plug(self) -> None:
        if not self._plugged:
            self._plugged = True
            for point in entry_points(group=self.package):
                point.load()


def import_modules(names: Sequence[str]) -> None:
    """Import what registers parts of the user's own, by dotted name or by file.

    Modules by name are looked for in the current folder too.

    Raises:
        InputError: one cannot be imported.
    """
    for name in names:
        path = Path(name)
        is_file = path.suffix == ".py"
        folder, module = (path.parent, path.stem) if is_file else (Path(), name)
        sys.path.insert(0, str(folder.resolve()))
        try:
            import_module(module)
        except ImportError as error:
            raise InputError(f"Cannot import `{name}`: {error}.") from None
        finally:
            sys.path.pop(0)
