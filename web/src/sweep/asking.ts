// What shall be swept: the form's state, checked by the server as it changes.

import { computed, effect, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import { text } from "../state/scenario.ts";
import { keepSignals } from "../state/session.ts";
import { axisOf, wordsOf, type AxisChoice } from "./axis.ts";
import { labelsOf } from "./labels.ts";
import type { Estimate, Form, Plan, Target } from "./types.ts";

const FIRST = "constant_power";
const WAIT = 200;
/** Scenario on the bench, as a choice beside the packaged ones. */
export const BENCH = "";

interface Choices {
  source: string;
  document: string;
  axes: AxisChoice[];
  design: string;
  count: string;
  seed: string;
  measures: string[];
  step: string;
  runtime: string;
  workers: string;
}

const EMPTY: Choices = {
  source: BENCH, document: "", axes: [], design: "grid", count: "64", seed: "0", measures: [], step: "", runtime: "", workers: "0",
};

export interface Packaged {
  name: string;
  title: string;
  text: string;
}

export const packaged = signal<Packaged[]>([]);
export const choices = signal<Choices>(EMPTY);
keepSignals("sweep", { choices });
export const form = signal<Form | null>(null);
export const plan = signal<Plan | null>(null);
export const estimate = signal<Estimate | null>(null);
export const estimating = signal(false);
/** Sentence on what is wrong with the scenario or the server; empty if nothing is. */
export const trouble = signal("");

export const put = (some: Partial<Choices>): void => void (choices.value = { ...choices.value, ...some });

export const request = computed(() => {
  const { document, axes, design, count, seed, measures, step, runtime, workers } = choices.value;
  const grid = design === "grid";
  return {
    text: document, over: axes.map((axis) => wordsOf(axis, grid)), sample: grid ? design : `${design}:${count.trim()}`,
    measures, seed: whole(seed), step, runtime, workers: whole(workers),
  };
});

/** A whole number; what is none goes to the server as it is, which says so. */
const whole = (words: string): number | string => (/^\s*-?\d+\s*$/.test(words) ? Number(words) : words.trim() || 0);

export const fault = (field: string): string => plan.value?.faults[field] ?? "";
const labels = computed(() => labelsOf(form.value?.targets ?? []));
/** What a parameter is called. */
export const labelOf = (name: string): string => labels.value.get(name) ?? name;

export const targetOf = (name: string): Target | undefined => form.value?.targets.find((one) => one.name === name);

export function addAxis(one: Target): void {
  put({ axes: [...choices.value.axes, axisOf(one)] });
}

export function changeAxis(id: number, some: Partial<AxisChoice>): void {
  put({ axes: choices.value.axes.map((axis) => (axis.id === id ? { ...axis, ...some } : axis)) });
}

export const removeAxis = (id: number): void => put({ axes: choices.value.axes.filter((axis) => axis.id !== id) });

/** The document of a choice: a packaged one, or that of the bench. */
export function choose(source: string): void {
  const found = packaged.value.find((one) => one.name === source)?.text ?? text.value;
  if (found) put({ source, document: found });
}

/** Load what is packaged, and take the scenario of the bench unless another one was chosen. */
export async function beginForm(): Promise<void> {
  try {
    packaged.value = (await call<{ scenarios: Packaged[] }>("scenarios")).scenarios;
  } catch (error) {
    trouble.value = sentence(error);
    return;
  }
  const now = choices.value;
  if (now.source === BENCH && text.value) put({ document: text.value });
  else if (!now.document) choose(FIRST);
}

async function describe(document: string): Promise<void> {
  try {
    const found = await call<Form>("sweep_form", { text: document }, "sweep-form");
    trouble.value = "";
    form.value = found;
    const names = new Set(found.targets.map((one) => one.name));
    const { axes, measures } = choices.peek();
    put({ axes: axes.filter((axis) => names.has(axis.name)), measures: measures.length ? measures : found.usual });
  } catch (error) {
    if (!superseded(error)) trouble.value = sentence(error);
  }
}

async function check(asked: object): Promise<void> {
  try {
    plan.value = await call<Plan>("sweep_plan", asked, "sweep-plan");
  } catch (error) {
    if (!superseded(error)) plan.value = { faults: { "": sentence(error) }, runs: null, command: "", cautions: [] };
  }
}

export async function measureTime(): Promise<void> {
  estimating.value = true;
  const asked = request.value;
  try {
    const found = await call<Estimate>("sweep_time", asked, "sweep-time");
    if (asked === request.value) estimate.value = found;
  } catch (error) {
    if (!superseded(error)) trouble.value = sentence(error);
  } finally {
    estimating.value = false;
  }
}

/** Describe the scenario of the form, and check it, whenever it changes. */
export function followForm(): () => void {
  let waiting = 0;
  const leave = [
    effect(() => {
      const document = documentNow.value;
      if (document) void describe(document);
    }),
    effect(() => {
      const asked = request.value;
      estimate.value = null;
      clearTimeout(waiting);
      if (!asked.text) return;
      if (asked.over.length) waiting = window.setTimeout(() => void check(asked), WAIT);
      else plan.value = null;
    }),
  ];
  return () => (clearTimeout(waiting), leave.forEach((end) => end()));
}

const documentNow = computed(() => choices.value.document);
