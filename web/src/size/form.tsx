// The fields of a sizing: number and unit are typed together, and refused beside the field.

import { useSignal } from "@preact/signals";
import { Message } from "../ui/message.tsx";
import { fields, fill, form, put, trouble } from "./state.ts";
import type { Field } from "./types.ts";
import { Select } from "../ui/select.tsx";

const named = (name: string): string => name.replaceAll("_", " ");

function Control({ field, id, refused }: { field: Field; id: string; refused: string | undefined }) {
  const text = fields.value[field.name] ?? "";
  const described = `${id}-about`;
  if (field.choices.length > 0) {
    return (
      <Select id={id} value={text || field.default} aria-describedby={described} onChange={(event) => put(field.name, event.currentTarget.value)}>
        {field.choices.map((choice) => (
          <option key={choice} value={choice}>
            {choice}
          </option>
        ))}
      </Select>
    );
  }
  return (
    <input
      id={id}
      type="text"
      autocomplete="off"
      spellcheck={false}
      value={text}
      placeholder={field.example ? `e.g. ${field.example}` : field.default}
      required={field.required}
      aria-describedby={described}
      aria-invalid={refused ? "true" : undefined}
      onInput={(event) => put(field.name, event.currentTarget.value)}
    />
  );
}

export function FormField({ field }: { field: Field }) {
  const id = `size-${field.name}`;
  const left = useSignal(false);
  const said = form.value?.refused[field.name];
  // what is half typed is not yet wrong
  const refused = said && (left.value || document.activeElement?.id !== id) ? said : undefined;
  return (
    <div class="size-field" onFocusIn={() => (left.value = false)} onFocusOut={() => (left.value = true)}>
      <label for={id}>
        {named(field.name)}
        {field.required && <span aria-hidden="true"> *</span>}
      </label>
      <Control field={field} id={id} refused={refused} />
      {refused ? (
        <span id={`${id}-about`} class="refused small" role="alert">
          {refused}
        </span>
      ) : (
        <span id={`${id}-about`} class="about small soft" title={`Allowed: ${field.allowed}`}>
          {field.meaning}
          {field.default && field.choices.length === 0 && `; ${field.default} if left empty`}
        </span>
      )}
    </div>
  );
}

export function Form({ onBegin, busy }: { onBegin: () => void; busy: boolean }) {
  const now = form.value;
  if (!now) return trouble.value ? <Message kind="error">{trouble.value}</Message> : <p class="starting">Loading …</p>;
  const needed = now.fields.filter((field) => field.required);
  const others = now.fields.filter((field) => !field.required);
  const send = (event: Event): void => {
    event.preventDefault();
    if (!busy) onBegin();
  };
  return (
    <form class="panel stack size-form" aria-label="Request" onSubmit={send} noValidate>
      <div class="size-fields">
        {needed.map((field) => (
          <FormField key={field.name} field={field} />
        ))}
      </div>
      <div class="row">
        {/* the field that is left by pressing it may only then say that it is wrong, and move the button */}
        <button type="submit" class="main" disabled={busy} onMouseDown={(event) => event.preventDefault()}>
          Find wires
        </button>
        <button type="button" onClick={() => fill({ ...now.example })}>
          Example
        </button>
      </div>
      {now.contradiction && <Message kind="error">{now.contradiction}</Message>}
      {trouble.value && <Message kind="error">{trouble.value}</Message>}
      <details open={others.some((field) => fields.value[field.name]?.trim())}>
        <summary>Limits, return and ambient</summary>
        <div class="size-fields">
          {others.map((field) => (
            <FormField key={field.name} field={field} />
          ))}
        </div>
      </details>
    </form>
  );
}
