"""What a store says of itself: its scenario, what was asked for, and how far it is."""

from __future__ import annotations

from pathlib import Path

from martensite.app.messages import JsonTable
from martensite.app.sweeping.sweep_folder import is_busy, measure_bytes
from martensite.base.errors import MartensiteError
from martensite.design.sweep.store import STATUS, Store


def summarise_store(key: str, path: Path) -> JsonTable:
    """A line about a sweep: `state` is running, done, stopped or unreadable."""
    told = {"key": key, "path": str(path), "bytes": measure_bytes(path), "made": path.stat().st_mtime}
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
