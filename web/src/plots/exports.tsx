// What can be taken away of the run on the bench: its document, its figure, its numbers.

import { useSignal } from "@preact/signals";
import { isStatic } from "../engine/local.ts";
import { call, save, sentence, take } from "../lib/api.ts";
import { makeReport } from "../report/make.ts";
import { run } from "../state/run.ts";
import { Menu } from "./menu.tsx";
import { Message } from "../ui/message.tsx";

const FILES: [what: string, name: string, about: string][] = [
  ["png", "Figure, PNG", "Figure of the run, for the screen"],
  ["svg", "Figure, SVG", "Figure of the run, for print"],
  ["csv", "Data, CSV", "All samples in SI, for a spreadsheet"],
  ["nc", "Data, netCDF", "All samples in SI with their sources"],
];

export function Exports() {
  const busy = useSignal("");
  const failed = useSignal("");
  const now = run.value;
  if (!now) return null;

  async function make(name: string, work: () => Promise<void>): Promise<void> {
    if (busy.value) return;
    busy.value = name;
    failed.value = "";
    try {
      await work();
    } catch (error) {
      failed.value = sentence(error);
    } finally {
      busy.value = "";
    }
  }

  const title = now.title.replace(/[^\w.() -]+/g, "_").slice(0, 60);
  const document = (): void => save(`${title}.toml`, now.text);
  const report = async (): Promise<void> => save(`${title}.html`, new Blob([await makeReport()], { type: "text/html" }));
  const file = async (what: string): Promise<void> => {
    const made = await call<{ key: string; name: string }>("export", { text: now.text, what });
    take(made.key, made.name);
  };
  return (
    <Menu name="Export">
      <div class="stack">
        <button type="button" onClick={document} title="The scenario of this run">
          Scenario, TOML
        </button>
        <button
          type="button"
          title="One file for readers without an installation: interactive charts, results, sources, notes, scenario"
          disabled={busy.value !== ""}
          onClick={() => void make("Live report", report)}
        >
          Live report, HTML
        </button>
        {!isStatic() && FILES.map(([what, name, about]) => (
          <button key={what} type="button" title={about} disabled={busy.value !== ""} onClick={() => void make(name, () => file(what))}>
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
