import assert from "node:assert/strict";
import { test } from "node:test";
import { guessHeading } from "../src/fit/headings.ts";
import { decodeText, readTable } from "../src/fit/text-table.ts";
import { siOf, toSi } from "../src/fit/units.ts";

const bytes = (text: string): Uint8Array => new TextEncoder().encode(text);
const meant = (heading: string, unit = ""): string => Object.values(guessHeading(heading, unit)).join(" ");

test("a German table behind lines of a device, with decimal commas and a row of units", () => {
  const text = "Prüfung 7;;\nGerät;X1;\n\nZeit;Kraft;Standardweg\ns;N;mm\n0;1,5;0,25\n0,1;1,6;0,5\n0,2;;0,75\nEnde;;\n";
  const found = readTable(decodeText("a.csv", bytes(text)), "auto");
  assert.deepEqual([found.separator, found.rows, found.commas], ["semicolon", 3, true]);
  assert.deepEqual(found.columns.map((one) => meant(one.heading, one.unit)), ["time s", "force N", "position mm"]);
  assert.deepEqual([...found.columns[1]!.numbers], [1.5, 1.6, NaN]);
  assert.deepEqual(found.notes, ["1 row without numbers is left out."]);
});

test("separators are told apart, and quoted cells read", () => {
  const kinds = ["t,x\n0,1\n1,2", "t\tx\n0,5\t1,5\n1,5\t2", "t x\n0.5 1\n1 2", '"time [s]","force, N"\n"0","1"\n"1","2"'];
  assert.deepEqual(kinds.map((text) => readTable(text, "auto").separator), ["comma", "tab", "whitespace", "comma"]);
  assert.equal(readTable(kinds[3]!, "auto").columns[1]!.heading, "force, N");
});

test("headings mean what the server takes them for", () => {
  const said = ["time [s]", "T_degC", "position (mm)", "temp (C)", "F/N", "U in V", "strain %", "protagonist.power [W]", "Channel A", "millis", "P"].map((one) => meant(one));
  assert.deepEqual(said, ["time s", "temperature degC", "position mm", "temperature degC", "force N", "voltage V", "strain %", "protagonist.power W", " ", "time ms", "power "]);
});

test("clocks become seconds, over midnight too; units become SI", () => {
  const found = readTable("clock,T\n23:59:59,20\n00:00:00.5,21\n00:00:02,22", "auto");
  assert.deepEqual([...found.columns[0]!.numbers], [86399, 86400.5, 86402]);
  assert.equal(siOf("degF"), "K");
  assert.ok(Math.abs(toSi(Float64Array.of(212), "degF")[0]! - 373.15) < 1e-9);
});

test("what is no table of text is left to the server in one sentence", () => {
  assert.throws(() => decodeText("a.xlsx", bytes("PK")), /read by the server/);
  assert.throws(() => decodeText("a.bin", Uint8Array.of(1, 0, 2)), /read by the server/);
  assert.throws(() => readTable("nothing here\nat all", "auto"), /No rows of numbers/);
});
