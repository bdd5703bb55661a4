// Answers with columns as binary: those that Python packs (`tests/app/test_transfer.py` holds the same letters).

import assert from "node:assert/strict";
import { test } from "node:test";
import { unpackColumns } from "../src/lib/columns.ts";

const PACKED =
  "ugAAAHsidGl0bGUiOiLOviIsInNob3J0IjpbMSwyLjUsbnVsbF0sImZsYWdzIjpbdHJ1ZSx0cnVlLHRydWUsdHJ1ZSx0cnVlLHRydWUsdHJ1ZSx0cnVlLHRydWUsdHJ1ZSx0cnVlLHRydWUsdHJ1ZSx0cnVlLHRydWUsdHJ1ZV0sImNvbHVtbnMiOnsiYSI6eyIkbnVtYmVycyI6WzAsMTZdfSwiYiI6eyIkbnVtYmVycyI6WzE2LDE3XX19fQAAAAAAAAAAAAAAAAAAAAAAAABZWVlZWVlZWVlZWVlZWQAAAAAAAAAAAAAAAAAAAAAAAADz8/Pz8/Pz8/Pz8/Pz8wAAAAAAAAAAAAAAAAAAAAAAAAD4+Pj4+Pj4+Pj4+Pj4+AAAAAAAAAAAAAAAAAAAAAAAAADCwsLCwsLCwsLCwsLCwgAAAAAAAAAAAAAAAAAAAAAAAAAfHx8fHx8fHx8fHx8fHwAAAAAAAAAAAAAAAAAAAAAAAABubm5ubm5ubm5ubm5ubvDs6OTg2NDAAMDQ2ODk6Oz48AilpaWlpaWlpaWlpaWlpb+/v7+/v7+/AD8/Pz8/Pz9/f0ABAQEBAQEBAQEBAQEBAQ==";

const body = (letters: string): ArrayBuffer => Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0)).buffer;

test("what Python packed is read", () => {
  const found = unpackColumns(body(PACKED)) as Record<string, unknown> & { columns: Record<string, (number | null)[]> };
  assert.equal(found["title"], "ξ");
  assert.deepEqual(found["short"], [1, 2.5, null]);
  assert.deepEqual(found["flags"], Array(16).fill(true));
  assert.deepEqual(found.columns["a"], Array.from({ length: 16 }, (_, k) => k / 8 - 1));
  assert.deepEqual(found.columns["b"], [null, null, 3, ...Array<number>(14).fill(1e-300)]);
});

test("a body that is cut is no answer", () => {
  assert.throws(() => unpackColumns(body(PACKED).slice(0, 40)));
});
