import assert from "node:assert/strict";
import { test } from "node:test";
import { packed, packLink, unpackLink } from "../src/lib/pack.ts";

const TEXT = 'title = "Ω wire"\n[run]\nduration = "60 s"\n';
const PIN = { id: 1, name: "1: Ω wire", text: TEXT.replace("60", "90") };
const LINK = { text: TEXT, parts: { runs: { cursor: 1.5, pins: [PIN] }, view: { zoom: [1, 2] } } };

test("a link brings scenario, pinned runs, cursor and view", async () => {
  assert.deepEqual(await unpackLink(await packLink(LINK)), LINK);
});

test("links of the command line, and of before, hold the bare text", async () => {
  for (const text of [TEXT, "x", "title = 'e'"]) {
    const letters = await packed(text);
    assert.notEqual(letters[0], "e");
    assert.deepEqual(await unpackLink(letters), { text, parts: {} });
  }
});

test("pinned runs are like the scenario and cost little", async () => {
  const more = { ...LINK, parts: { runs: { pins: [1, 2, 3].map((id) => ({ ...PIN, id })) } } };
  assert.ok((await packLink(more)).length < 1.8 * (await packLink({ text: TEXT, parts: {} })).length);
});

test("a link that is cut anywhere, or has a wrong letter, is refused", async () => {
  const letters = await packLink(LINK);
  for (let end = 0; end < letters.length; end++) await assert.rejects(unpackLink(letters.slice(0, end)), `cut at ${end}`);
  let changed = 0;
  for (let k = 1; k < letters.length - 1; k++) {
    const other = letters[k] === "A" ? "B" : "A";
    await assert.rejects(unpackLink(letters.slice(0, k) + other + letters.slice(k + 1)), `changed at ${k}`);
    changed += 1;
  }
  assert.ok(changed > 100);
  const old = await packed(TEXT);
  for (let end = 0; end < old.length - 1; end++) await assert.rejects(unpackLink(old.slice(0, end)), `old one cut at ${end}`);
});
