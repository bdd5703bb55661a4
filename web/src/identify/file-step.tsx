// The first step: a file, and what its columns mean.

import { useSignal } from "@preact/signals";
import { Message } from "../ui/message.tsx";
import { ColumnRows } from "./columns.tsx";
import { NumberField, SECONDS } from "./number.tsx";
import { goTo, put, readTable, state, table, takeFile } from "./state.ts";

const KINDS = ".csv,.txt,.tsv,.dat,.asc,.lvm,.xlsx,.mat,.nc,.parquet,.tdms,.mcap,.gz";
const SEPARATORS = ["auto", "comma", "semicolon", "tab", "whitespace"];

function Drop() {
  const over = useSignal(false);
  const take = (files: FileList | null | undefined): void => {
    const file = files?.[0];
    if (file) void takeFile(file);
  };
  return (
    <div
      class={`identify-drop ${over.value ? "over" : ""}`}
      onDragOver={(event) => (event.preventDefault(), (over.value = true))}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => (event.preventDefault(), (over.value = false), take(event.dataTransfer?.files))}
    >
      <label>
        <strong>Drop a log here, or choose a file</strong>
        <span class="small soft">A table over time, or loops without one: text of any layout, Excel, MAT, netCDF, Parquet, TDMS or MCAP, up to 64 MiB. It stays on this machine.</span>
        <input type="file" accept={KINDS} onChange={(event) => take(event.currentTarget.files)} />
      </label>
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
      <summary>First {found.preview.length} rows, as they stand in the file</summary>
      <div class="scrolling" tabIndex={0} role="region" aria-label="First rows of the file">
        <table>
          <thead>
            <tr>
              {places.map((k) => (
                <th key={k} scope="col">
                  {found.columns[k]?.heading || `column ${k + 1}`}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {found.preview.map((row, k) => (
              <tr key={k}>
                {places.map((at) => (
                  <td key={at}>{row[at] ?? ""}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
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
          <input type="checkbox" checked={drop} onChange={(event) => put({ drop: event.currentTarget.checked })} /> leave out rows that cannot be read
        </label>
      )}
      {!timed && columns.length > 0 && <NumberField label="Time between rows" value={interval} how={SECONDS} onChange={(value) => put({ interval: value })} />}
    </div>
  );
}

export function FileStep() {
  const { file, columns } = state.value;
  const found = table.value;
  return (
    <div class="stack">
      <Drop />
      {!file && (
        <p>
          None at hand?{" "}
          <button type="button" onClick={() => void takeFile("sample")}>
            Take a measured one
          </button>{" "}
          <span class="soft small">Flexinol of 0.38 mm under 172 MPa, heated and cooled once.</span>
        </p>
      )}
      {file && found && (
        <>
          <h2>
            {file.name} <span class="soft small">{found.rows.toLocaleString("en")} rows</span>
          </h2>
          {found.notes.map((note) => (
            <Message key={note} kind="caution">
              {note}
            </Message>
          ))}
          <Reading />
          <ColumnRows />
          <Preview />
          <div class="row">
            <button type="button" class="main" disabled={columns.filter((one) => one.name).length < 1} onClick={() => void goTo(1)}>
              Next: records
            </button>
          </div>
        </>
      )}
    </div>
  );
}
