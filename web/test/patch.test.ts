// Source of truth: the form that the server describes has the value of the document, and all else as before.

import assert from "node:assert/strict";
import { test } from "node:test";
import { patchForm } from "../src/form/patch.ts";
import type { ScenarioForm } from "../src/form/types.ts";

const own = { sort: "scenario" };
const number = (path: string, origin: object) => ({ sort: "number", path, value: 300, display_unit: "degC", factor: 1, offset: -273.15, origin });
const FORM = {
  text: "old",
  sections: [
    { sort: "group", items: [number("environment.temperature", own), number("element.length", { sort: "default" })] },
    { sort: "group", items: [{ sort: "row", path: "drive.values", value: "1 W, 2 W", origin: own }] },
  ],
} as unknown as ScenarioForm;
const first = (form: ScenarioForm | null) => form?.sections[0]?.items[0] as unknown as { value: number };

test("numbers and lists that the document gives follow their changes; untouched groups stay the same", () => {
  const found = patchForm(FORM, { "environment.temperature": "40 degC" }, "new");
  assert.equal(first(found).value, 313.15);
  assert.equal(found?.text, "new");
  assert.equal(found?.sections[1], FORM.sections[1]);
  const row = patchForm(FORM, { "drive.values": ["2 W", "4 W"] }, "new")?.sections[1]?.items[0] as unknown as { value: string };
  assert.equal(row.value, "2 W, 4 W");
});

test("the server describes other units, values of a material, other kinds and unknown paths", () => {
  for (const changes of [{ "environment.temperature": "300 K" }, { "element.length": "2 degC" }, { "element.kind": "coil" }, { "environment.temperature": "4 degC", other: "2" }])
    assert.equal(patchForm(FORM, changes, "new"), null);
});
