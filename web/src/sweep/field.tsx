// A labelled field with the sentence of what is wrong with it.

import type { ComponentChildren } from "preact";
import { Select } from "../ui/select.tsx";

export interface FieldProps {
  id: string;
  label: string;
  value: string;
  onChange: (value: string) => void;
  wrong?: string;
  hint?: string;
  /** Narrow, for a number. */
  narrow?: boolean;
}

export function Wrong({ id, children }: { id: string; children: string }) {
  return children ? (
    <p id={`${id}-wrong`} class="sweep-wrong" role="alert">
      {children}
    </p>
  ) : null;
}

export function Field({ id, label, value, onChange, wrong = "", hint, narrow }: FieldProps) {
  return (
    <div class={narrow ? "sweep-field narrow" : "sweep-field"}>
      <label for={id}>{label}</label>
      <input
        id={id} type="text" value={value} placeholder={hint} spellcheck={false} autocomplete="off"
        aria-invalid={wrong ? "true" : undefined} aria-describedby={wrong ? `${id}-wrong` : undefined}
        onInput={(event) => onChange(event.currentTarget.value)}
      />
      <Wrong id={id}>{wrong}</Wrong>
    </div>
  );
}

export interface ChoiceProps {
  id: string;
  label: string;
  value: string;
  onChange: (value: string) => void;
  children: ComponentChildren;
  wrong?: string;
}

export function Choice({ id, label, value, onChange, children, wrong = "" }: ChoiceProps) {
  return (
    <div class="sweep-field">
      <label for={id}>{label}</label>
      <Select id={id} value={value} aria-invalid={wrong ? "true" : undefined} onChange={(event) => onChange(event.currentTarget.value)}>
        {children}
      </Select>
      <Wrong id={id}>{wrong}</Wrong>
    </div>
  );
}

/** A choice of one of some columns or axes; the name of no choice, if there may be none. */
export function ColumnChoice({ all, none, ...choice }: Omit<ChoiceProps, "children"> & { all: { name: string; short: string }[]; none?: string }) {
  return (
    <Choice {...choice}>
      {none && <option value="">{none}</option>}
      {all.map((one) => (
        <option key={one.name} value={one.name}>
          {one.short}
        </option>
      ))}
    </Choice>
  );
}
