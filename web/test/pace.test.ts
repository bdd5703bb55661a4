// Source of truth: the rules that pace.ts states, for a processor of a given cost per pixel.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Pace } from "../src/scene/pace.ts";

const HIGH = 400;

/** Draw after each of so many changes, and after each rest that no change ends; returns the pixels that were drawn. */
function draw(cost: number, pause: number, moves: number): { pixels: number; full: number; last: number } {
  const pace = new Pace();
  let [pixels, full, last] = [0, 0, 0];
  const picture = (now: number, isMoving: boolean): void => {
    const how = pace.begin(now, isMoving, HIGH);
    pace.end(cost * how.pixels ** 2, how.pixels);
    pixels += how.pixels ** 2;
    full += isMoving ? 0 : 1;
    last = how.pixels;
  };
  picture(0, false);
  for (let k = 1; k <= moves; k++) {
    const now = k * pause;
    pace.change(now);
    picture(now, true);
    const rest = pace.rest;
    if (rest !== null && (rest < pause || k === moves)) picture(now + rest, false);
  }
  return { pixels, full, last };
}

test("a dear picture is coarse while moves follow each other, however slowly, and has all pixels at the end", () => {
  for (const pause of [200, 600, 1500]) {
    const { pixels, full, last } = draw(200, pause, 20);
    assert.equal(last, 1);
    assert.ok(full <= 4, `${full} full pictures, ${pause} ms between moves`);
    assert.ok(pixels < 0.5 * 20, `${pixels} pictures' worth of pixels`);
  }
});

test("no picture has more pixels than the page, and a cheap one always has as many", () => {
  assert.deepEqual(draw(10, 200, 20).last, 1);
  assert.ok(draw(10, 200, 20).pixels <= 22);
});

test("the rest is at least three costs, and nothing is drawn again that lacks nothing", () => {
  const pace = new Pace();
  pace.begin(0, false, HIGH);
  pace.end(500, 1);
  assert.equal(pace.rest, null);
  pace.change(5000);
  pace.begin(5000, true, HIGH);
  assert.ok((pace.rest ?? 0) >= 1500);
});

test("a picture of few rows keeps them, so that a wire is as thick as a pixel", () => {
  const pace = new Pace();
  pace.end(1000, 1);
  const rows = [150, 200, 400].map((height) => height * pace.begin(0, true, height).pixels);
  assert.deepEqual(rows, [150, 150, 200]);
});
