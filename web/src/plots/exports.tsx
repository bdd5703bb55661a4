// What can be taken away of the run on the bench: its document, its figure, its numbers.

import { useSignal } from "@preact/signals";
import { call, save, sentence, take } from "../lib/api.ts";
import { run } from "../state/run.ts";
import { Menu } from "./menu.tsx";
import { Message } from "../ui/message.tsx";

const FILES: [what: string, name: string, about: string][] = [
  ["png", "Figure, PNG", "Figure of the run, for the screen"],
  ["svg", "Figure, SVG", "Figure of the run, for print"],
  ["csv", "Numbers, CSV", "All samples in SI, for a spreadsheet"],
  ["nc", "Numbers, netCDF", "All samples in SI with where they came from, as `martensite run` writes them"],
];

export function Exports() {
  const busy = useSignal("");
  const failed = useSignal("");
  const now = run.value;
  if (!now) return null;

  async function make(what: string, name: string): Promise<void> {
    if (busy.value || !now) return;
    busy.value = name;
    failed.value = "";
    try {
      const file = await call<{ key: string; name: string }>("export", { text: now.text, what });
      take(file.key, file.name);
    } catch (error) {
      failed.value = sentence(error);
    } finally {
      busy.value = "";
    }
  }

  const document = (): void => save(`${now.title.replace(/[^\w.() -]+/g, "_").slice(0, 60)}.toml`, now.text);
  return (
    <Menu name="Export">
      <div class="stack">
        <button type="button" onClick={document} title="The document of this run; `martensite run` takes it">
          Scenario, TOML
        </button>
        {FILES.map(([what, name, about]) => (
          <button key={what} type="button" title={about} disabled={busy.value !== ""} onClick={() => void make(what, name)}>
            {name}
          </button>
        ))}
        <p role="status" class="small soft">
          {busy.value && `Making ${busy.value} …`}
        </p>
        {failed.value && <Message kind="error">{failed.value}</Message>}
      </div>
    </Menu>
  );
}
