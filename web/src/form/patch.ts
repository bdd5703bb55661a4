// Follows own changes of plain numbers in the form, so that not every move asks the server for a form.

import type { FormNode, NumberNode, RowNode, ScenarioForm, SingleNode } from "./types.ts";

const QUANTITY = /^\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*(.*?)\s*$/i;

/** Whether the document itself gives a value. */
export const isOwn = (node: SingleNode): boolean => node.origin.sort === "scenario" || node.origin.sort === "start";

/** Value in SI of a number in the shown unit; null if only the server can read it. */
function readShown(node: NumberNode, change: unknown): number | null {
  const [, size, unit] = QUANTITY.exec(String(change)) ?? [];
  const value = (Number(size) - node.offset) / node.factor;
  return unit === node.display_unit && Number.isFinite(value) ? value : null;
}

/** A control with another value; null if more than its value changes. */
function patchControl(node: NumberNode | RowNode, change: unknown): NumberNode | RowNode | null {
  if (!isOwn(node)) return null;
  if (node.sort === "row") return Array.isArray(change) ? { ...node, value: change.join(", ") } : null;
  const value = node.unlimited ? null : readShown(node, change);
  return value === null ? null : { ...node, value };
}

/** Return the form after changes that were accepted; null if the server must describe it. */
export function patchForm(form: ScenarioForm, changes: Record<string, unknown>, text: string): ScenarioForm | null {
  const left = new Map(Object.entries(changes));
  const patch = (node: FormNode): FormNode => {
    if (node.sort === "group") {
      const items = node.items.map(patch);
      return items.every((one, k) => one === node.items[k]) ? node : { ...node, items };
    }
    if ((node.sort !== "number" && node.sort !== "row") || !left.has(node.path)) return node;
    const next = patchControl(node, left.get(node.path));
    if (next) left.delete(node.path);
    return next ?? node;
  };
  const sections = form.sections.map((one) => patch(one) as typeof one);
  return left.size ? null : { ...form, text, sections };
}
