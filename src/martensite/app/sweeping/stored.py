"""What a store says of itself: its scenario, what was asked for, and how far it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from martensite.app.gallery import built
from martensite.app.sweeping.shelf import bytes_of, is_busy
from martensite.base.errors import MartensiteError
from martensite.design.sweep.job import Wanted
from martensite.design.sweep.store import STATUS, Store
from martensite.scenario.scenario import Scenario


def scenario_in(spec: Mapping[str, Any]) -> Scenario:
    """The scenario that a sweep varies."""
    return built(spec["scenario"])


def asked_of(spec: Mapping[str, Any]) -> Wanted:
    """What was asked for."""
    return Wanted.of_spec(spec)


def summary(key: str, path: Path) -> dict[str, Any]:
    """A line about a sweep: `state` is running, done, stopped or unreadable."""
    told = {"key": key, "path": str(path), "bytes": bytes_of(path), "made": path.stat().st_mtime}
    try:
        store = Store(path)
        spec, runs = store.spec, int(store.group[STATUS].shape[0])
        chunks, length = store.made(), int(spec["chunk"])
        done = sum(min(length, runs - chunk * length) for chunk in chunks)
    except (MartensiteError, KeyError, ValueError) as error:
        lost = {"title": path.name, "over": [], "sample": "", "runs": 0, "done": 0}
        return {**told, **lost, "state": "unreadable", "why": str(error)}
    state = "done" if done == runs else "running" if is_busy(path) else "stopped"
    return {
        **told,
        "title": spec["title"],
        "over": spec["over"],
        "sample": spec["sample"],
        "runs": runs,
        "done": done,
        "state": state,
        "why": "",
    }
