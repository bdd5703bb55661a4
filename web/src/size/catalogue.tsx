// The model beside the maker's table of wires.

import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import { FormField } from "./form.tsx";
import { beginCheck, check, form } from "./state.ts";
import type { Checked } from "./types.ts";
import { Work } from "./work.tsx";

const FIELDS = ["stress", "ambient", "alloy"];

function Answer({ found }: { found: Checked }) {
  return (
    <section class="panel stack" aria-label="Check of the catalogue">
      <p>{found.conditions}</p>
      <Table caption="Model and table" headings={found.columns} rows={found.rows} right={found.columns.map((_, k) => k).slice(2)} />
      <ul class="sentences">
        {found.spread.map((sentence) => (
          <li key={sentence}>{sentence}</li>
        ))}
      </ul>
      <Message kind="caution">{found.doubt}</Message>
    </section>
  );
}

export function Catalogue() {
  const job = check.job.value;
  const busy = job?.state === "running";
  const found = job?.state === "done" && job.outcome && typeof job.outcome === "object" ? job.outcome : null;
  const wanted = (form.value?.fields ?? []).filter((field) => FIELDS.includes(field.name));
  const send = (event: Event): void => {
    event.preventDefault();
    if (!busy) void beginCheck();
  };
  return (
    <div class="size-page">
      <form class="panel stack size-form" aria-label="Conditions" onSubmit={send} noValidate>
        <div class="size-fields">
          {wanted.map((field) => (
            <FormField key={field.name} field={field} />
          ))}
        </div>
        <div class="row">
          <button type="submit" class="main" disabled={busy}>
            Compare
          </button>
        </div>
      </form>
      <div class="stack">
        <Work watched={check} what="Simulating wires" />
        {found ? <Answer found={found} /> : !busy && <p class="soft">Simulated currents and cooling times of every size, compared with the maker's table.</p>}
      </div>
    </div>
  );
}
