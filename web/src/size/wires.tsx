// The sizing: form, table of wires, the chosen one.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Empty } from "../ui/empty.tsx";
import { Message } from "../ui/message.tsx";
import { Candidates } from "./candidates.tsx";
import { Details } from "./details.tsx";
import { Form } from "./form.tsx";
import { WishMap } from "./map.tsx";
import { answer, begin, outdated, sizing } from "./state.ts";
import type { Sizing } from "./types.ts";
import { Work } from "./work.tsx";

function Outdated({ found }: { found: Sizing }) {
  const asked = Object.entries(found.asked).map(([name, text]) => `${name.replaceAll("_", " ")} ${text}`);
  return <Message kind="caution">The form has changed; these wires are for {asked.join(", ")}.</Message>;
}

function Answer({ found }: { found: Sizing }) {
  const all = useSignal(false);
  const chosen = useSignal<number | null>(null);
  useEffect(() => {
    const best = found.candidates.findIndex((one) => one.feasible);
    chosen.value = best < 0 ? null : best;
  }, [found]);
  const one = chosen.value === null ? undefined : found.candidates[chosen.value];
  return (
    <>
      {outdated.value && <Outdated found={found} />}
      {found.candidates.length < found.of && (
        <Message kind="caution">
          Cancelled: {found.candidates.length} of {found.of} wires were simulated.
        </Message>
      )}
      {found.candidates.length > 0 && (
        <Candidates sizing={found} all={all.value} onAll={(next) => (all.value = next)} chosen={chosen.value} onChoose={(next) => (chosen.value = next)} />
      )}
      {one && chosen.value !== null && <Details found={one} number={chosen.value + 1} />}
    </>
  );
}

export function Wires() {
  const busy = sizing.job.value?.state === "running";
  const found = answer.value;
  return (
    <div class="size-page">
      <Form busy={busy} onBegin={() => void begin()} />
      <div class="stack">
        <Work watched={sizing} what="Simulating wires" />
        {(found || busy) && <WishMap />}
        {found && <Answer found={found} />}
        {!found && !busy && <Empty picture="wire">The page simulates every size and alloy of the maker's catalogue and lists the best wires first, with their electronics.</Empty>}
      </div>
    </div>
  );
}
