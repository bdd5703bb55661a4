"""Groups whose commands are the files of a folder.

A file declares a command by `@app.command("name", ...)`, or a group by `app.add_typer(..., name="name")`. Only the file
of the requested command is imported; a help text imports all. Other packages add commands through the entry-point group
`martensite.<folder>`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from typing import TYPE_CHECKING, Any, ClassVar

import typer
from typer.core import TyperGroup

from martensite.base.module_folder import ModuleFolder
from martensite.cli.plain_values import spare_conversion

if TYPE_CHECKING:
    from typer._click import Context


class FolderGroup(TyperGroup):
    """Commands declared by the files of a folder."""

    folder: ClassVar[ModuleFolder]
    declared: ClassVar[typer.Typer]
    """Collects the commands of imported files."""
    order: ClassVar[tuple[str, ...]] = ()
    """Titles of the help text in order; others follow."""
    declared_count = 0
    """Number of declarations in `commands`."""
    complete = False
    """True if all files are imported."""

    def get_command(self, ctx: Context, cmd_name: str) -> Any:
        """Return a command by name, or None."""
        self.load_command(cmd_name)
        return super().get_command(ctx, cmd_name)

    def load_command(self, name: str) -> bool:
        """Import the file of a command; return False if there is none."""
        words = f'command("{name}"', f'name="{name}"'
        if name not in self.commands:
            self._import(*words)
        if name not in self.commands:
            self._import_all()
        if name not in self.commands:
            self.folder.require_import(*words)
        return name in self.commands

    def list_commands(self, ctx: Context) -> list[str]:
        """Return all command names, by title and name."""
        self._import_all()
        titles = (*self.order, *sorted({self._find_title(name) for name in self.commands} - {*self.order}))
        return sorted(self.commands, key=lambda name: (titles.index(self._find_title(name)), name))

    def format_commands(self, ctx: Context, formatter: Any) -> None:
        """Write the commands by title, and the files that cannot be imported."""
        groups: dict[str, list[str]] = {}
        for name in self.list_commands(ctx):
            command = self.commands[name]
            if not command.hidden:
                groups.setdefault(self._find_title(name), []).append(name)
        for title, names in groups.items():
            width = formatter.width - 4 - max(map(len, names))
            with formatter.section(title):
                formatter.write_dl([(name, self.commands[name].get_short_help_str(width)) for name in names])
        for failure in self.folder.list_failures():
            formatter.write_paragraph()
            formatter.write_text(failure)

    def get_params(self, ctx: Context) -> list[Any]:  # type: ignore[override]
        """Return the parameters of the group."""
        return spare_conversion(super().get_params(ctx))

    def _find_title(self, name: str) -> str:
        return getattr(self.commands[name], "rich_help_panel", None) or "Commands"

    def _import(self, *words: str) -> None:
        self.folder.import_where(*words)
        declared = len(self.declared.registered_commands) + len(self.declared.registered_groups)
        if declared != self.declared_count:
            commands: MutableMapping[str, Any] = dict(typer.main.get_group(self.declared).commands)
            self.commands, self.declared_count = commands, declared
            for command in _list_inside(self.commands):
                command.get_params = _spare(command.get_params)  # type: ignore[method-assign]

    def _import_all(self) -> None:
        from importlib.metadata import entry_points

        if self.complete:
            return
        for point in entry_points(group="martensite." + self.folder.package.rpartition(".")[2]):
            point.load()
        self._import(".command(", ".add_typer(")
        self.complete = True


def _list_inside(commands: Mapping[str, Any]) -> Iterator[Any]:
    """Yield commands and the commands of groups among them."""
    for command in commands.values():
        yield command
        yield from _list_inside(getattr(command, "commands", {}))


def _spare(list_parameters: Callable[[Any], list[Any]]) -> Callable[[Any], list[Any]]:
    return lambda ctx: spare_conversion(list_parameters(ctx))


def make_group(
    package: str, cls: type[FolderGroup] = FolderGroup, *, help: str | None = None, short_help: str | None = None
) -> typer.Typer:
    """Return a group whose commands are the files of a package.

    Args:
        package: dotted name of the folder.
        cls: class of the group.
        help: help text; by default that of the callback.
        short_help: line in the list of commands; by default the start of `help`.
    """
    group_class: Any = type(cls.__name__, (cls,), {"folder": ModuleFolder(package)})
    group = group_class.declared = typer.Typer(
        cls=group_class,
        help=help,
        short_help=short_help,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # importing rich would dominate the time of a help text
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    return group
