// The form of the scenario: a search, what was assumed, what is missing, and all sections.

import { useEffect } from "preact/hooks";
import { movable } from "../engine/fixed.ts";
import { SERVER } from "../engine/inputs.ts";
import { Message } from "../ui/message.tsx";
import { matching, Section } from "./group.tsx";
import { Wanting } from "./missing.tsx";
import { followForm, form, notes, search, trouble, wanting } from "./state.ts";

/** Sections that are open at first. */
const CLOSED = ["run", "environment"];

function Notes() {
  if (notes.value.length === 0) return null;
  return (
    <Message kind="caution">
      {notes.value.join(" ")}{" "}
      <button type="button" class="quiet" aria-label="Dismiss this note" onClick={() => (notes.value = [])}>
        ✕
      </button>
    </Message>
  );
}

function Search() {
  return (
    <div class="form-search">
      <label class="hidden" for="form-search">
        Find a parameter
      </label>
      <input
        id="form-search"
        type="search"
        placeholder="Find a parameter …"
        value={search.value}
        onInput={(event) => (search.value = event.currentTarget.value)}
      />
    </div>
  );
}

export function Controls() {
  useEffect(followForm, []);
  const now = form.value;
  if (!now) {
    return trouble.value ? (
      <Message kind="note">There is no form, since the scenario cannot be built. Edit its text, undo, or choose another one.</Message>
    ) : null;
  }
  const sections = matching(now.sections, search.value);
  return (
    <div class="form">
      <Search />
      <Notes />
      {movable.value && <p class="soft small">Grey controls need the server. {SERVER}</p>}
      {wanting.value && <Wanting />}
      {sections.map((section) => (
        <Section key={section.path} group={section} open={!CLOSED.includes(section.path)} />
      ))}
      {sections.length === 0 && <p class="soft small">No parameter has “{search.value}” in its name or meaning.</p>}
    </div>
  );
}
