"""The commands of the command line as Markdown, from the commands themselves."""

from __future__ import annotations

import re
from typing import Any

from parts import code, plain, table

_OPTION = re.compile(r'(--[\w-]+(?: [\w.]+="[^"]*")?)')
"""An option within a help text, with its value where it is an example."""


def all_commands() -> str:
    """One section per command, nested commands included."""
    import typer

    from martensite.cli import app

    return "\n".join(_walk(typer.main.get_command(app), ("martensite",)))


def _walk(command: Any, path: tuple[str, ...]) -> list[str]:
    found = [_section(command, path)] if len(path) > 1 else []
    for name in command.list_commands(None) if hasattr(command, "list_commands") else ():
        found += _walk(command.get_command(None, name), (*path, name))
    return found


def _section(command: Any, path: tuple[str, ...]) -> str:
    visible = [p for p in command.params if not getattr(p, "hidden", False)]
    arguments = " ".join(_placeholder(p) for p in visible if p.param_type_name == "argument")
    usage = " ".join(filter(None, (*path, arguments, "[OPTIONS]")))
    rows = [_row(p) for p in visible if p.name != "help"]
    return "\n".join(
        [
            f"## `{' '.join(path)}`\n",
            f"{(command.help or '').strip()}\n",
            f"```text\n{usage}\n```\n",
            table(("argument or option", "meaning", "default"), rows) if rows else "",
        ]
    )


def _placeholder(parameter: Any) -> str:
    return parameter.metavar or parameter.name.upper()


def _row(parameter: Any) -> tuple[str, ...]:
    if parameter.param_type_name == "argument":
        names = _placeholder(parameter)
    else:
        flag = getattr(parameter, "is_flag", False)
        names = ", ".join(parameter.opts) + ("" if flag else f" {_placeholder(parameter)}")
    silent = parameter.default is None or parameter.default is False or callable(parameter.default)
    default = "required" if parameter.required else ("" if silent else str(parameter.default))
    meaning = _OPTION.sub(r"`\1`", plain(parameter.help or ""))
    return code(names), meaning, default
