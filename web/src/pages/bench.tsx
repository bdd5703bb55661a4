// The bench: the scenario's numbers at the left, what comes of them at the right.

import { useEffect } from "preact/hooks";
import { call } from "../lib/api.ts";
import { computing, followDocument, refused, run } from "../state/run.ts";
import { change, followInAddress, fromAddress, text } from "../state/scenario.ts";
import { place } from "../state/route.ts";
import { Message } from "../ui/message.tsx";

const FIRST = "constant_power";

interface Listed {
  scenarios: { name: string; title: string; text: string }[];
}

/** Begin with the scenario of the address, with what was on the bench, or with the first one. */
async function begin(): Promise<void> {
  if ((await fromAddress()) || text.value) return;
  const { scenarios } = await call<Listed>("scenarios");
  const first = scenarios.find((one) => one.name === FIRST) ?? scenarios[0];
  if (first) change(first.text);
}

export function Page() {
  useEffect(() => {
    const leave = [followDocument(), followInAddress()];
    return () => leave.forEach((end) => end());
  }, []);
  useEffect(() => void begin(), [place.value]);
  const now = run.value;
  return (
    <div class="bench" aria-busy={computing.value}>
      <h1>{now?.title ?? "Bench"}</h1>
      {refused.value && <Message kind="error">{refused.value}</Message>}
      {now && <p class="soft">{now.described}; {now.times.length} samples in {(now.seconds * 1000).toFixed(0)} ms</p>}
    </div>
  );
}
