// The animation as a file: pictures of a stage of its own, as the one on the page is seen now.

import { startWorker } from "../lib/host.ts";
import type { Palette } from "../lib/theme.ts";
import type { Run } from "../lib/types.ts";
import type { Asked } from "./gif.worker.ts";
import type { Picture } from "../plots/picture.ts";
import { chooseLoop, drawLoop } from "./film-loop.ts";
import { paintWords } from "./labels.ts";
import { choosePaints } from "./reading.ts";
import { Stage, type Reading } from "./stage.ts";

export type Taken = "gif" | "video" | "glb";

export interface Recorded {
  run: Run;
  ghost: Run | null;
  whole: boolean;
  read: (time: number) => Reading;
  stage: Stage;
  palette: Palette;
  /** Length of the file [s]. */
  seconds: number;
  told: (share: number) => void;
  stop: AbortSignal;
}

const SIZES = { gif: [640, 360], video: [1280, 720] } as const;
/** Pixels that are drawn for one of the file, across: more makes edges smooth. */
const FINE = { gif: 1.5, video: 1 };
/** Pictures of a GIF each second: browsers show no more than 50, and every one costs. */
const RATE = 10;
/** Width of the page's picture that words in a file are as large as in [px]. */
const WIDE = 720;
/** Share of the width that the mechanism has beside a loop, and of the height above and below the loop. */
const [MECHANISM, TOP] = [0.56, 0.12];
const VIDEOS = ["video/mp4;codecs=avc1.42E01F", "video/mp4", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

/** The kind of video that this browser can make; none if it cannot. */
export const videoKind = (): string =>
  typeof MediaRecorder === "undefined" ? "" : VIDEOS.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? "";

/** Draws the mechanism with its words at any share of the run. */
class Painter {
  readonly canvas = document.createElement("canvas");
  readonly context: CanvasRenderingContext2D;
  private readonly host = document.createElement("div");
  private readonly stage: Stage;
  /** The loop beside the mechanism, and the width of the latter [px]. */
  private readonly loop: Picture | null;
  private readonly across: number;

  constructor(
    private readonly asked: Recorded,
    readonly width: number,
    readonly height: number,
    fine: number,
  ) {
    Object.assign(this.canvas, { width, height });
    this.context = this.canvas.getContext("2d", { willReadFrequently: true }) as CanvasRenderingContext2D;
    // words are as large as on the page whatever the size of the file
    this.loop = chooseLoop(asked.run);
    this.across = this.loop ? MECHANISM * width : width;
    const scale = width / WIDE;
    Object.assign(this.host.style, { position: "fixed", left: "-9999px", width: `${this.across / scale}px`, height: `${height / scale}px` });
    document.body.append(this.host);
    this.stage = new Stage(this.host, fine * scale);
    this.stage.paint(choosePaints(asked.palette));
    this.stage.show(asked.run.scene, asked.ghost?.scene ?? null, asked.whole);
    this.stage.follow(asked.stage);
  }

  draw(share: number): void {
    const { run, read, palette } = this.asked;
    const [first = 0, last = 0] = [run.times[0], run.times.at(-1)];
    const time = first + share * (last - first);
    this.stage.put(time, read(time));
    const { canvas, words } = this.stage.render();
    const { context, width, height } = this;
    const scale = width / WIDE;
    context.fillStyle = palette.panel;
    context.fillRect(0, 0, width, height);
    context.drawImage(canvas, 0, 0, this.across, height);
    paintWords(context, words, palette.ink, palette.panel, scale);
    const clock = { text: `${time.toFixed(last < 10 ? 2 : 1)} s`, x: 34, y: height / scale - 16, kind: "name" as const };
    paintWords(context, [clock], palette.soft, palette.panel, scale);
    if (this.loop) this.drawLoop(this.loop, time, scale);
  }

  private drawLoop(loop: Picture, time: number, scale: number): void {
    const { context, across, width, height } = this;
    const { run, palette } = this.asked;
    const after = run.times.findIndex((one) => one > time);
    const row = after < 0 ? run.times.length - 1 : Math.max(after - 1, 0);
    context.save();
    context.translate(across, TOP * height);
    context.scale(scale, scale);
    context.textAlign = "left";
    drawLoop(context, loop, row, (width - across) / scale - 8, ((1 - 2 * TOP) * height) / scale, palette);
    context.restore();
  }

  get picture(): Uint8ClampedArray {
    return this.context.getImageData(0, 0, this.width, this.height).data;
  }

  dispose(): void {
    this.stage.dispose();
    this.host.remove();
  }
}

const breath = (): Promise<void> => new Promise((done) => setTimeout(done));

export async function recordGif(asked: Recorded): Promise<Blob> {
  const [width, height] = SIZES.gif;
  const painter = new Painter(asked, width, height, FINE.gif);
  const worker = await startWorker("gif.js");
  const ask = (message: Asked): Promise<Blob | null> =>
    new Promise((done, failed) => {
      worker.onmessage = ({ data }) => done(data as Blob | null);
      worker.onerror = () => failed(new Error("The GIF could not be made: its worker did not start."));
      worker.postMessage(message);
    });
  try {
    const samples = [0, 0.25, 0.5, 0.75, 1].map((share) => {
      painter.draw(share);
      return painter.picture;
    });
    await ask({ kind: "begin", width, height, samples });
    const count = Math.max(2, Math.round(RATE * asked.seconds));
    let before: Promise<unknown> = Promise.resolve();
    for (let k = 0; k < count; k++) {
      asked.stop.throwIfAborted();
      painter.draw(k / (count - 1));
      await before;
      before = ask({ kind: "add", picture: painter.picture, hundredths: 100 / RATE });
      asked.told(k / count);
      await breath();
    }
    await before;
    return (await ask({ kind: "finish" })) as Blob;
  } finally {
    worker.terminate();
    painter.dispose();
  }
}

/** In real time: a browser's recorder takes the time that passes as that of the video. */
export async function recordVideo(asked: Recorded): Promise<Blob> {
  const kind = videoKind();
  if (!kind) throw new Error("This browser records no video; a GIF can be saved instead.");
  const [width, height] = SIZES.video;
  const painter = new Painter(asked, width, height, FINE.video);
  try {
    painter.draw(0);
    const stream = painter.canvas.captureStream(30);
    const recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: 6e6 });
    const parts: Blob[] = [];
    recorder.ondataavailable = ({ data }) => void parts.push(data);
    const ended = new Promise<void>((done, failed) => {
      recorder.onstop = () => done();
      recorder.onerror = () => failed(new Error("The browser's recorder failed."));
    });
    recorder.start();
    const begun = performance.now();
    for (let share = 0; share < 1; ) {
      asked.stop.throwIfAborted();
      share = Math.min((performance.now() - begun) / (1000 * asked.seconds), 1);
      painter.draw(share);
      asked.told(share);
      await new Promise((done) => setTimeout(done, 16));
    }
    recorder.stop();
    await ended;
    stream.getTracks().forEach((track) => track.stop());
    return new Blob(parts, { type: kind.split(";")[0] ?? kind });
  } finally {
    painter.dispose();
  }
}
