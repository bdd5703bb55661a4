// The questions that people come with, and where each of them leads.

import { signal } from "@preact/signals";
import { chosenControls } from "../form/pinned.ts";
import { call, sentence } from "../lib/api.ts";
import { pin, pinned, run, unpin } from "../state/run.ts";
import { openInBench, text } from "../state/scenario.ts";

export interface Door {
  key: string;
  title: string;
  about: string;
  /** Packaged scenario that is put on the bench; empty for a page of its own. */
  scenario: string;
  page: string;
}

export const DOORS: Door[] = [
  { key: "lift", title: "Lift a weight", about: "A heated wire lifts 300 g and lets it down. How far, how fast, how hot?", scenario: "dead_weight", page: "bench" },
  { key: "finger", title: "Bend a finger", about: "A tendon of wire bends a joint against a spring, and cools to let it go.", scenario: "finger", page: "bench" },
  { key: "hold", title: "Hold a position", about: "A controller moves a wire in steps of one millimetre and holds each position.", scenario: "closed_loop", page: "bench" },
  { key: "log", title: "I have a log", about: "Fit a material to your measurement, or to a sample log.", scenario: "", page: "identify" },
  { key: "wire", title: "Which wire?", about: "Find wires of the catalogue for a force, a stroke and a rate.", scenario: "", page: "size?example" },
  { key: "paper", title: "Check a paper", about: "Published results compared with new computations.", scenario: "", page: "studies" },
];

/** Why a door did not open. */
export const shut = signal("");

/** The pin that a door made: the run as it was found, with which later ones are compared. */
let found = 0;

/** Put the scenario of a door on the bench; its first run is pinned. */
export async function openDoor(name: string): Promise<void> {
  shut.value = "";
  try {
    const { scenarios } = await call<{ scenarios: { name: string; text: string }[] }>("scenarios");
    const document = scenarios.find((one) => one.name === name)?.text;
    if (!document) throw new Error(`There is no packaged scenario “${name}” here.`);
    if (found) unpin(found);
    chosenControls.value = {};
    pinWhenRun(document);
    openInBench(document);
  } catch (error) {
    shut.value = sentence(error);
  }
}

/** Pin the run of a document once it is there, unless another document comes before. */
function pinWhenRun(document: string): void {
  const keep = (): void => {
    pin();
    found = pinned.value.at(-1)?.id ?? 0;
    const last = pinned.value.at(-1);
    if (last) pinned.value = [...pinned.value.slice(0, -1), { ...last, name: "as found" }];
  };
  if (run.peek()?.text === document && text.peek() === document) return keep();
  const before = run.peek();
  const leave = run.subscribe((now) => {
    if (!now || now === before) return;
    queueMicrotask(() => leave());
    if (now.text === document) queueMicrotask(keep);
  });
}
