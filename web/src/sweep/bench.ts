// A run of the sweep, put on the bench.

import { call, sentence } from "../lib/api.ts";
import { openInBench } from "../state/scenario.ts";
import { key, refused } from "./shown.ts";

/** Put exactly the numbers of a run into the scenario and go to the bench. */
export async function openRun(row: number): Promise<void> {
  try {
    const { text } = await call<{ text: string }>("sweep_row", { key: key.peek(), row }, "sweep-row");
    openInBench(text);
  } catch (error) {
    refused.value = sentence(error);
  }
}
