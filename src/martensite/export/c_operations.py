"""How many operations a kernel makes at most: counted on the graph that its C is printed from.

Every node counts once, in a loop once per turn. The C leaves out what is not chosen, so that
this is the worst case, and more than any step makes. Reading and storing is not counted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from martensite.kernels.graph import Expr, Graph

COSTS: Mapping[str, Mapping[str, int]] = {
    "add": {"add": 1},
    "sub": {"add": 1},
    "neg": {"add": 1},
    "mul": {"mul": 1},
    "div": {"div": 1},
    "lt": {"compare": 1},
    "le": {"compare": 1},
    "gt": {"compare": 1},
    "ge": {"compare": 1},
    "both": {"logic": 1},
    "either": {"logic": 1},
    "negate": {"logic": 1},
    "where": {"select": 1},
    "minimum": {"compare": 1, "select": 1},
    "maximum": {"compare": 1, "select": 1},
    "abs": {"abs": 1},
    "sqrt": {"sqrt": 1, "compare": 1, "select": 1},
    "exp": {"exp": 1, "compare": 1, "select": 1},
    "log": {"log": 1, "compare": 1, "select": 1},
    "power": {"power": 1, "compare": 2, "select": 2},
    "sin": {"sin": 1},
    "cos": {"cos": 1},
    "tanh": {"tanh": 1},
    "nearest": {"round": 1, "add": 1},
    "quarter_sine": {"sin": 1, "mul": 1},
    "erfcx": {"erfcx": 1},
}
"""What an operation counts as: one that is not here costs nothing. A subtraction and a change of
sign are additions; `erfcx` is an `exp` and an `erfc`, or 24 divisions."""
ORDER = (
    "add",
    "mul",
    "div",
    "sqrt",
    "exp",
    "log",
    "power",
    "sin",
    "cos",
    "tanh",
    "erfcx",
    "round",
    "abs",
    "compare",
    "select",
    "logic",
)


def count_operations(graph: Graph, outputs: Iterable[Expr], known: Iterable[Expr] = ()) -> dict[str, int]:
    """The most that computing `outputs` takes where the nodes `known` are there already."""
    found: Counter[str] = Counter()
    _count_nodes(graph, [o.index for o in outputs], {k.index for k in known}, 0, 1, found)
    return {name: found[name] for name in ORDER if found[name]}


def _count_nodes(
    graph: Graph, wanted: Iterable[int], known: set[int], inside: int, turns: int, found: Counter[str]
) -> None:
    """Add up nodes and what they need, `turns` times; in a loop only those with its bit."""
    seen, stack = set(known), list(wanted)
    while stack:
        index = stack.pop()
        if index in seen or (inside and not graph.depends[index] & inside):
            continue
        seen.add(index)
        for kind, count in COSTS.get(graph.operations[index], {}).items():
            found[kind] += count * turns
        if index in graph.loops:
            loop = graph.loops[index]
            rows = turns * len(loop.columns[0])
            _count_nodes(graph, loop.outputs, known, loop.bit, rows, found)
        elif index in graph.repeats:
            repeat = graph.repeats[index]
            _count_nodes(graph, repeat.outputs, known, repeat.bit, turns * repeat.turns, found)
        stack += graph.children(index)
