// All logs: which one is looked at, which are merged into the first, and all of them in one picture.

import { useEffect } from "preact/hooks";
import { toShown } from "../lib/numbers.ts";
import { NumberField, printed, SECONDS } from "./number.tsx";
import { Key, Plot } from "./plot.tsx";
import { changeLog, chooseLog, logs, overlay, put, readOverlay, removeLog, state, type LogState } from "./state.ts";

const COLOURS = 6;

/** Only logs with times can be put side by side. */
const timed = (log: LogState | undefined): boolean => log?.columns.some((one) => one.name === "time") ?? false;

export function LogList() {
  if (logs.value.length < 2) return null;
  const first = logs.value[0]?.file?.name;
  return (
    <section class="panel stack" aria-label="Logs">
      <ul class="identify-logs">
        {logs.value.map((log, k) => {
          const name = log.file?.name ?? "";
          return (
            <li key={log.file?.key} class="row">
              <button type="button" aria-pressed={state.value.at === k} onClick={() => void chooseLog(k)}>
                {name}
              </button>
              {k > 0 && timed(log) && timed(logs.value[0]) && (
                <label>
                  <input type="checkbox" aria-label={`Merge ${name} with the first`} checked={log.merge} onChange={(event) => void changeLog(k, { merge: event.currentTarget.checked })} /> merge with {first}
                </label>
              )}
              {log.merge && <NumberField label="begins later by" value={log.shift} how={SECONDS} placeholder="by clock" onChange={(shift) => void changeLog(k, { shift })} />}
              <button type="button" aria-label={`Remove ${name}`} onClick={() => void removeLog(k)}>
                Remove
              </button>
            </li>
          );
        })}
      </ul>
      <Overlay />
    </section>
  );
}

/** Every quantity of all records, each record in its colour. */
export function Overlay() {
  const found = overlay.value;
  useEffect(() => void (found || readOverlay()), [found]);
  if (!found) return null;
  const lines = found.records.map((label, k) => ({ label, colour: k % COLOURS, ...(found.loops ? { dots: true } : {}) }));
  const x = found.x.map((value) => toShown(value, found.axis));
  const unit = (shown: string): string => (shown ? ` [${printed(shown)}]` : "");
  return (
    <div class="stack">
      <div class="row">
        <Key lines={lines} />
        {!found.loops && found.records.length > 1 && (
          <label>
            aligned by{" "}
            <select value={state.value.align} onChange={(event) => (put({ align: event.currentTarget.value === "clock" ? "clock" : "start" }), void readOverlay())}>
              <option value="start">the start of each</option>
              <option value="clock">the clock of each</option>
            </select>
          </label>
        )}
      </div>
      <div class="identify-panels">
        {found.quantities.map((one) => (
          <Plot
            key={one.name}
            label={`${one.name} of all records over ${found.axis.name}`}
            x={x}
            xLabel={`${found.axis.name}${unit(found.axis.display_unit)}`}
            yLabel={`${one.name}${unit(one.display_unit)}`}
            lines={lines.map((line, k) => ({ ...line, values: (one.lines[k] ?? []).map((value) => (value === null ? null : toShown(value, one))) }))}
            height={230}
          />
        ))}
      </div>
    </div>
  );
}
