"""One C file for a host: the core of a port, and the host's interface."""

from __future__ import annotations

from string import Template

from martensite.export.c_core import CCore


def join_source(core: CCore, interface: str, title: str) -> str:
    """Return a core with its header inlined, followed by an interface filled from a template."""
    whole = core.source.replace(f'#include "{core.name}.h"', core.header)
    filled = Template(interface).substitute(
        NAME=core.name, LAW=core.description, PARAMETERS="".join(_list_parameters(core)), INDEX=len(core.parameters)
    )
    return f"/* {title} */\n\n{whole}\n{filled}"


def _list_parameters(core: CCore) -> list[str]:
    return [
        f"     {place + 1:3d}  {one.default:<14.8g} {one.name} [{one.unit}]\n"
        for place, one in enumerate(core.parameters)
    ]
