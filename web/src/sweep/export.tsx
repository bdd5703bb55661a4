// What can be taken away: a table, the store, and the command that makes the same.

import { useSignal } from "@preact/signals";
import { call, save, sentence, take } from "../lib/api.ts";
import { refused, stored } from "./shown.ts";

interface Made {
  file: string;
  name: string;
}

async function fetched(key: string, kind: string): Promise<void> {
  try {
    const { file, name } = await call<Made>("sweep_export", { key, kind });
    take(file, name);
  } catch (error) {
    refused.value = sentence(error);
  }
}

export function Export() {
  const copied = useSignal(false);
  const now = stored.value;
  if (!now) return null;
  const { key, command, layout, path } = now;
  const file = /martensite sweep "?([\w.-]+)/.exec(command)?.[1] ?? "scenario.toml";
  const copy = (): void =>
    void navigator.clipboard.writeText(command).then(
      () => (copied.value = true),
      () => (refused.value = "The browser does not let this page copy; select the text instead."),
    );
  return (
    <details class="panel sweep-export">
      <summary>Take away</summary>
      <div class="row">
        <button type="button" onClick={() => void fetched(key, "csv")}>
          Table (CSV, SI units)
        </button>
        <button type="button" onClick={() => void fetched(key, "zarr")}>
          Store (Zarr, zipped)
        </button>
        <button type="button" onClick={() => save(file, layout.text)}>
          Scenario (TOML)
        </button>
      </div>
      <p class="small">
        The store lies in <code>{path}</code>
      </p>
      <p class="small" id="sweep-command">
        Command line, in the folder of the scenario:
      </p>
      <pre class="sweep-command" tabIndex={0} aria-labelledby="sweep-command">
        {command}
      </pre>
      <button type="button" onClick={copy}>
        {copied.value ? "Copied" : "Copy the command"}
      </button>
    </details>
  );
}
