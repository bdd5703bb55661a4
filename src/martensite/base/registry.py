"""Registries: a name for every law, heat model, mechanism, … found in one folder.

A registry scans its package, so a new file is a new entry with no list to edit. Packages
from elsewhere add entries through the entry-point group `martensite.<folder>`, and a
user's own module does so simply by being imported. A file that cannot be imported fails alone: other
names stay available, and `failures` names the file and the error. A name belongs to one class: another that asks
for it is refused, also while the first has not been imported yet.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from martensite.base.errors import InputError, MartensiteError, UnknownNameError
from martensite.base.interfaces import require_methods
from martensite.base.module_folder import ModuleFolder, describe_error

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
        self.group = "martensite." + package.rpartition(".")[2]
        self.typical = typical
        self._folder = ModuleFolder(package)
        self._entries: dict[str, type[T]] = {}
        self._scanned = False
        self._plugged = False

    def register(self, name: str, *, replace: bool = False) -> Callable[[type[C]], type[C]]:
        """Return a decorator that files a class under `name`.

        With `replace` it takes the place of the class that has the name. The decorator raises
        `InputError` where that is another class and it may not, and `MissingMethodError` for a
        class that is not complete.
        """

        def file_under(cls: type[C]) -> type[C]:
            require_methods(cls)
            holder = self._find_holder(name, cls)
            if holder is not None and not replace and not self._is_redefined(holder, cls):
                raise InputError(
                    f"The {self.kind} name `{name}` belongs to {_describe_place(holder)}, so "
                    f"{_describe_place(cls)} cannot have it; choose another name, or write "
                    f'`register("{name}", replace=True)` to replace the first.'
                )
            self._entries[name] = cast("type[T]", cls)
            cls.registered_name = name  # type: ignore[attr-defined]
            return cls

        return file_under

    def __getitem__(self, name: str) -> type[T]:
        self._find(name)
        if name not in self._entries:
            self._scan()
        if name not in self._entries:
            self._load_plug_in(name)
        if name not in self._entries:
            self._plug()
        if name not in self._entries:
            self._folder.require_import(f'.register("{name}"')
            raise UnknownNameError(self.kind, name, self._entries)
        return self._entries[name]

    def names(self) -> list[str]:
        """Return all names, those from installed plug-ins included."""
        self._scan()
        self._plug()
        return sorted(self._entries)

    def failures(self) -> list[str]:
        """Return a sentence for each file of the package that cannot be imported."""
        self._scan()
        return self._folder.list_failures()

    def _find_holder(self, name: str, cls: type[Any]) -> type[T] | None:
        """Return the class that has a name which another asks for."""
        # two files of this package meet when both are imported; looking further for each of them
        # would import all of a folder at the start of every run
        if name not in self._entries and not self._is_own(cls):
            self._find(name)
            self._scan()
            self._load_plug_in(name, cls.__module__.partition(".")[0])
        return self._entries.get(name)

    def _find(self, name: str) -> None:
        """Import the file of this package that files an entry, if there is one: others may be heavy."""
        if name not in self._entries and not self._scanned:
            self._import_where(f'.register("{name}")')

    def _scan(self) -> None:
        if not self._scanned:
            self._scanned = True
            self._import_where(".register(")

    def _import_where(self, words: str) -> None:
        """Import files by their text; a file that fails leaves no entry."""
        self._folder.import_where(words)
        for name in [n for n, cls in self._entries.items() if cls.__module__ in self._folder.failures]:
            del self._entries[name]

    def _plug(self) -> None:
        if not self._plugged:
            for point in entry_points(group=self.group):
                point.load()
            self._plugged = True  # not before: a plug-in that is refused is refused every time

    def _load_plug_in(self, name: str, besides: str = "") -> None:
        """Load the plug-in that is called like a name, if it is of a package `besides` another."""
        for point in entry_points(group=self.group, name=name):
            if point.module.partition(".")[0] != besides:
                point.load()

    def _is_own(self, cls: type[Any]) -> bool:
        return cls.__module__.partition(".")[0] == self.package.partition(".")[0]

    def _is_redefined(self, old: type[Any], new: type[Any]) -> bool:
        """Return whether a user's class is defined again: its cell or its file is executed again."""
        same_place = old.__module__ == new.__module__ or _find_file(old) == _find_file(new) is not None
        return same_place and old.__qualname__ == new.__qualname__ and not self._is_own(new)


def _find_file(cls: type[Any]) -> str | None:
    """Return the file in which a class is defined; None if it is not defined in one."""
    return getattr(sys.modules.get(cls.__module__), "__file__", None)


def _describe_place(cls: type[Any]) -> str:
    return f"`{cls.__qualname__}` in {_find_file(cls) or f'`{cls.__module__}`'}"


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
        if is_file:
            if not path.is_file():
                raise InputError(f"There is no file `{name}`.")
            _require_free(path)
        sys.path.insert(0, str(folder.resolve()))
        try:
            import_module(module)
        except MartensiteError:
            raise
        except Exception as error:  # whatever a user's file raises
            raise InputError(f"Cannot import `{name}`: {describe_error(error)}.") from None
        finally:
            sys.path.pop(0)


def _require_free(path: Path) -> None:
    """Raise `InputError` where another file has the name of a module already."""
    known = sys.modules.get(path.stem)
    if known is None:
        return
    place = getattr(known, "__file__", None)
    if place is None or not Path(place).samefile(path):
        raise InputError(
            f"`{path}` cannot be imported, since `{path.stem}` is the module "
            f"{place or 'of that name'} already; rename the file."
        )
