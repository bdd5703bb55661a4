import assert from "node:assert/strict";
import { test } from "node:test";
import { parseProject } from "../src/state/project.ts";

const session = { version: 1, place: "#/bench", title: "mine", parts: { bench: { text: "title = 'mine'", before: [], after: [] } } };
const project = { format: "martensite project", version: 1, title: "mine", saved: "", session, files: {} };
const deep = (levels: number): unknown => (levels ? { a: deep(levels - 1) } : {});

test("a project comes back from its file", () => {
  assert.deepEqual(parseProject("a.martensite", JSON.stringify(project)), project);
});

test("what is no project, or none of this version, is refused in a sentence", () => {
  const whole = JSON.stringify(project);
  const wrong: [string, RegExp][] = [
    ["", /is no project of martensite\.$/],
    ["[element]\nkind = 'wire'", /is no project/],
    ["null", /is no project/],
    ["{}", /is no project/],
    [whole.slice(0, -5), /is cut or damaged/],
    [JSON.stringify({ ...project, version: 2 }), /newer version/],
    [JSON.stringify({ ...project, session: { ...session, parts: [] } }), /a part of it is missing or wrong/],
    [JSON.stringify({ ...project, session: { ...session, place: 3 } }), /a part of it/],
    [JSON.stringify({ ...project, session: { ...session, parts: { bench: { text: 3 } } } }), /a part of it/],
    [JSON.stringify({ ...project, files: { key: "x" } }), /a part of it/],
    [JSON.stringify({ ...project, session: { ...session, parts: deep(20) } }), /a part of it/],
  ];
  for (const [text, said] of wrong) assert.throws(() => parseProject("a.martensite", text), (error: Error) => said.test(error.message) && error.message.startsWith("“a.martensite”"));
});
