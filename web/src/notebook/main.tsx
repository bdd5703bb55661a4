// The bench in a frame of a notebook. The frame keeps its styles and addresses apart from those of the notebook;
// a port leads to the widget around it. `loader.ts` loads this module from the kernel.

import { effect } from "@preact/signals";
import { render } from "preact";
import { setHost } from "../lib/host.ts";
import { Page } from "../pages/bench.tsx";
import { change, text } from "../state/scenario.ts";
import { Kernel, type Question, type Reply } from "./kernel.ts";

/** From the widget: what it shows, or an answer of the kernel. */
export type Told = { text?: string; dark?: boolean } | { reply: Reply };
/** To the widget: a question, or the scenario as it is now. */
export type Said = { ask: Question } | { text: string };

/** The scenario as the widget has it. */
let known = "";
let begun = false;

function begin(say: (said: Said) => void): void {
  begun = true;
  effect(() => {
    if (!text.value || text.value === known) return;
    known = text.value;
    say({ text: known });
  });
  const root = document.getElementById("page")!;
  root.textContent = "";
  render(<main id="main"><Page /></main>, root);
}

/** Show what the widget sends through a port; `before` has been sent already. */
export function follow(port: MessagePort, before: Told[]): void {
  const say = (said: Said): void => port.postMessage(said);
  const kernel = new Kernel((ask) => say({ ask }));
  setHost(kernel);
  const hear = (data: Told): void => {
    if ("reply" in data) return kernel.hear(data.reply);
    if (data.dark !== undefined) {
      document.documentElement.dataset["theme"] = data.dark ? "dark" : "light";
      dispatchEvent(new Event("martensite-theme"));
    }
    if (data.text) change((known = data.text));
    if (!begun) begin(say);
  };
  before.forEach(hear);
  port.onmessage = ({ data }: MessageEvent<Told>) => hear(data);
}
