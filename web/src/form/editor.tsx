// The scenario as text, to be edited by hand.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { save } from "../lib/api.ts";
import { text } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { load } from "./state.ts";

export function Editor({ onClose }: { onClose: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const draft = useSignal(text.value);
  const fault = useSignal("");
  useEffect(() => dialog.current?.showModal(), []);
  const apply = async (): Promise<void> => {
    fault.value = await load(draft.value);
    if (!fault.value) dialog.current?.close();
  };
  const onKey = (event: KeyboardEvent): void => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) void apply();
  };
  return (
    <dialog ref={dialog} class="editor" aria-labelledby="editor-title" onClose={onClose}>
      <h2 id="editor-title">Scenario as text</h2>
      <label for="editor-text" class="small">
        TOML; quantities are text with a unit, such as <code>diameter = "0.25 mm"</code>. Ctrl+Enter applies.
      </label>
      <textarea
        id="editor-text"
        spellcheck={false}
        value={draft.value}
        aria-invalid={fault.value ? "true" : undefined}
        onInput={(event) => (draft.value = event.currentTarget.value)}
        onKeyDown={onKey}
      />
      {fault.value && <Message kind="error">{fault.value}</Message>}
      <div class="row">
        <button type="button" class="main" onClick={() => void apply()}>
          Apply
        </button>
        <button type="button" onClick={() => dialog.current?.close()}>
          Cancel
        </button>
        <button type="button" onClick={() => save("scenario.toml", draft.value)}>
          Save as file
        </button>
      </div>
    </dialog>
  );
}
