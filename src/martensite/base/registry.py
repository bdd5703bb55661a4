"""Registries: names of all laws, heat models, mechanisms and other parts.

A registry scans its package, so a new file is a new entry. Other packages add entries through the entry-point group
`martensite.<folder>`; a user's module adds entries when it is imported. A file that cannot be imported fails alone and
is listed by `failures`. A name belongs to one class; a second class with this name is refused.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoints, entry_points
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
        """Create the registry of a package; forms and examples begin with the entry named `typical`."""
        self.kind = kind
        self.package = package
        self.group = "martensite." + package.rpartition(".")[2]
        self.typical = typical
        self._folder = ModuleFolder(package)
        self._entries: dict[str, type[T]] = {}
        self._scanned = False
        self._plugged = False

    def register(self, name: str, *, replace: bool = False) -> Callable[[type[C]], type[C]]:
        """Return a decorator that registers a class under `name`; `replace` allows to replace another class.

        Raises:
            InputError: another class has the name.
            MissingMethodError: the class is incomplete.
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
            cls.registered_name = name
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
        """Return all names, including plug-ins, sorted."""
        self._scan()
        self._plug()
        return sorted(self._entries)

    def failures(self) -> list[str]:
        """Return a sentence for each file of the package that cannot be imported."""
        self._scan()
        return self._folder.list_failures()

    def _find_holder(self, name: str, cls: type[Any]) -> type[T] | None:
        # searching for each class of this package would import the whole folder at the start of every run
        if name not in self._entries and not self._is_own(cls):
            self._find(name)
            self._scan()
            self._load_plug_in(name, cls.__module__.partition(".")[0])
        return self._entries.get(name)

    def _find(self, name: str) -> None:
        """Import only the file that registers a name; other files may be heavy."""
        if name not in self._entries and not self._scanned:
            self._import_where(f'.register("{name}")')

    def _scan(self) -> None:
        if not self._scanned:
            self._scanned = True
            self._import_where(".register(")

    def _import_where(self, words: str) -> None:
        """Import files by their text; drop entries of files that failed."""
        self._folder.import_where(words)
        for name in [n for n, cls in self._entries.items() if cls.__module__ in self._folder.failures]:
            del self._entries[name]

    def _plug(self) -> None:
        if not self._plugged:
            for point in _select_points(group=self.group):
                point.load()
            self._plugged = True  # not earlier: a refused plug-in is refused every time

    def _load_plug_in(self, name: str, besides: str = "") -> None:
        """Load the plug-in of a name, unless it is in the package `besides`."""
        for point in _select_points(group=self.group, name=name):
            if point.module.partition(".")[0] != besides:
                point.load()

    def _is_own(self, cls: type[Any]) -> bool:
        return cls.__module__.partition(".")[0] == self.package.partition(".")[0]

    def _is_redefined(self, old: type[Any], new: type[Any]) -> bool:
        """Return whether a user's class is defined again by executing its cell or file again."""
        same_place = old.__module__ == new.__module__ or _find_file(old) == _find_file(new) is not None
        return same_place and old.__qualname__ == new.__qualname__ and not self._is_own(new)


def _select_points(**wanted: Any) -> EntryPoints:
    return _read_points(tuple(sys.path)).select(**wanted)


@lru_cache(1)
def _read_points(path: tuple[str, ...]) -> Any:
    """Return the entry points of all distributions in `path`; each registry would read 200 files."""
    return entry_points()


def _find_file(cls: type[Any]) -> str | None:
    return getattr(sys.modules.get(cls.__module__), "__file__", None)


def _describe_place(cls: type[Any]) -> str:
    return f"`{cls.__qualname__}` in {_find_file(cls) or f'`{cls.__module__}`'}"


def import_modules(names: Sequence[str]) -> None:
    """Import modules that register a user's parts, by dotted name or by file.

    Modules are also searched in the current folder.

    Raises:
        InputError: a module cannot be imported.
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
    """Raise `InputError` if another module has the name of a file."""
    module = sys.modules.get(path.stem)
    if module is None:
        return
    place = getattr(module, "__file__", None)
    if place is None or not Path(place).samefile(path):
        raise InputError(
            f"`{path}` cannot be imported, since `{path.stem}` is the module "
            f"{place or 'of that name'} already; rename the file."
        )
