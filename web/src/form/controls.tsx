// The form of the scenario: a search, what was assumed, what is missing, and all sections.

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { movable } from "../engine/fixed.ts";
import { SERVER } from "../engine/inputs.ts";
import { Message } from "../ui/message.tsx";
import { matching, Section } from "./group.tsx";
import { Wanting } from "./missing.tsx";
import { keepSignals } from "../state/session.ts";
import { chosenControls, withoutTop } from "./pinned.ts";
import { followForm, form, notes, search, trouble, wanting } from "./state.ts";
import { TopControls } from "./top.tsx";

/** Whether all parameters are shown, not only those on top. */
export const showsAll = signal(false);
keepSignals("controls", { showsAll, chosenControls });

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
      <Message kind="note">The scenario has an error, so there is no form. Edit its text, undo, or choose another scenario.</Message>
    ) : null;
  }
  return (
    <div class="form">
      <Notes />
      {movable.value && <p class="soft small">Grey controls need the server. {SERVER}</p>}
      {wanting.value && <Wanting />}
      <TopControls />
      <button type="button" class="all-button" aria-expanded={showsAll.value} aria-controls="all-parameters" onClick={() => (showsAll.value = !showsAll.value)}>
        All parameters
      </button>
      <div id="all-parameters" class="form" hidden={!showsAll.value}>
        {showsAll.value && <All />}
      </div>
    </div>
  );
}

function All() {
  const sections = matching(withoutTop(form.value?.sections ?? []), search.value);
  return (
    <>
      <Search />
      {sections.map((section) => (
        <Section key={section.path} group={section} open={!CLOSED.includes(section.path)} />
      ))}
      {sections.length === 0 && <p class="soft small">No parameter has “{search.value}” in its name or meaning, except those on top.</p>}
    </>
  );
}
