// What each column of the file means: its name and unit, guessed from the heading, and its curve.

import { digits, readComma } from "../lib/numbers.ts";
import { proposeSoon, put, state, table, type Column } from "./state.ts";
import type { TableColumn } from "./types.ts";
import { Select } from "../ui/select.tsx";

const WIDTH = 120;
const HEIGHT = 30;

/** A small curve without axes. */
function Spark({ curve }: { curve: [number[], (number | null)[]] }) {
  const [rows, values] = curve;
  const known = values.filter((value): value is number => value !== null);
  if (known.length < 2) return null;
  const low = Math.min(...known);
  const reach = Math.max(...known) - low || 1;
  const last = rows.at(-1) || 1;
  const points = rows.map((row, k) => {
    const value = values[k];
    return value === null || value === undefined ? "" : `${((row / last) * WIDTH).toFixed(1)},${(HEIGHT - 2 - ((value - low) / reach) * (HEIGHT - 4)).toFixed(1)}`;
  });
  return (
    <svg width={WIDTH} height={HEIGHT} role="img" aria-label={`curve from ${digits(low)} to ${digits(low + reach)}`}>
      <polyline points={points.filter(Boolean).join(" ")} fill="none" stroke="var(--curve-0)" stroke-width="1.5" />
    </svg>
  );
}

function change(at: number, patch: Partial<Column>): void {
  proposeSoon();
  put({ columns: state.value.columns.map((one) => (one.at === at ? { ...one, ...patch, guessed: false } : one)), cuts: [], steps: [] });
}

function Meaning({ column, of }: { column: Column; of: TableColumn }) {
  const names = table.value?.names ?? {};
  const label = of.heading || `column ${column.at + 1}`;
  const own = column.name !== "" && !(column.name in names);
  return (
    <div class="row tight">
      <Select
        aria-label={`Meaning of ${label}`}
        value={own ? "?" : column.name}
        onChange={(event) => change(column.at, { name: event.currentTarget.value === "?" ? label.replace(/[^\w.]+/g, "_").toLowerCase() : event.currentTarget.value })}
      >
        <option value="">not used</option>
        {Object.keys(names).map((name) => (
          <option key={name} value={name}>
            {name.replaceAll("_", " ")}
          </option>
        ))}
        <option value="?">another name …</option>
      </Select>
      {own && <input aria-label={`Name of ${label}`} size={12} value={column.name} onChange={(event) => change(column.at, { name: event.currentTarget.value.trim() })} />}
    </div>
  );
}

function Unit({ column, of }: { column: Column; of: TableColumn }) {
  const known = table.value?.names[column.name.split(".").at(-1) ?? ""] ?? [];
  const list = `units-${column.at}`;
  const needed = column.name !== "" && column.unit === "";
  return (
    <>
      <input
        list={list}
        size={8}
        aria-label={`Unit of ${of.heading || `column ${column.at + 1}`}`}
        aria-invalid={needed}
        disabled={!column.name}
        placeholder={needed ? "choose" : ""}
        value={column.unit}
        onChange={(event) => change(column.at, { unit: event.currentTarget.value.trim() })}
      />
      <datalist id={list}>
        {known.map((unit) => (
          <option key={unit} value={unit} />
        ))}
      </datalist>
    </>
  );
}

/** What the numbers of a column are multiplied by: sensors give volts. */
function Factor({ column, of }: { column: Column; of: TableColumn }) {
  const set = (text: string): void => {
    const factor = Number(readComma(text.trim() || "1"));
    change(column.at, { factor: factor === 1 || !Number.isFinite(factor) ? null : factor });
  };
  return (
    <input
      size={5}
      inputMode="decimal"
      aria-label={`Factor of ${of.heading || `column ${column.at + 1}`}`}
      disabled={!column.name || column.unit === "clock"}
      value={String(column.factor ?? 1)}
      onChange={(event) => set(event.currentTarget.value)}
    />
  );
}

function Content({ of }: { of: TableColumn }) {
  return (
    <>
      {of.min === null ? "no numbers" : `${digits(of.min)} to ${digits(of.max)}`}
      {of.missing > 0 && <span class="small soft"> · {of.missing} missing</span>}
      {of.wrong > 0 && (
        <span class="identify-wrong small" title={of.first_wrong}>
          {" "}
          · ⚠ {of.wrong === 1 ? "1 cell is" : `${of.wrong} cells are`} no number ({of.first_wrong})
        </span>
      )}
    </>
  );
}

export function ColumnRows() {
  const found = table.value;
  if (!found) return null;
  return (
    <div class="scrolling panel" tabIndex={0} role="region" aria-label="Columns">
      <table>
        <caption>Meaning and unit of each column</caption>
        <thead>
          <tr>
            {["heading in the file", "means", "times", "unit", "known by", "numbers as written", "curve"].map((name, k) => (
              <th key={k} scope="col">
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {state.value.columns.map((column) => {
            const of = found.columns[column.at];
            return (
              of && (
                <tr key={column.at} class={column.name ? "" : "unused"}>
                  <th scope="row">{of.heading || `column ${column.at + 1}`}</th>
                  <td>
                    <Meaning column={column} of={of} />
                  </td>
                  <td>
                    <Factor column={column} of={of} />
                  </td>
                  <td>
                    <Unit column={column} of={of} />
                  </td>
                  <td class="small soft">{column.name ? (column.guessed ? "guess" : "chosen") : ""}</td>
                  <td>
                    <Content of={of} />
                  </td>
                  <td>
                    <Spark curve={of.curve} />
                  </td>
                </tr>
              )
            );
          })}
        </tbody>
      </table>
    </div>
  );
}
