// The address of a study, to be cited.

import { useSignal } from "@preact/signals";
import { isStatic } from "../engine/local.ts";
import { copyText } from "../lib/words.ts";
import type { About } from "./types.ts";

/** Address of a study: a page of its own where there is no server, else a place on this page. */
export const addressOf = (name: string, page: string, alone: boolean): string =>
  alone ? new URL(`studies/${encodeURIComponent(name)}.html`, page).href : `${page.replace(/[?#].*/, "")}#/studies/${encodeURIComponent(name)}`;

export function Cite({ study }: { study: About }) {
  const said = useSignal("");
  const address = addressOf(study.name, location.href, isStatic());
  const copy = async (): Promise<void> => {
    said.value = await copyText(address, "Copied.", "The browser does not allow it; select the address.");
  };
  return (
    <section class="panel stack" aria-label="Address">
      <h2>Cite this study</h2>
      <div class="row">
        <code class="address">{address}</code>
        <button type="button" onClick={copy}>
          Copy address
        </button>
        <span class="soft small" role="status">
          {said.value}
        </span>
      </div>
    </section>
  );
}
