"""The record that describes one engine of the comparison, and the list of engines.

What: an engine turns a wire, a drive and one of its own accuracy settings into a callable without
arguments; the harness times that callable. Everything before it (building inputs, tracing) is
preparation and is timed only in the cold-start sections. Engines are named by module so that a
fresh process imports only the one it runs. A new engine is one record and one line in `WHERE`.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

Thunk = Callable[[], Any]


class Engine(NamedTuple):
    """One way to solve problem A.

    Attributes:
        name: As printed, and as given to `--engines`.
        rule: "P" or "R", the history rule it solves and the reference it is measured against.
        settings: Accuracy settings from coarse to fine, by printed label.
        usual: Label of the setting used where a table shows only one.
        single: (wire, drive, setting) -> thunk returning x [mm] on the output grid.
        batch: (wire with arrays, drive, setting) -> thunk returning x [mm], one row per set.
        gradient: (wire, drive, setting) -> thunk returning dJ/dq, ten numbers.
        step: (wire, dt) -> (state, advance), advance(state, V^2) -> state; for control loops.
        batch_limit: Largest batch that is run; a bigger one costs the same per trajectory.
        environments: Extra environment variables for cold starts, by printed label; empty values
            of "CACHE" directories are filled with a fresh folder.
        only_edges: Shown only for inputs with edges (it differs from another engine only there).
        optional: Module that must be importable, beyond the core ones.
    """

    name: str
    rule: str
    settings: Mapping[str, Any]
    usual: str
    single: Callable[..., Thunk] | None = None
    batch: Callable[..., Thunk] | None = None
    gradient: Callable[..., Thunk] | None = None
    step: Callable[..., tuple[Any, Callable[[Any, float], Any]]] | None = None
    batch_limit: int = 1_000_000
    environments: Mapping[str, Mapping[str, str]] = {"": {}}
    only_edges: bool = False
    optional: str = ""


PEERS = {
    "floats": "benchmarks.peers.return_map",
    "numpy": "benchmarks.peers.return_map_numpy",
    "odeint": "benchmarks.peers.ode",
    "odeint-beyond": "benchmarks.peers.ode",
    "odeint-unaware": "benchmarks.peers.ode",
    "lsoda": "benchmarks.peers.ode",
    "lsoda-c": "benchmarks.peers.lsoda_c",
    "rk45": "benchmarks.peers.ode",
    "dop853": "benchmarks.peers.ode",
    "radau": "benchmarks.peers.ode",
    "cvode": "benchmarks.peers.ode",
    "odeint-numba": "benchmarks.peers.ode",
    "cvode-numba": "benchmarks.peers.ode",
    "diffrax-forward": "benchmarks.peers.diffrax_rate",
    "diffrax": "benchmarks.peers.diffrax_rate",
}
OURS = dict.fromkeys(("ours", "ours-c", "ours-call", "ours-march", "ours-simd"), "benchmarks.ours")
WHERE = OURS | PEERS


def load(name: str) -> Engine:
    """The engine of that name; imports its module (which must hold a tuple ENGINES)."""
    if name not in WHERE:
        raise SystemExit(f"No engine is named {name!r}; there are {', '.join(WHERE)}.")
    found = {engine.name: engine for engine in importlib.import_module(WHERE[name]).ENGINES}
    return found[name]


def available(names: Sequence[str]) -> list[Engine]:
    """The engines of these names whose optional packages are installed."""
    engines = [load(name) for name in names]
    return [e for e in engines if not e.optional or importlib.util.find_spec(e.optional)]
