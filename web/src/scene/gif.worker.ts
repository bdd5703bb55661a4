// Makes a GIF beside the page: first some pictures to choose colours by, then all, then the file.

import { choosePalette, Gif } from "./gif.ts";

export type Asked =
  | { kind: "begin"; width: number; height: number; samples: Uint8ClampedArray[] }
  | { kind: "add"; picture: Uint8ClampedArray; hundredths: number }
  | { kind: "finish" };

let made: Gif | null = null;

addEventListener("message", ({ data }: MessageEvent<Asked>) => {
  if (data.kind === "begin") made = new Gif(data.width, data.height, choosePalette(data.samples));
  else if (data.kind === "add") made?.add(data.picture, data.hundredths);
  // answers to every message, so that pictures do not pile up
  postMessage(data.kind === "finish" ? made?.finish() : null);
});
