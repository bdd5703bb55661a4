import assert from "node:assert/strict";
import { before, describe, test } from "node:test";

/** An address line, as of a browser. */
const line = { hash: "" };
let remember: typeof import("../src/state/route.ts").remember;

// other files have addresses of their own
describe("addresses", () => {
  before(async () => {
    const history = { replaceState: (_: unknown, __: string, address: string) => void (line.hash = address) };
    Object.assign(globalThis, { location: line, history, addEventListener: () => undefined });
    ({ remember } = await import("../src/state/route.ts"));
  });

  test("an address without a page opens the start, and one with a scenario the bench", () => {
    for (const [hash, page] of [["", "start"], ["#/?scenario=x", "bench"]] as const) {
      line.hash = hash;
      remember(page, { scenario: "abc" });
      assert.equal(line.hash, `#/${page}?scenario=abc`);
    }
  });

  test("what a page remembers goes behind its own name", () => {
    line.hash = "#/size?force=3";
    remember("size", {});
    assert.equal(line.hash, "#/size");
  });

  test("a page that is being left does not take the address back", () => {
    line.hash = "#/sweep"; // the event that tells `place` comes later
    remember("bench", { scenario: "abc" });
    assert.equal(line.hash, "#/sweep");
  });
});
