// Tables of what differs: entries of the documents, and key results.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { call, sentence, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import type { Pinned } from "../state/run.ts";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";

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

export function Results({ now, pins }: TablesProps) {
  const known = [now, ...pins.map((one) => one.run)].map((one) => new Map(one.key));
  const names = new Set(known.flatMap((one) => [...one.keys()]));
  const rows = [...names].map((name) => [name, ...known.map((one) => one.get(name) ?? "–")]);
  const right = known.map((_, k) => k + 1);
  return <Table caption="Results" headings={["result", ...heads(pins)]} rows={rows} right={right} />;
}
