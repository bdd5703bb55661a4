// What stands in place of the bench when the link in the address cannot be read.

import { broken, findLast } from "../state/scenario.ts";
import { Message } from "./message.tsx";

export function BrokenLink({ onFirst }: { onFirst: () => void }) {
  const last = findLast();
  const first = (): void => {
    broken.value = "";
    onFirst();
  };
  return (
    <section class="stack" aria-label="Damaged link">
      <h1>Bench</h1>
      <Message kind="error">{broken.value}</Message>
      <p>The address is unchanged, and no scenario was opened.</p>
      <div class="row">
        {last && (
          <button type="button" class="main" onClick={last.open}>
            Open what was here last: {last.title}
          </button>
        )}
        <button type="button" onClick={first}>
          Open an example
        </button>
      </div>
    </section>
  );
}
