// Charts without a page: scales, what is under the pointer, what is drawn and saved.

import assert from "node:assert/strict";
import { test } from "node:test";
import { drawPicture } from "../src/plots/drawing.ts";
import { lookAt, nearestIn, stepFrom } from "../src/plots/hover.ts";
import { nearestRow } from "../src/plots/nearest.ts";
import { boxOf, edges, scaleOfLevels, type Picture, type Spot } from "../src/plots/picture.ts";
import { around, between, magnify, share, ticks, tickText, valueAt } from "../src/plots/scale.ts";
import { writeNumbers } from "../src/plots/table.ts";
import { VectorPen } from "../src/plots/vector.ts";

const LOOK = { colour: 0, dash: [], width: 1 };
const COLOURS = { curves: ["rgb(1, 2, 3)"], ink: "black", soft: "gray", line: "silver", panel: "white", accent: "rgb(9, 9, 9)", bad: "red" };
const near = (found: number, wanted: number, within = 1e-9): void => assert.ok(Math.abs(found - wanted) <= within, `${found} is not ${wanted}`);

const times = Array.from({ length: 101 }, (_, k) => k / 10);
const line: Picture = {
  x: { label: "t [s]", low: 0, high: 10 },
  y: { label: "T [°C]", low: 0, high: 100 },
  along: true,
  curves: [
    { x: times, y: times.map((t) => 10 * t), look: LOOK },
    { x: times, y: times.map((t) => (t < 5 ? NaN : 20)), look: LOOK, name: "pinned" },
  ],
};

/** Words of a drawn picture, with their places. */
function wordsOf(picture: Picture): { text: string; x: number; y: number }[] {
  const pen = new VectorPen();
  drawPicture(pen, picture, 400, 250, COLOURS);
  const svg = pen.document(400, 250, "");
  return [...svg.matchAll(/<text x="([-\d.]+)" y="([-\d.]+)"[^>]*>([^<]+)</g)].map(([, x, y, text]) => ({ text: text!, x: Number(x), y: Number(y) }));
}

test("names of lines that lie on each other stand side by side, and each line has a name in the chart", () => {
  const side = (name: string, x: number[], y: number[]) => ({ name, x, y, dash: [] });
  const strips = [
    { colour: 0, sides: [side("M_s", [47, 97], [0, 200]), side("M_f", [46.9, 96.9], [0, 200])] },
    { colour: 0, sides: [side("sigma_s", [7, 47], [51, 50]), side("sigma_f", [7, 47], [51.02, 50.02])] }, // it begins left of the chart
  ];
  const found = wordsOf({ x: { label: "temperature", low: 20, high: 100 }, y: { label: "stress", low: 0, high: 200 }, curves: [], strips });
  const letters = found.filter(({ text }) => text === "M" || text === "σ");
  assert.equal(letters.length, 4);
  for (const [k, one] of letters.entries()) {
    assert.ok(one.x > 40 && one.x < 392 && one.y > 0, `${one.text} is at ${one.x}, ${one.y}`);
    for (const other of letters.slice(k + 1)) assert.ok(Math.abs(one.x - other.x) > 15 || Math.abs(one.y - other.y) > 11);
  }
});

test("limits hold all values, and a constant is seen as one", () => {
  const { low, high } = around("", [[1, NaN, 3], [2]], 0.1, [0]);
  near(low, -0.3);
  near(high, 3.3);
  const flat = around("", [[5, 5]]);
  assert.ok(flat.low < 4.9 && flat.high > 5.1);
  assert.deepEqual(around("", [[NaN]]), { label: "", low: 0, high: 1 });
  const log = around("", [[1, 100]], 0.5, [], true);
  near(log.low, 0.1);
  near(log.high, 1000, 1e-9 * 1000);
});

test("shares and values are each other's inverse", () => {
  for (const scale of [{ label: "", low: -3, high: 7 }, { label: "", low: 0.01, high: 10, log: true }]) {
    for (const part of [0, 0.3, 1]) near(share(scale, valueAt(scale, part)), part);
  }
  assert.equal(share({ label: "", low: 2, high: 2 }, 2), 0.5);
});

test("ticks are round numbers inside of the limits, told apart", () => {
  assert.deepEqual(ticks({ label: "", low: -0.07, high: 1.07 }, 4), [0, 0.5, 1]);
  assert.deepEqual(ticks({ label: "", low: 0.5, high: 2000, log: true }, 9), [1, 10, 100, 1000]);
  const fine = ticks({ label: "", low: 1000.0001, high: 1000.0009 }, 4);
  const words = fine.map((tick) => tickText(tick, fine[1]! - fine[0]!));
  assert.equal(new Set(words).size, fine.length);
  const large = ticks({ label: "", low: 1e6, high: 1e6 + 4 }, 4);
  assert.equal(new Set(large.map((tick) => tickText(tick, 1))).size, 5);
  assert.deepEqual([0, 1e-7, 250000].map((value) => tickText(value)), ["0", "1e-7", "2.5e5"]);
});

test("magnifying keeps what is under the pointer, stays inside, and ends with all", () => {
  const whole = { label: "", low: 0, high: 10 };
  const once = magnify(whole, whole, 0.3, 0.5)!;
  near(valueAt(once, 0.3), 3);
  near(once.high - once.low, 5);
  assert.equal(magnify(whole, once, 0.3, 4), null);
  const corner = magnify(whole, { label: "", low: 0, high: 2 }, 1, 2)!;
  near(corner.low, 0);
  near(corner.high, 4);
  const small = { label: "", low: 1, high: 1 + 1e-6 };
  assert.equal(magnify(whole, small, 0.5, 0.5), small);
  assert.deepEqual(between(whole, 0.8, 0.2), { label: "", low: 2, high: 8 });
});

test("over time all curves tell their value at the sample under the pointer", () => {
  const found = lookAt(line, { width: 200, height: 100 }, 121, 40)!;
  assert.equal(found.x, 6.1); // 6.05 s lies between two samples; the nearer curve is taken
  assert.deepEqual(found.lines.map(({ words }) => words), ["t = 6.1 s", "T = 61 °C", "pinned = 20 °C"]);
  const early = lookAt(line, { width: 200, height: 100 }, 40, 0)!;
  assert.deepEqual(early.lines.map(({ words }) => words), ["t = 2 s", "T = 20 °C"]);
  assert.equal(nearestIn(times, -5), 0);
  assert.equal(nearestIn(times, 99), 100);
  assert.equal(nearestIn(times, 3.14), 31);
});

test("keys go from sample to sample, over gaps, and from curve to curve", () => {
  const first = stepFrom(line, null, [1, 0])!;
  assert.equal(first.x, 5); // the last curve begins there
  assert.equal(stepFrom(line, first, [10, 0])!.x, 6);
  const other = stepFrom(line, first, [0, 1])!;
  assert.deepEqual([other.curve, other.x, other.y], [0, 5, 50]);
  assert.equal(stepFrom(line, { ...other, index: 100 }, [1, 0])?.x ?? 10, 10);
});

test("a point of a loop is found by distance on the screen, not along", () => {
  const loop: Picture = { ...line, along: false, curves: [{ x: [0, 10, 10, 0], y: [0, 0, 100, 100], look: LOOK }] };
  assert.equal(lookAt(loop, { width: 200, height: 100 }, 195, 4)!.index, 2);
  assert.equal(lookAt(loop, { width: 200, height: 100 }, 100, 50), null);
  const marks = [{ x: [0, 10, 10, 0], y: [0, 0, 100, 100], colour: 0 }];
  assert.equal(nearestRow(marks, 9, 80, 10, 100), 2);
});

const spots: Spot[] = [1, 2, 4].flatMap((x, ix) => [10, 20].map((y, iy) => ({ row: 2 * ix + iy, x, y, ix, iy, value: ix === 1 ? null : x * y, state: ix === 1 ? "failed" : "ok" }) as Spot));
const map: Picture = {
  x: scaleOfLevels("d [mm]", [1, 2, 4], true), y: scaleOfLevels("P [W]", [10, 20], false), curves: [], spots,
  cells: { xs: [1, 2, 4], ys: [10, 20] }, colour: { label: "stroke [mm]", low: 10, high: 80 },
};

test("cells are found by their limits, half-way between levels, also when zoomed", () => {
  assert.deepEqual(edges(map.x, [1, 2, 4]).map((one) => Math.round(1000 * one) + 0), [0, 333, 667, 1000]);
  const found = lookAt(map, { width: 300, height: 100 }, 250, 20)!;
  assert.deepEqual([found.spot!.row, found.lines.at(-1)!.words], [5, "stroke = 80 mm"]);
  assert.match(lookAt(map, { width: 300, height: 100 }, 150, 20)!.lines.at(-1)!.words, /failed/);
  const part = { ...map, x: between(map.x, 2 / 3, 1) };
  assert.equal(lookAt(part, { width: 300, height: 100 }, 10, 20)!.spot!.row, 5);
  assert.equal(stepFrom(map, found, [-1, 0])!.spot!.row, 3);
  assert.equal(stepFrom(map, found, [1, 0]), null);
});

test("a curve is drawn where its values are", () => {
  const pen = new VectorPen();
  drawPicture(pen, line, 270, 148, COLOURS);
  const box = boxOf(line, 270, 148);
  assert.deepEqual(box, { left: 60, top: 6, width: 200, height: 100 });
  const text = pen.document(270, 148, "A < B");
  assert.match(text, /<title>A &#60; B<\/title>/);
  const [path = ""] = /d="(M60 106L[^"]*)" fill="none" stroke="rgb\(1, 2, 3\)"/.exec(text)?.slice(1) ?? [];
  assert.ok(path.endsWith("L260 6"), path);
  assert.equal(path.split("L").length, 101);
  assert.match(text, /M160 86L/); // the pinned one begins in the middle
  const other = new VectorPen();
  drawPicture(other, { ...line, y: { ...line.y, high: 200 } }, 270, 148, COLOURS);
  assert.ok(!other.document(270, 148, "").includes(path)); // it can fail
});

test("cells have colours, failed ones are hatched and lie within a clip", () => {
  const pen = new VectorPen();
  drawPicture(pen, map, 440, 148, COLOURS);
  const text = pen.document(440, 148, "");
  assert.equal((text.match(/fill="rgb\(253 231 37\)"/g) ?? []).length >= 1, true);
  assert.match(text, /stroke="red" stroke-width="1.5" clip-path="url\(#part-\d+\)"/);
});

test("numbers are saved in columns; gaps are empty cells", () => {
  const rows = writeNumbers({ ...line, curves: line.curves.map((one) => ({ ...one, part: undefined })) as never }).split("\n");
  assert.equal(rows[0], 't [s],T [°C],"pinned, T [°C]"');
  assert.equal(rows[1], "0,0,");
  assert.equal(rows[101], "10,100,20");
  const cells = writeNumbers(map).split("\n");
  assert.deepEqual([cells[0], cells[3]], ["d [mm],P [W],stroke [mm],state", "2,10,,failed"]);
});

test("of what lies closer than a hair one point is drawn, and peaks and ends stay", () => {
  const x = Array.from({ length: 10_001 }, (_, k) => k / 1000);
  const y = x.map((t, k) => (k === 5000 ? 90 : 10 * t));
  const points: [number, number][] = [];
  const pen = new Proxy({} as VectorPen, {
    get: (_, name) => (name === "lineTo" ? (px: number, py: number) => points.push([px, py]) : name === "measureText" ? () => ({ width: 5 }) : () => undefined),
    set: () => true,
  });
  drawPicture(pen, { ...line, curves: [{ x, y, look: LOOK }] }, 266, 148, COLOURS);
  const box = boxOf(line, 266, 148);
  const at = (t: number, value: number): [number, number] => [box.left + (t / 10) * box.width, box.top + (1 - value / 100) * box.height];
  assert.ok(points.length < 1000, `${points.length} points`);
  for (const [px, py] of [at(5, 90), at(10, 100)]) assert.ok(points.some(([a, b]) => Math.hypot(a - px, b - py) < 1e-6));
});
