// Source of truth: the bounds of the list of steps, 200 steps and 1 MiB of text.

import assert from "node:assert/strict";
import { test } from "node:test";

Object.assign(globalThis, {
  location: { hash: "", href: "http://localhost/", origin: "http://localhost" },
  addEventListener: () => undefined,
  sessionStorage: { getItem: () => null, setItem: () => undefined },
  localStorage: { getItem: () => null, setItem: () => undefined },
});
const { canUndo, change, text, undo } = await import("../src/state/scenario.ts");

function countUndone(): number {
  for (let count = 0; ; count++) {
    if (!canUndo.value) return count;
    undo();
  }
}

test("500 moves leave 200 steps to undo, and long documents fewer", () => {
  for (let k = 0; k <= 500; k++) change(`title = "${k}"`);
  assert.equal(countUndone(), 200);
  assert.equal(text.value, 'title = "300"');
  for (let k = 0; k <= 500; k++) change(`${k}`.padEnd(2 ** 16, "#"));
  assert.ok(countUndone() <= 16);
});
