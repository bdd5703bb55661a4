"""Files of a folder that are imported on demand; a file that cannot be imported fails alone."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from martensite.base.errors import InputError, MartensiteError, StoppedError


class ModuleFolder:
    """Modules and packages within a package, such as `martensite.studies`."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.failures: dict[str, tuple[Path, str]] = {}
        """Module that could not be imported -> file and sentence."""

    def import_where(self, *words: str) -> None:
        """Import each file whose text contains one of the words; record failures."""
        for module, path in self._list_modules():
            if module not in self.failures and _contains(path, words):
                try:
                    import_module(module)
                except StoppedError:
                    raise
                except Exception as error:  # a half-written file may raise anything
                    self.failures[module] = (path, f"`{path}` cannot be imported: {describe_error(error)}.")

    def require_import(self, *words: str) -> None:
        """Raise `InputError` if a file that contains one of the words could not be imported."""
        for path, failure in self.failures.values():
            if _contains(path, words):
                raise InputError(failure)

    def list_failures(self) -> list[str]:
        """Return a sentence for each file that could not be imported."""
        return [failure for _, failure in self.failures.values()]

    def _list_modules(self) -> Iterator[tuple[str, Path]]:
        for folder in map(Path, import_module(self.package).__path__):
            for path in sorted([*folder.glob("*.py"), *folder.glob("*/__init__.py")]):
                if path.parent != folder:
                    yield f"{self.package}.{path.parent.name}", path
                elif path.stem != "__init__":
                    yield f"{self.package}.{path.stem}", path


def _contains(path: Path, words: tuple[str, ...]) -> bool:
    text = path.read_text("utf-8", errors="replace")
    return any(word in text for word in words)


def describe_error(error: Exception) -> str:
    """Return the fault of a file and its line, without a full stop."""
    if isinstance(error, SyntaxError):
        return f"{error.msg} (line {error.lineno} of {error.filename})"
    if isinstance(error, ImportError | MartensiteError):
        return str(error).rstrip(".")
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} (line {place.lineno} of {place.filename})"
