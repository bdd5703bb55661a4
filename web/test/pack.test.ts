import assert from "node:assert/strict";
import { test } from "node:test";
import { packed, unpacked } from "../src/lib/pack.ts";

const TEXT = 'title = "Ω wire"\n[run]\nduration = "60 s"\n';
/** The same, packed by martensite.cli.commands.web_bench. */
const FROM_PYTHON = "K8ksyUlVsFVQOrdSoTyzKFWJK7qoNC-WK6W0KLEkMz8PJGVmoFCsxAUA";

test("a text comes back from its letters", async () => {
  for (const text of [TEXT, "", "x".repeat(100_000), "ξ–T 😀"]) {
    const letters = await packed(text);
    assert.match(letters, /^[A-Za-z0-9_-]*$/);
    assert.equal(await unpacked(letters), text);
  }
});

test("letters that the command line made are read", async () => {
  assert.equal(await unpacked(FROM_PYTHON), TEXT);
});

test("letters that are none are refused", async () => {
  await assert.rejects(unpacked("!!!"));
  await assert.rejects(unpacked("AAAA"));
});
