"""Descriptions of registered parts: for `list` and `params`."""

from __future__ import annotations

from typing import Any

from martensite.base.errors import UnknownNameError
from martensite.base.registry import Registry
from martensite.scenario.catalogue import describe_class, list_registries, summarise_class


def describe_entry(registry: Registry[Any], name: str) -> dict[str, Any]:
    """The description of one entry of a registry."""
    return describe_class(registry.kind, registry[name])


def find_entries(name: str) -> list[dict[str, Any]]:
    """Descriptions of all entries of that name, in whichever registry; at least one."""
    known = list_registries(blocks=True).values()
    found = [describe_entry(registry, name) for registry in known if name in registry.names()]
    if not found:
        every = {entry for registry in known for entry in registry.names()}
        raise UnknownNameError("part", name, every)
    return found


def list_entries(registry: Registry[Any]) -> list[dict[str, str]]:
    """Names and summaries of a registry, ready for JSON."""
    return [{"name": name, "summary": summarise_class(registry[name])} for name in registry.names()]
