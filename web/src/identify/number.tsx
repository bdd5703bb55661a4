// A field for a number that is kept in SI and shown in a unit that people read.

import { useSignal } from "@preact/signals";
import { digits, readComma } from "../lib/numbers.ts";

interface NumberProps {
  label: string;
  value: number | null;
  /** displayed number = SI * factor + offset */
  how: { factor: number; offset: number; display_unit: string };
  onChange: (value: number | null) => void;
  placeholder?: string;
  hideLabel?: boolean;
}

export function NumberField({ label, value, how, onChange, placeholder = "", hideLabel = false }: NumberProps) {
  const wrong = useSignal(false);
  const shown = value === null ? "" : digits(value * how.factor + how.offset, 7);
  const change = (text: string): void => {
    const plain = readComma(text.trim());
    const number = Number(plain);
    wrong.value = plain !== "" && !Number.isFinite(number);
    if (!wrong.value) onChange(plain === "" ? null : (number - how.offset) / how.factor);
  };
  const name = how.display_unit ? `${label} [${printed(how.display_unit)}]` : label;
  return (
    <label class="identify-number">
      {!hideLabel && <span>{label} </span>}
      <input
        type="text"
        inputMode="decimal"
        size={9}
        aria-label={name}
        aria-invalid={wrong.value}
        placeholder={placeholder}
        value={shown}
        onChange={(event) => change(event.currentTarget.value)}
      />
      {!hideLabel && how.display_unit && <span> {printed(how.display_unit)}</span>}
    </label>
  );
}

/** A unit as it is printed. */
export const printed = (unit: string): string =>
  unit.replace(/\bdegC\b/, "°C").replace(/\bohm\b/, "Ω").replaceAll("^2", "²").replaceAll("^3", "³").replaceAll("*", " ");

export const SECONDS = { factor: 1, offset: 0, display_unit: "s" };
