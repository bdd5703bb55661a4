"""Write sentences of Python as functions of TypeScript.

A sentence is an f-string with given words. Each name in it becomes an argument, in the order in which the names appear.
A name that stands for a text or a choice of texts in the same function is replaced by that text.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==="}
FORMATS = {
    "": "${VALUE}",
    ".1e": "${formatPower(VALUE)}",
    ",": '${VALUE.toLocaleString("en")}',
    ".0f": "${VALUE.toFixed(0)}",
}
"""Python's format -> a part of a template."""
TEXTS = ast.JoinedStr | ast.IfExp | ast.Compare
"""Values that may be written in place of a name."""


def write_sentence(tree: ast.Module, name: str, words: str) -> str:
    """Return a function that writes the sentence of a module with given words.

    Raises:
        KeyError: the module has no such sentence.
    """
    for scope in ast.walk(tree):
        if isinstance(scope, ast.FunctionDef):
            for node in ast.walk(scope):
                if isinstance(node, ast.JoinedStr) and words in "".join(map(write_constant, node.values)):
                    sentence = Sentence(dict(list_texts(scope)))
                    text = sentence.write(node)
                    arguments = ", ".join(f"{key}: {kind}" for key, kind in sentence.arguments.items())
                    return f"export const {name} = ({arguments}): string =>\n  {text};"
    raise KeyError(words)


def list_texts(scope: ast.FunctionDef) -> Iterator[tuple[str, ast.expr]]:
    """Yield each local name of a function whose value is a text, a condition or a choice, with that value."""
    for node in ast.walk(scope):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if isinstance(value, TEXTS) and is_plain(value):
                yield name, value
            case ast.Assign([ast.Tuple(names)], ast.IfExp(test, ast.Tuple(first), ast.Tuple(second))):
                for target, yes, no in zip(names, first, second, strict=True):
                    yield ast.unparse(target), ast.IfExp(test, yes, no)


def is_plain(value: ast.expr) -> bool:
    """Return whether a value has no calls, no `and` or `or`, and a text in one branch of a choice."""
    if any(isinstance(one, ast.Call | ast.BoolOp) for one in ast.walk(value)):
        return False
    branches = (value.body, value.orelse) if isinstance(value, ast.IfExp) else (value,)
    return any(isinstance(one, ast.JoinedStr | ast.Compare) or write_constant(one) for one in branches)


def write_constant(node: ast.expr) -> str:
    """Return a constant text; else an empty one."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


@dataclass
class Sentence:
    """A sentence in progress."""

    texts: dict[str, ast.expr]
    arguments: dict[str, str] = field(default_factory=dict[str, str])
    """Name of each argument -> its type."""

    def write(self, node: ast.expr, kind: str = "string") -> str:
        """Return an expression in TypeScript; `kind` is its type."""
        match node:
            case ast.Name(id=name) if name in self.texts:
                return self.write(self.texts[name], kind)
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.Subscript(slice=ast.Constant(value=str() as name)):
                return self._take(name, kind)
            case ast.Subscript(value=value) | ast.Call(func=ast.Attribute(value=value), args=[]):
                return self.write(value, kind)
            case ast.Call(func=ast.Name(id="abs"), args=[value]):
                return f"Math.abs({self.write(value, 'number')})"
            case ast.Call(func=ast.Name(id=name)):
                return self._take(name, kind)
            case ast.Constant(value=value):
                return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else f"{value:g}"
            case ast.BinOp(left, operator, right):
                return f"({self.write(left, 'number')} {OPERATORS[type(operator)]} {self.write(right, 'number')})"
            case ast.Compare(ast.Constant(value=str() as name), [ast.In()], _):
                return self._take(f"has_{name}", "boolean")
            case ast.Compare(left, [ast.Is()], [ast.Constant(None)]):
                return f"{self.write(left, 'number | null')} === null"
            case ast.Compare(left, [operator], [right]):
                compared = "string" if write_constant(right) else "number"
                return f"{self.write(left, compared)} {OPERATORS[type(operator)]} {self.write(right, compared)}"
            case ast.IfExp(test, yes, no):
                return f"{self.write(test)} ? {self.write(yes)} : {self.write(no)}"
            case ast.JoinedStr(values):
                return f"`{''.join(self._write_part(one) for one in values)}`"
        raise TypeError(f"`{ast.unparse(node)}` of a sentence is not written in TypeScript here.")

    def _take(self, name: str, kind: str) -> str:
        """Return the name of an argument in TypeScript, and keep its type."""
        first, *others = (name.lower() if name.isupper() else name).split("_")
        name = first + "".join(map(str.capitalize, others))
        self.arguments.setdefault(name, kind)
        return name

    def _write_part(self, part: ast.expr) -> str:
        """Return a part of a template: a text, or a value in its format."""
        if not isinstance(part, ast.FormattedValue):
            return re.sub(r"([`\\])", r"\\\1", write_constant(part))
        spec = "".join(map(write_constant, getattr(part.format_spec, "values", ())))
        value = self.write(part.value, "number" if spec else "string")
        bare = value.removeprefix("(").removesuffix(")") if isinstance(part.value, ast.BinOp) else value
        if value.startswith("`"):
            return value[1:-1]
        if digits := re.fullmatch(r"\.(\d+)g", spec):
            return f"${{formatGeneral({bare}, {digits[1]})}}"
        return FORMATS[spec].replace("VALUE", bare if "(VALUE)" in FORMATS[spec] else value)
