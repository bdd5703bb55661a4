// Tables of what differs: entries of the documents, and key results.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { call, sentence, superseded } from "../lib/api.ts";
import { digits, toShown } from "../lib/numbers.ts";
import type { KeyResult, Run } from "../lib/types.ts";
import type { Pinned } from "../state/run.ts";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import { printed } from "./drawn.ts";

interface Row {
  path: string;
  values: (string | null)[];
}

export interface TablesProps {
  now: Run;
  pins: Pinned[];
}

const heads = (pins: Pinned[]): string[] => ["this run", ...pins.map((one) => one.name)];

export function Differences({ now, pins }: TablesProps) {
  const rows = useSignal<Row[]>([]);
  const failed = useSignal("");
  const texts = [now, ...pins.map((one) => one.run)].map((one) => one.text);
  useEffect(() => {
    call<{ rows: Row[] }>("differences", { texts }, "differences").then(
      (found) => {
        rows.value = found.rows;
        failed.value = "";
      },
      (error) => {
        if (!superseded(error)) failed.value = sentence(error);
      },
    );
  }, [JSON.stringify(texts)]);
  if (failed.value) return <Message kind="error">{failed.value}</Message>;
  if (!rows.value.length) return <p class="soft">The documents are the same.</p>;
  const cells = rows.value
    .filter((row) => row.values.length === texts.length)
    .map((row) => [row.path, ...row.values.map((value) => value ?? "–")]);
  return <Table caption="Documents" headings={["entry", ...heads(pins)]} rows={cells} />;
}

/** What is smaller is the error of rounding. */
const NOTHING = 1e-12;

/** A result as it is shown. */
function cell(result: KeyResult | undefined): string {
  if (!result || result.value === null) return "–";
  if (Math.abs(result.value) < NOTHING && !result.offset) return `0 ${printed(result.shown)}`.trim();
  return `${digits(toShown(result.value, result), 4)} ${printed(result.shown)}`.trim();
}

export function Results({ now, pins }: TablesProps) {
  const runs = [now, ...pins.map((one) => one.run)];
  const names = new Map(runs.flatMap((one) => one.key.map((result) => [result.key, result.name])));
  const rows = [...names].map(([key, name]) => [
    name,
    ...runs.map((one) => cell(one.key.find((result) => result.key === key))),
  ]);
  const right = runs.map((_, k) => k + 1);
  return <Table caption="Results" headings={["result", ...heads(pins)]} rows={rows} right={right} />;
}
