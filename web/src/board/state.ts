// A board: what is chosen, what it says while it runs, and what it leaves.

import { computed, signal } from "@preact/signals";
import { call, sentence } from "../lib/api.ts";
import { takeFile } from "../identify/state.ts";
import { watched } from "../state/jobs.ts";
import { go } from "../state/route.ts";
import { text as onBench } from "../state/scenario.ts";
import type { Boards, Columns, Counts, Note, Outcome, Shown } from "./types.ts";

/** The word without which nothing is heated. */
export const ARM = "ARM";
/** In the place of the name of a scenario: the one on the bench. */
export const BENCH = "";

export const known = signal<Boards | null>(null);
export const refused = signal("");
export const busy = signal("");

export const board = signal("uno");
export const port = signal("emulator");
export const scenario = signal("closed_loop");
export const kind = signal<"loop" | "levels">("loop");
export const levels = signal("2 s:0.4, 3 s:0");
/** [s]; empty for that of the scenario. */
export const duration = signal("");
/** What was typed to arm; forgotten after each run. */
export const word = signal("");
export const calibration = signal<{ name: string; table: Record<string, unknown> } | null>(null);

export const work = watched<Note, Outcome>("board_run");
export const isRunning = computed(() => work.job.value?.state === "running");
/** From *Stop* until the job has ended. */
export const stopping = signal(false);
export const outcome = computed((): Outcome | null => {
  const job = work.job.value;
  return job?.state === "done" && job.outcome && typeof job.outcome === "object" ? job.outcome : null;
});

const notes = computed(() => work.job.value?.trail ?? []);
const latest = <T>(pick: (note: Note) => T | undefined): T | undefined => {
  for (let k = notes.value.length - 1; k >= 0; k--) {
    const found = pick(notes.value[k] as Note);
    if (found !== undefined) return found;
  }
  return undefined;
};
export const counts = computed((): Counts | null => outcome.value?.counts ?? latest((note) => note.counts) ?? null);
export const armed = computed(() => isRunning.value && (latest((note) => note.armed) ?? false));
export const stage = computed(() => latest((note) => note.stage) ?? "starting");
export const share = computed(() => latest((note) => note.share) ?? null);
export const outputs = computed((): Record<string, Shown> => outcome.value?.outputs ?? latest((note) => note.outputs) ?? {});

/** Notes whose samples are drawn while it runs: the newest ones. */
const DRAWN = 600;

/** Everything that was told, or once it has ended the log itself. */
export const columns = computed((): Columns => {
  if (outcome.value) return outcome.value.columns;
  const found: Columns = {};
  for (const note of notes.value.slice(-DRAWN)) {
    for (const [name, values] of Object.entries(note.columns ?? {})) (found[name] ??= []).push(...values);
  }
  return found;
});

/** Why the chosen board cannot run at the chosen port; empty if it can. */
export const unusable = computed(() => {
  const there = known.value;
  if (!there || port.value !== there.emulator) return "";
  if (!there.boards?.find((one) => one.name === board.value)?.emulated) return "This board has no emulator. Connect the board and choose its port.";
  return there.missing ? `${there.missing} Install these packages, or connect a board and choose its port.` : "";
});

export async function readBoards(): Promise<void> {
  try {
    known.value = await call<Boards>("boards", {}, "boards");
    refused.value = "";
    const first = known.value.ports?.[0];
    if (unusable.value && first) port.value = first.name;
  } catch (error) {
    refused.value = sentence(error);
  }
}

/** The text of the chosen scenario. */
export const document = computed(() =>
  scenario.value === BENCH ? onBench.value : (known.value?.scenarios?.find((one) => one.name === scenario.value)?.text ?? ""),
);

export async function beginRun(): Promise<void> {
  const typed = word.value.trim();
  word.value = "";
  stopping.value = false;
  const seconds = Number.parseFloat(duration.value);
  await work.begin({
    text: document.value,
    board: board.value,
    port: port.value,
    levels: kind.value === "levels" ? levels.value : "",
    duration: Number.isFinite(seconds) ? seconds : null,
    word: typed,
    calibration: calibration.value?.table ?? null,
  });
}

export async function stopRun(): Promise<void> {
  stopping.value = true;
  await work.cancel(true);
}

/** The project of the firmware, as a file. */
export async function fetchFirmware(): Promise<{ key: string; name: string } | null> {
  busy.value = "Writing the firmware …";
  try {
    const found = await call<{ key: string; name: string }>("board_firmware", { text: document.value, board: board.value }, "firmware");
    refused.value = "";
    return found;
  } catch (error) {
    refused.value = sentence(error);
    return null;
  } finally {
    busy.value = "";
  }
}

export async function readCalibration(file: File | undefined): Promise<void> {
  if (!file) return void (calibration.value = null);
  try {
    calibration.value = { name: file.name, table: JSON.parse(await file.text()) as Record<string, unknown> };
    refused.value = "";
  } catch {
    refused.value = `“${file.name}” is no calibration.json.`;
  }
}

/** Fit the log that was just made, with the scenario of the board. */
export async function openInIdentify(): Promise<void> {
  const found = outcome.value;
  if (!found?.key) return;
  go("identify");
  await takeFile({ key: found.key, name: found.name, bytes: 0 }, found.rig);
}
