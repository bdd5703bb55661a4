// The verdict of a fit in words: one headline, what the logs told, what they did not, and what to record next.

import { Said } from "./said.tsx";
import type { Outcome } from "./types.ts";

const SIGNS = { good: "✓", usable: "!", "not usable": "✗" };

function Sentences({ title, of }: { title: string; of: string[] }) {
  if (!of.length) return null;
  return (
    <section>
      <h3>{title}</h3>
      <ul>
        {of.map((sentence) => (
          <li key={sentence}>
            <Said>{sentence}</Said>
          </li>
        ))}
      </ul>
    </section>
  );
}

export function VerdictPanel({ found }: { found: Outcome }) {
  const { verdict } = found;
  return (
    <section class={`panel identify-verdict ${verdict.word.replace(" ", "-")}`} aria-label="Verdict">
      <p class="identify-headline">
        <span class="identify-sign" aria-hidden="true">
          {SIGNS[verdict.word]}
        </span>
        <span>
          <Said>{verdict.headline}</Said>
        </span>
      </p>
      <div class="identify-panels">
        <Sentences title="Why not better" of={verdict.reasons.slice(0, 6)} />
        <Sentences title="The logs told" of={verdict.told} />
        <Sentences title="Not determined" of={verdict.untold} />
        <Sentences title="Next recordings" of={verdict.next} />
        <Sentences title="Preparation and assumptions" of={found.prepared} />
      </div>
      <details>
        <summary>Command line</summary>
        <code class="identify-command">{found.command}</code>
        <p class="soft small">“Save all for the command line” packs the records as they were fitted, the scenario, and these words.</p>
      </details>
    </section>
  );
}
