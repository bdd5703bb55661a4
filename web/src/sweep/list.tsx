// The sweeps in the folder: open one, go on with one, delete one.

import { useSignal } from "@preact/signals";
import { call, sentence } from "../lib/api.ts";
import { go } from "../state/route.ts";
import { running } from "./following.ts";
import { key, lines, list, refused, settled, work } from "./shown.ts";
import { bytes, grouped } from "./time.ts";
import type { Line } from "./types.ts";

async function remove(one: Line): Promise<void> {
  if (one.key === key.value) go("sweep");
  await settled();
  try {
    await call("sweep_delete", { key: one.key });
  } catch (error) {
    refused.value = sentence(error);
  }
  await list();
}

function Actions({ one }: { one: Line }) {
  const asked = useSignal(false);
  const name = `${one.title}, ${date(one)}`;
  if (asked.value) {
    return (
      <span class="row" role="group" aria-label={`Delete ${name}?`}>
        Delete {grouped(one.done)} runs?
        <button type="button" onClick={() => void remove(one)}>
          Delete
        </button>
        <button type="button" onClick={() => (asked.value = false)}>
          Keep
        </button>
      </span>
    );
  }
  const resume = (): void => {
    go(`sweep/${one.key}`);
    void work.begin({ resume: one.key });
  };
  return (
    <span class="row">
      {one.state !== "unreadable" && (
        <button type="button" aria-label={`Open ${name}`} onClick={() => go(`sweep/${one.key}`)}>
          Open
        </button>
      )}
      {one.state === "stopped" && (
        <button type="button" disabled={running.value} aria-label={`Resume ${name}`} onClick={resume}>
          Resume
        </button>
      )}
      {one.state !== "running" && (
        <button type="button" class="quiet" aria-label={`Delete ${name}`} onClick={() => (asked.value = true)}>
          Delete …
        </button>
      )}
    </span>
  );
}

const date = (one: Line): string => new Date(one.made * 1000).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });

function Row({ one }: { one: Line }) {
  return (
    <tr aria-current={one.key === key.value ? "true" : undefined}>
      <td>
        {one.title}
        <div class="soft small">
          {one.over.join("; ")}
          {one.sample && one.sample !== "grid" ? ` (${one.sample})` : ""}
          {one.why}
        </div>
      </td>
      <td class="right">
        {grouped(one.done)} / {grouped(one.runs)}
      </td>
      <td>{one.state}</td>
      <td>{date(one)}</td>
      <td class="right">{bytes(one.bytes)}</td>
      <td>
        <Actions key={one.key} one={one} />
      </td>
    </tr>
  );
}

export function List() {
  const found = lines.value;
  if (!found) return null;
  return (
    <section class="panel" aria-label="Sweeps in this folder">
      <h2>Sweeps in this folder</h2>
      {!found.length && <p class="soft">There are no sweeps yet.</p>}
      {found.length > 0 && (
        <div class="scrolling" tabIndex={0} role="region" aria-label="List of sweeps">
          <table>
            <thead>
              <tr>
                <th scope="col">Scenario and axes</th>
                <th scope="col" class="right">Runs</th>
                <th scope="col">State</th>
                <th scope="col">Begun</th>
                <th scope="col" class="right">Size</th>
                <th scope="col">Actions</th>
              </tr>
            </thead>
            <tbody>
              {found.map((one) => (
                <Row key={one.key} one={one} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}
