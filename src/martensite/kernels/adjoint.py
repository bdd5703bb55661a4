"""All partial derivatives of one traced value, from the value back to what it depends on.

    ā = Σ over the users y of a:  ȳ ∂y/∂a

One sweep costs a few times the value, however many variables there are; `partials` goes forwards,
which suits values that depend on few variables each. Slopes at kinks are those of dual numbers.
Nothing here goes back through loops.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from martensite.kernels.floats import HALF_PI, ROOT_PI
from martensite.kernels.graph import FLAGS, Expr, Graph

LOOPS = frozenset({"each", "item", "repeat", "result"})
Rule = Callable[[Graph, Any, Any, Sequence[Any]], Sequence[Any]]
"""From ȳ, y and its arguments to what each argument gets; None for nothing."""


def _add_choice_slopes(flag: Any, bar: Any) -> tuple[Any, Any]:
    graph: Graph = bar.graph
    return graph.apply("where", flag, bar, 0.0), graph.apply("where", flag, 0.0, bar)


def _add_root_slopes(graph: Graph, bar: Any, y: Any, a: Any) -> Any:
    safe = graph.apply("where", a > 0.0, y, 1.0)
    return graph.apply("where", a > 0.0, bar * (0.5 / safe), 0.0)


def _add_power_slopes(graph: Graph, bar: Any, y: Any, base: Any, exponent: Any) -> tuple[Any, Any]:
    safe = graph.apply("where", base > 0.0, base, 1.0)
    return bar * (exponent * y / safe), bar * (y * graph.apply("log", safe))


_RULES: dict[str, Rule] = {
    "add": lambda g, bar, y, a: (bar, bar),
    "sub": lambda g, bar, y, a: (bar, -bar),
    "mul": lambda g, bar, y, a: (bar * a[1], bar * a[0]),
    "div": lambda g, bar, y, a: (bar * (1.0 / a[1]), -(bar * (1.0 / a[1]) * y)),
    "neg": lambda g, bar, y, a: (-bar,),
    "where": lambda g, bar, y, a: (None, *_add_choice_slopes(a[0], bar)),
    "minimum": lambda g, bar, y, a: _add_choice_slopes(a[0] < a[1], bar),
    "maximum": lambda g, bar, y, a: _add_choice_slopes(a[0] > a[1], bar),
    "abs": lambda g, bar, y, a: (g.apply("where", a[0] < 0.0, -bar, bar),),
    "sqrt": lambda g, bar, y, a: (_add_root_slopes(g, bar, y, a[0]),),
    "exp": lambda g, bar, y, a: (bar * y,),
    "log": lambda g, bar, y, a: (bar * (1.0 / g.apply("maximum", a[0], 1e-300)),),
    "power": lambda g, bar, y, a: _add_power_slopes(g, bar, y, *a),
    "sin": lambda g, bar, y, a: (bar * g.apply("cos", a[0]),),
    "cos": lambda g, bar, y, a: (-(bar * g.apply("sin", a[0])),),
    "tanh": lambda g, bar, y, a: (bar * (1.0 - y * y),),
    "nearest": lambda g, bar, y, a: (bar,),
    "quarter_sine": lambda g, bar, y, a: (bar * (HALF_PI * g.apply("quarter_sine", 1.0 - a[0])),),
    "erfcx": lambda g, bar, y, a: (bar * (2.0 * a[0] * y - 2.0 / ROOT_PI),),
    "store": lambda g, bar, y, a: (bar,),
    "implicit_root": lambda g, bar, y, a: (None, bar),
}


def compute_gradient(value: Expr, variables: Sequence[Expr]) -> dict[int, Expr] | None:
    """Derivatives of a value by the number of the variable, those that are zero left out.

    None if there is a loop on the way.
    """
    graph, places = value.graph, {v.index: i for i, v in enumerate(variables)}
    order = _list_dependent(graph, value.index, frozenset(places))
    if order is None:
        return None
    moving = frozenset(order)
    bars: dict[int, Any] = {value.index: graph.constant(1.0)} if order else {}
    found: dict[int, Expr] = {}
    for index in reversed(order):
        bar = bars[index]
        if index in places:
            found[places[index]] = bar
            continue
        arguments = graph.arguments[index]
        own = [Expr(graph, i) for i in arguments]
        shares = _RULES[graph.operations[index]](graph, bar, Expr(graph, index), own)
        for argument, share in zip(arguments, shares, strict=True):
            if share is not None and argument in moving:
                bars[argument] = bars[argument] + share if argument in bars else share
    return {i: slope for i, slope in found.items() if graph.value_of(slope) != 0.0}


def _list_dependent(graph: Graph, value: int, variables: frozenset[int]) -> list[int] | None:
    """What the value is computed from and depends on the variables, in the order of computation.

    None if there are loops among it.
    """
    reached: set[int] = set()
    stack = [value]
    while stack:
        index = stack.pop()
        if index not in reached:
            reached.add(index)
            stack += _list_arguments(graph, index)
    moving: set[int] = set()
    for index in sorted(reached):
        if index in variables or any(a in moving for a in _list_arguments(graph, index)):
            moving.add(index)
    if any(graph.operations[index] in LOOPS for index in moving):
        return None
    return sorted(moving)


def _list_arguments(graph: Graph, index: int) -> tuple[int, ...]:
    """What derivatives follow: no flags, nothing detached, of a root its Newton step."""
    operation, arguments = graph.operations[index], graph.arguments[index]
    if operation in ("input", "constant", "detach") or operation in FLAGS:
        return ()
    return arguments[1:] if operation in ("where", "implicit_root") else arguments
