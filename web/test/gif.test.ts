// A GIF is read again by what its specification says, with nothing of what has written it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { choosePalette, Gif, packCodes } from "../src/scene/gif.ts";

/** Codes of 9 to 12 bits, as a reader has to follow them. */
function unpack(bytes: number[]): number[] {
  let [held, holds, at, size] = [0, 0, 0, 9];
  const found: number[] = [];
  let words: number[][] = [];
  let before: number[] | null = null;
  for (;;) {
    while (holds < size) {
      held |= (bytes[at++] ?? 0) << holds;
      holds += 8;
    }
    const code = held & ((1 << size) - 1);
    held >>>= size;
    holds -= size;
    if (code === 257) return found;
    if (code === 256) {
      words = Array.from({ length: 258 }, (_, k) => [k]);
      [size, before] = [9, null];
      continue;
    }
    const word: number[] = words[code] ?? [...(before as number[]), (before as number[])[0] as number];
    if (before) words.push([...before, word[0] as number]);
    if (words.length === 1 << size && size < 12) size++;
    found.push(...word);
    before = word;
  }
}

test("what is packed comes back, over more codes than a table holds", () => {
  let seed = 1;
  const noise = Uint8Array.from({ length: 60_000 }, (_, k) => (k % 3000 < 1000 ? 7 : (seed = (16807 * seed) % 2147483647) & 255));
  assert.deepEqual(unpack(packCodes(noise)), [...noise]);
});

test("colours are within a level of those of the picture, and what stays is sent as none", async () => {
  const [width, height] = [16, 8];
  const picture = Uint8ClampedArray.from({ length: 4 * width * height }, (_, k) => (k % 4 === 3 ? 255 : ((k >> 2) * 2 + 40 * (k % 4)) & 255));
  const palette = choosePalette([picture]);
  const gif = new Gif(width, height, palette);
  gif.add(picture, 10);
  const once = gif.finish().size;
  gif.add(picture, 10);
  const bytes = new Uint8Array(await gif.finish().arrayBuffer());
  assert.equal(new TextDecoder().decode(bytes.slice(0, 6)), "GIF89a");
  assert.deepEqual([...bytes.slice(6, 10)], [width, 0, height, 0]);
  const image = bytes.indexOf(0x2c, 13 + 768);
  const length = bytes[image + 11] as number;
  const pixels = unpack([...bytes.slice(image + 12, image + 12 + length)]);
  assert.equal(pixels.length, width * height);
  pixels.forEach((colour, k) => {
    for (let i = 0; i < 3; i++) assert.ok(Math.abs((palette[3 * colour + i] as number) - (picture[4 * k + i] as number)) < 8);
  });
  assert.ok(bytes.length - once < 60, "an unchanged picture costs next to nothing");
});
