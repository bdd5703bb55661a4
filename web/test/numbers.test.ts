import assert from "node:assert/strict";
import { test } from "node:test";
import { typed } from "../src/form/scale.ts";
import type { NumberNode } from "../src/form/types.ts";
import { dropMarks, tellBesideField, tellRefusal } from "../src/lib/refusal.ts";
import { difference, digits, readComma, toShown } from "../src/lib/numbers.ts";

test("numbers have so many digits, and no tail of zeros", () => {
  assert.equal(digits(1234.5678), "1235");
  assert.equal(digits(0.25), "0.25");
  assert.equal(digits(0), "0");
  assert.equal(digits(-1.5e-7), "-1.5e-7");
  assert.equal(digits(2e9), "2e+9");
  assert.equal(digits(1 / 3, 2), "0.33");
});

test("what is no number is a dash", () => {
  for (const value of [null, undefined, NaN, Infinity]) assert.equal(digits(value), "–");
});

test("temperatures are shown with their offset, differences without", () => {
  const celsius = { factor: 1, offset: -273.15 };
  assert.ok(Math.abs(toShown(293.15, celsius) - 20) < 1e-9);
  assert.equal(difference(5, celsius), 5);
  assert.equal(toShown(0.002, { factor: 1000, offset: 0 }), 2);
});

test("a decimal comma is a point, one between thousands is left to be refused", () => {
  for (const [typed, read] of [["0,2", "0.2"], ["0,381 mm", "0.381 mm"], ["-1,5e-3", "-1.5e-3"], [",5", ".5"], ["1000,25", "1000.25"], ["0.2", "0.2"], ["１２，５ mm", "12.5 mm"]] as const)
    assert.equal(readComma(typed), read);
  for (const typed of ["1,000", "1,000,000 Pa", "1,000.5"]) assert.equal(readComma(typed), typed);
});

test("a page shows no options of the command line and no marks", () => {
  const told = [
    ["Name the columns (`--as`), or write a scenario (--scenario).", "Name the columns, or write a scenario."],
    ["Name one, for example `stress[MPa]` (`--as 3=stress[MPa]`; in Python `named={\"3\": \"stress[MPa]\"}`).", "Name one, for example stress[MPa]."],
    ["Loss of heat (natural) of `wire`.", "Loss of heat (natural) of wire."],
  ];
  for (const [sentence, shown] of told) assert.equal(dropMarks(sentence!), shown);
});

test("a refused number is told in the unit of its field, and one beyond all floats as it was typed", () => {
  const node = { display_unit: "mm" } as NumberNode;
  assert.deepEqual([typed(node, "1e400"), typed(node, "１"), typed(node, "2 in")], ["1e400 mm", "1 mm", "2 in"]);
  const said = "[element] Parameter `diameter` of `wire`: `abc` is not a number with a unit; write for example `1.5 m`.";
  assert.equal(tellBesideField(said, "mm"), "“abc” is not a number with a unit; write for example 1.5 mm.");
  assert.equal(tellRefusal("[element] Parameter `diameter` of `wire` must be finite, but is 1e400 mm."), "Diameter of wire must be finite, but is 1e400 mm.");
});
