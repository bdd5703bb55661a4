// Animated GIF: one palette by median cut, and of every picture only what is not as in the one before.
// Source: CompuServe, "Graphics Interchange Format, version 89a" (1990); P. Heckbert, SIGGRAPH 1982.

const BITS = 5;
const BINS = 1 << (3 * BITS);
/** The last colour is none: the pixel stays as it was. */
const COLOURS = 255;
const NONE = COLOURS;

const binOf = (r: number, g: number, b: number): number => ((r >> 3) << 10) | ((g >> 3) << 5) | (b >> 3);

interface Box {
  bins: number[];
  count: number;
}

/** Level of a channel (0: red) in a bin. */
const level = (bin: number, channel: number): number => (bin >> (BITS * (2 - channel))) & 31;

function widest({ bins }: Box): { channel: number; width: number } {
  let found = { channel: 0, width: -1 };
  for (let channel = 0; channel < 3; channel++) {
    let [low, high] = [31, 0];
    for (const bin of bins) {
      const value = level(bin, channel);
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (high - low > found.width) found = { channel, width: high - low };
  }
  return found;
}

/** Red, green, blue of at most 255 colours that stand for those of pictures (RGBA, 0 to 255). */
export function choosePalette(pictures: Uint8ClampedArray[]): Uint8Array {
  const counts = new Uint32Array(BINS);
  const sums = [new Float64Array(BINS), new Float64Array(BINS), new Float64Array(BINS)] as const;
  for (const picture of pictures) {
    for (let k = 0; k < picture.length; k += 4) {
      const [r, g, b] = [picture[k] as number, picture[k + 1] as number, picture[k + 2] as number];
      const bin = binOf(r, g, b);
      counts[bin] = (counts[bin] as number) + 1;
      [r, g, b].forEach((value, channel) => ((sums[channel] as Float64Array)[bin] = ((sums[channel] as Float64Array)[bin] as number) + value));
    }
  }
  const all = Array.from(counts.keys()).filter((bin) => counts[bin]);
  const boxes: Box[] = [{ bins: all, count: all.reduce((sum, bin) => sum + (counts[bin] as number), 0) }];
  while (boxes.length < COLOURS) {
    // where many pixels are far apart
    const score = (box: Box): number => (box.bins.length > 1 ? Math.cbrt(box.count) * widest(box).width : 0);
    const worst = boxes.reduce((a, b) => (score(b) > score(a) ? b : a));
    if (!score(worst)) break;
    boxes.splice(boxes.indexOf(worst), 1, ...halve(worst, counts));
  }
  const palette = new Uint8Array(3 * (COLOURS + 1));
  boxes.forEach(({ bins, count }, k) =>
    sums.forEach((sum, channel) => (palette[3 * k + channel] = Math.round(bins.reduce((a, bin) => a + (sum[bin] as number), 0) / count))),
  );
  return palette;
}

function halve({ bins, count }: Box, counts: Uint32Array): [Box, Box] {
  const { channel } = widest({ bins, count });
  const sorted = [...bins].sort((a, b) => level(a, channel) - level(b, channel));
  let [k, passed] = [0, 0];
  while (k < sorted.length - 1 && (k === 0 || passed + (counts[sorted[k] as number] as number) <= 0.5 * count)) passed += counts[sorted[k++] as number] as number;
  return [
    { bins: sorted.slice(0, k), count: passed },
    { bins: sorted.slice(k), count: count - passed },
  ];
}

export class Gif {
  private readonly bytes: number[] = [];
  private readonly parts: Uint8Array[] = [];
  private readonly nearest = new Int16Array(BINS).fill(-1);
  private before: Uint8Array | null = null;

  constructor(
    private readonly width: number,
    private readonly height: number,
    private readonly palette: Uint8Array,
  ) {
    this.text("GIF89a");
    this.words(width, height);
    this.bytes.push(0xf7, 0, 0, ...palette);
    this.bytes.push(0x21, 0xff, 11);
    this.text("NETSCAPE2.0");
    this.bytes.push(3, 1, 0, 0, 0);
  }

  /** Add a picture (RGBA, 0 to 255) that is shown for so many hundredths of a second. */
  add(picture: Uint8ClampedArray, hundredths: number): void {
    const now = new Uint8Array(this.width * this.height);
    const drawn = new Uint8Array(now.length);
    for (let k = 0; k < now.length; k++) {
      const colour = this.colourOf(picture[4 * k] as number, picture[4 * k + 1] as number, picture[4 * k + 2] as number);
      now[k] = colour;
      drawn[k] = this.before?.[k] === colour ? NONE : colour;
    }
    this.before = now;
    this.bytes.push(0x21, 0xf9, 4, 0x05);
    this.words(Math.round(hundredths));
    this.bytes.push(NONE, 0, 0x2c);
    this.words(0, 0, this.width, this.height);
    this.bytes.push(0, 8);
    this.blocks(packCodes(drawn));
    this.parts.push(Uint8Array.from(this.bytes.splice(0)));
  }

  finish(): Blob {
    this.bytes.push(0x3b);
    this.parts.push(Uint8Array.from(this.bytes.splice(0)));
    return new Blob(this.parts as BlobPart[], { type: "image/gif" });
  }

  private colourOf(r: number, g: number, b: number): number {
    const bin = binOf(r, g, b);
    const known = this.nearest[bin] as number;
    if (known >= 0) return known;
    let [best, least] = [0, Infinity];
    for (let k = 0; k < COLOURS; k++) {
      const [x, y, z] = [0, 1, 2].map((i) => this.palette[3 * k + i] as number) as [number, number, number];
      const away = (x - r) ** 2 + (y - g) ** 2 + (z - b) ** 2;
      if (away < least) [best, least] = [k, away];
    }
    this.nearest[bin] = best;
    return best;
  }

  private text(words: string): void {
    for (const letter of words) this.bytes.push(letter.charCodeAt(0));
  }

  private words(...values: number[]): void {
    for (const value of values) this.bytes.push(value & 255, value >> 8);
  }

  private blocks(data: number[]): void {
    for (let k = 0; k < data.length; k += 255) {
      const block = data.slice(k, k + 255);
      this.bytes.push(block.length);
      for (const byte of block) this.bytes.push(byte);
    }
    this.bytes.push(0);
  }
}

/** Bytes by the method of Lempel, Ziv and Welch with codes of 9 to 12 bits. */
export function packCodes(data: Uint8Array): number[] {
  const [clear, end] = [256, 257];
  const found: number[] = [];
  let [held, holds] = [0, 0];
  let [size, next] = [9, 258];
  const table = new Uint16Array(4096 * 256);
  const put = (code: number): void => {
    held |= code << holds;
    holds += size;
    while (holds >= 8) {
      found.push(held & 255);
      held >>>= 8;
      holds -= 8;
    }
  };
  put(clear);
  let code = data[0] ?? 0;
  for (let k = 1; k < data.length; k++) {
    const byte = data[k] as number;
    const known = table[(code << 8) | byte] as number;
    if (known) {
      code = known;
      continue;
    }
    put(code);
    if (next === 4096) {
      put(clear);
      table.fill(0);
      [size, next] = [9, 258];
    } else {
      // a code gets wider once the next one to be used would not fit
      if (next === 1 << size) size++;
      table[(code << 8) | byte] = next++;
    }
    code = byte;
  }
  put(code);
  put(end);
  if (holds) found.push(held & 255);
  return found;
}
