// Which wire for a force, a stroke and a rate; and the model beside the maker's table.

import { useEffect } from "preact/hooks";
import { Catalogue } from "../size/catalogue.tsx";
import { ask, check, fromAddress, mapping, show, sizing, tab, type Tab } from "../size/state.ts";
import { Wires } from "../size/wires.tsx";
import { isOver } from "../state/jobs.ts";
import { place } from "../state/route.ts";

const TABS: [tab: Tab, title: string][] = [
  ["wires", "Choose a wire"],
  ["catalogue", "Check of the maker's table"],
];

export function Page() {
  useEffect(() => {
    if (!isOver(sizing.job.value)) void sizing.resume();
    if (!isOver(check.job.value)) void check.resume();
    if (!isOver(mapping.job.value)) void mapping.resume();
  }, []);
  useEffect(() => {
    if (place.value.page !== "size") return;
    fromAddress();
    void ask();
  }, [place.value]);
  return (
    <div class="stack sizing">
      <h1>Size</h1>
      <nav class="row" aria-label="Parts of this page">
        {TABS.map(([name, title]) => (
          <button key={name} type="button" class="tab" aria-pressed={tab.value === name} onClick={() => show(name)}>
            {title}
          </button>
        ))}
      </nav>
      {tab.value === "wires" ? <Wires /> : <Catalogue />}
    </div>
  );
}
