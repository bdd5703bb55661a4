// A slider in motion: what is asked for meanwhile, and when it rests.

import assert from "node:assert/strict";
import { mock, test } from "node:test";

/** Everything that is under way is answered. */
const settled = async (): Promise<void> => {
  for (let k = 0; k < 5; k++) await new Promise((done) => setImmediate(done));
};

test("a slider in motion is run again and again, and its form is asked for once it rests", async () => {
  const history = { replaceState: () => undefined };
  Object.assign(globalThis, { window: globalThis, location: { hash: "#/bench" }, history, addEventListener: () => undefined });
  mock.timers.enable({ apis: ["setTimeout"] });
  const { setHost } = await import("../src/lib/host.ts");
  const asked: string[] = [];
  const none = { rows: [], choices: [] };
  const views = { lines: { ...none, numbers: {}, ports: [] }, motor: { ...none, resonance: null }, scene: { ...none, shapes: [], ports: {}, newton: -1, sentence: "" } };
  const answers: Record<string, (request: { text: string; changes: object }) => object> = {
    run: ({ changes }) => ({ text: `made of ${JSON.stringify(changes)}`, times: [0, 1], columns: {}, parameters: {}, views }),
    form: ({ text }) => ({ text, sections: [] }),
  };
  setHost({
    call: async (name, request) => (asked.push(name), answers[name]!(request as { text: string; changes: object })),
    file: () => Promise.reject(new Error()),
    asset: () => Promise.reject(new Error()),
  });
  const { followForm, slide } = await import("../src/form/state.ts");
  const { text } = await import("../src/state/scenario.ts");
  const leave = followForm();
  text.value = "the first";
  mock.timers.tick(0);
  await settled();
  assert.deepEqual(asked, ["form"]);
  for (let k = 1; k <= 5; k++) {
    slide("load", `${k} N`);
    await settled();
    mock.timers.tick(30);
    await settled();
  }
  assert.deepEqual(asked.slice(1), Array<string>(5).fill("run"));
  assert.match(text.value, /5 N/);
  mock.timers.tick(300);
  await settled();
  assert.equal(asked.at(-1), "form");
  assert.equal(asked.length, 7);
  leave();
});
