// A report of what is on the bench, for somebody without an installation.

import { insight, promised } from "../bench/trials.ts";
import { form } from "../form/state.ts";
import { readAsset } from "../lib/host.ts";
import { call } from "../lib/api.ts";
import { notes } from "../state/project.ts";
import { cursor, pinned, run } from "../state/run.ts";
import { readPart } from "../state/session.ts";
import { fillReport, type ReportData } from "./data.ts";

type Differences = ReportData["differences"];

/** The whole file.
 * @throws Error with a sentence. */
export async function makeReport(): Promise<string> {
  const now = run.value;
  if (!now) throw new Error("There is no run to be reported yet.");
  const pins = pinned.value;
  const texts = [now, ...pins.map((pin) => pin.run)].map((one) => one.text);
  const differences: Differences = pins.length ? (await call<{ rows: Differences }>("differences", { texts })).rows : [];
  const page = await readAsset("report.html");
  return fillReport(page, {
    run: now,
    pins,
    notes: notes.value,
    insight: [insight.value?.sentence, promised.value].filter(Boolean).join(" "),
    made: `Made by martensite on ${new Date().toLocaleDateString("en", { dateStyle: "long" })}`,
    differences,
    sections: form.value?.sections ?? [],
    parts: { runs: { cursor: cursor.value }, view: readPart("view") },
  });
}
