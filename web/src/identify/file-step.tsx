// The first step: a file, and what its columns mean.

import { useSignal } from "@preact/signals";
import { Empty } from "../ui/empty.tsx";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import { ColumnRows } from "./columns.tsx";
import { NumberField, SECONDS } from "./number.tsx";
import { LogList } from "./log-list.tsx";
import { Said } from "./said.tsx";
import { addFiles, fitProposed, goTo, isRunning, logs, put, readTable, state, table, takeFile, understood } from "./state.ts";

const KINDS = ".csv,.txt,.tsv,.dat,.asc,.lvm,.xlsx,.mat,.nc,.parquet,.tdms,.mcap,.gz";
const LOADS = [50, 100, 172, 200];
const SEPARATORS = ["auto", "comma", "semicolon", "tab", "whitespace"];

function Drop() {
  const over = useSignal(false);
  const take = (files: FileList | null | undefined): void => {
    const several = [...(files ?? [])];
    if (several.length) void (state.value.file ? addFiles(several) : takeFile(several));
  };
  return (
    <div
      class={`identify-drop ${over.value ? "over" : ""}`}
      onDragOver={(event) => (event.preventDefault(), (over.value = true))}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => (event.preventDefault(), (over.value = false), take(event.dataTransfer?.files))}
    >
      <label>
        <strong>{state.value.file ? "Drop a log here to add it, or choose files" : "Drop logs here, or choose files"}</strong>
        <span class="small soft">A table over time or a loop without times: text of any layout, Excel, MAT, netCDF, Parquet, TDMS or MCAP, up to 64 MiB; the command line reads larger files. The file stays on this machine.</span>
        <input type="file" multiple accept={KINDS} onChange={(event) => take(event.currentTarget.files)} />
      </label>
    </div>
  );
}

/** Measured logs that come with the package. */
function Samples() {
  return (
    <div class="row identify-samples">
      <span>No log?</span>
      <button type="button" onClick={() => void takeFile([...LOADS])}>
        Use four measured loops: Flexinol 0.38 mm under 50, 100, 172 and 200 MPa
      </button>
      <button type="button" onClick={() => void takeFile(172)}>
        Use one loop: 172 MPa
      </button>
      <span class="soft small">One heating and cooling each, strain over temperature; published by P. Leal, 2016.</span>
    </div>
  );
}

function Preview() {
  const found = table.value;
  if (!found) return null;
  const width = Math.max(found.columns.length, ...found.preview.map((row) => row.length));
  const places = Array.from({ length: width }, (_, k) => k);
  return (
    <details class="panel">
      <summary>First {found.preview.length} rows of the file</summary>
      <Table
        caption="First rows of the file"
        headings={places.map((k) => found.columns[k]?.heading || `column ${k + 1}`)}
        rows={found.preview.map((row) => places.map((at) => row[at] ?? ""))}
      />
    </details>
  );
}

function Reading() {
  const { separator, drop, interval, columns } = state.value;
  const timed = columns.some((one) => one.name === "time");
  return (
    <div class="row">
      {table.value?.separator && (
        <label>
          Separator{" "}
          <select value={separator} onChange={(event) => (put({ separator: event.currentTarget.value }), void readTable(true))}>
            {SEPARATORS.map((name) => (
              <option key={name} value={name}>
                {name === "auto" ? `auto (${table.value?.separator})` : name}
              </option>
            ))}
          </select>
        </label>
      )}
      {table.value?.separator && (
        <label>
          <input type="checkbox" checked={drop} onChange={(event) => put({ drop: event.currentTarget.checked })} /> leave out cells that cannot be read
        </label>
      )}
      {!timed && columns.length > 0 && <NumberField label="Time between rows, 1 s if empty" value={interval} how={SECONDS} onChange={(value) => put({ interval: value })} />}
    </div>
  );
}

export function FileStep() {
  const { file, columns } = state.value;
  const mapped = columns.some((one) => one.name);
  const found = table.value;
  const { said, isKnown } = understood.value;
  return (
    <div class="stack">
      <Drop />
      {!file && <Samples />}
      {!file && <Empty picture="log">The page recognises the columns, proposes a model, fits it and reports which parameters the log determines.</Empty>}
      <LogList />
      {file && found && (
        <>
          <h2>
            {file.name} <span class="soft small">{found.rows.toLocaleString("en")} rows</span>
          </h2>
          {said && (
            <p class="identify-said" role="status">
              <Said>{said}</Said>
            </p>
          )}
          <div class="row">
            <button type="button" class="main" disabled={!mapped || !isKnown || isRunning.value} onClick={() => void fitProposed()}>
              Fit a model to {logs.value.length > 1 ? `these ${logs.value.length} logs` : "it"}
            </button>
            <button type="button" disabled={!mapped} onClick={() => void goTo(1)}>
              Next: records
            </button>
            <button type="button" onClick={() => void takeFile([])}>
              Start again
            </button>
            <span class="soft small">The fit uses the simplest scenario for these columns. The steps in between let you change it.</span>
          </div>
          {found.notes.map((note) => (
            <Message key={note} kind="caution">
              {note}
            </Message>
          ))}
          <Reading />
          <ColumnRows />
          <Preview />
        </>
      )}
    </div>
  );
}
