import assert from "node:assert/strict";
import { test } from "node:test";
import { compareDocuments, findKnown, writeChanged } from "../src/engine/documents.ts";
import { formatGeneral } from "../src/views/formulas.ts";
import { flattenTable, readToml, writeToml } from "../src/engine/toml.ts";
import type { Manifest } from "../src/engine/types.ts";

const TEXT = `# a wire
title = "A \\"wire\\""
[element]
kind = "wire"      # straight
law = { kind = "a-b", n = 1.50 }
limits.stress = '150 MPa'
[actuators.one]
points = [
  0, 1e-3, # two
]
on = true
`;

test("documents are read, changed and written as the server does it", () => {
  const found = Object.fromEntries(flattenTable(readToml(TEXT)));
  assert.deepEqual(found, {
    title: 'A "wire"',
    "element.kind": "wire",
    "element.law.kind": "a-b",
    "element.law.n": "1.50",
    "element.limits.stress": "150 MPa",
    "actuators.one.points": "[0, 1e-3]",
    "actuators.one.on": "true",
  });
  assert.deepEqual(flattenTable(readToml(writeToml(readToml(TEXT)))), flattenTable(readToml(TEXT)));
  const next = writeChanged(TEXT, { "element.kind.turns": 3, "element.law.n": "2 mm" });
  assert.match(next, /kind = \{ kind = "wire", turns = 3 \}/);
  assert.match(next, /law = \{ kind = "a-b", n = "2 mm" \}/);
  assert.throws(() => writeChanged(TEXT, { "title.size": 1 }), /`title.size` cannot be set/);
  assert.throws(() => readToml("title = \n[element"), /no TOML at letter/);
});

test("a document is known by its numbers", () => {
  const manifest: Manifest = { version: "", scenarios: [{ name: "wire", title: "", text: TEXT, file: "", module: "" }] };
  const known = findKnown(manifest, writeChanged(TEXT, { "element.law.n": 2, "element.length": "1 m" }));
  assert.deepEqual([known.name, [...known.written]], ["wire", [["element.law.n", "2"], ["element.length", "1 m"]]]);
  assert.throws(() => findKnown(manifest, 'title = "other"'), /runs its own scenarios only/);
  assert.deepEqual(compareDocuments(["a = 1\nb = 2", "a = 1\nb = 3"]).rows, [{ path: "b", values: ["2", "3"] }]);
});

test("numbers in sentences are those of Python", () => {
  const pairs: [number, number, string][] = [[0.1234567, 6, "0.123457"], [1e-7, 6, "1e-07"], [1234567, 6, "1.23457e+06"], [150, 5, "150"], [0, 5, "0"]];
  for (const [value, digits, text] of pairs) assert.equal(formatGeneral(value, digits), text);
});
