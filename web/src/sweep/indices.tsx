// How much every varied number matters, once a sweep is there.

import { useSignal } from "@preact/signals";
import { call, sentence } from "../lib/api.ts";
import { Message } from "../ui/message.tsx";
import { Choice } from "./field.tsx";
import { key, type Runs } from "./shown.ts";
import { grouped } from "./time.ts";

interface Found {
  measure: string;
  method: string;
  used: number;
  names: string[];
  indices: Record<string, { values: (number | null)[]; wide: (number | null)[] }>;
  remarks: string[];
}

const MOST = 1.1;
const rounded = (value: number | null | undefined): string => (value === null || value === undefined ? "–" : value.toFixed(2));

function Bar({ value, wide }: { value: number | null; wide: number | null }) {
  const length = Math.min(Math.max(Math.abs(value ?? 0), 0), MOST) / MOST;
  return (
    <td class="sweep-index">
      <span class="sweep-index-bar" style={{ width: `${60 * length}%` }} />
      {rounded(value)}
      {wide !== null && <span class="soft"> ± {rounded(wide)}</span>}
    </td>
  );
}

function Indices({ found }: { found: Found }) {
  const kinds = Object.keys(found.indices);
  return (
    <div class="scrolling" tabIndex={0} role="region" aria-label="Sensitivity indices">
      <table>
        <caption>
          {found.measure}: {found.method}, {grouped(found.used)} runs
        </caption>
        <thead>
          <tr>
            <th scope="col">varied</th>
            {kinds.map((kind) => (
              <th key={kind} scope="col">
                {kind}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {found.names.map((name, row) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              {kinds.map((kind) => (
                <Bar key={kind} value={found.indices[kind]?.values[row] ?? null} wide={found.indices[kind]?.wide[row] ?? null} />
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function IndicesView({ now }: { now: Runs }) {
  const measure = useSignal(now.layout.measures[0]?.name ?? "");
  const found = useSignal<Found | null>(null);
  const refused = useSignal("");
  const busy = useSignal(false);
  const ask = async (): Promise<void> => {
    busy.value = true;
    [found.value, refused.value] = [null, ""];
    try {
      found.value = await call<Found>("sweep_indices", { key: key.value, measure: measure.value });
    } catch (error) {
      refused.value = sentence(error);
    }
    busy.value = false;
  };
  return (
    <>
      <div class="sweep-line">
        <Choice id="index-measure" label="Measure" value={measure.value} onChange={(value) => (measure.value = value)}>
          {now.layout.measures.map((one) => (
            <option key={one.name}>{one.name}</option>
          ))}
        </Choice>
        <button type="button" disabled={busy.value} onClick={() => void ask()}>
          {busy.value ? "Computing …" : "Compute the indices"}
        </button>
      </div>
      <p class="soft small">First order: fraction of the variance that the parameter alone explains. Total: fraction that includes its interactions.</p>
      {refused.value && <Message kind="note">{refused.value}</Message>}
      {found.value && <Indices found={found.value} />}
      {found.value?.remarks.map((remark) => (
        <Message key={remark} kind="caution">
          {remark}
        </Message>
      ))}
    </>
  );
}
