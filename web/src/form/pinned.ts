// Which controls stand on top: a few that matter for what the scenario is, and those that the reader wants there.

import { computed, signal } from "@preact/signals";
import { entriesOf, listHeats, type Entries } from "../views/remedies.ts";
import { isOwn } from "./patch.ts";
import { form } from "./state.ts";
import type { FormNode, GroupNode, NumberNode, RowNode } from "./types.ts";

export type Pinnable = NumberNode | RowNode;

/** Controls that the reader put on top (true) or took away from there (false), by path. */
export const chosenControls = signal<Record<string, boolean>>({});

const MOST = 5;

/** What a control is about, the paths that it may have, and what it is called on top. */
interface Wish {
  paths: RegExp[];
  title?: (node: Pinnable) => string;
}

const HEATING: Record<string, string> = { W: "heating power", A: "heating current", V: "heating voltage" };

/** In the order in which people ask: how strongly, where to, against what, in what surroundings, of which size. */
const WISHES: Wish[] = [
  { paths: [/^signals\.motor\.(high|level|value)$/], title: () => "motor voltage" },
  { paths: [/^signals\.motor\.end$/], title: () => "duration of the ramp" },
  { paths: [/^mechanism\.unbalance$/] },
  { paths: [/^references?\..*(increment|high|value|amplitude|final)$/], title: (node) => `set point, ${node.title}` },
  { paths: [/^mechanism\.(mass|force|payload|moment|preload)$/, /^mechanism\.(stiffness|spring_stiffness)$/] },
  { paths: [/^environment\.temperature$/], title: () => "ambient temperature" },
  { paths: [/^element\.(\w+\.)?diameter$/] },
  { paths: [/^element\.(\w+\.)?(length|turns)$/] },
  { paths: [/^controllers?\.(\w+\.)?Kp$/] },
  { paths: [/^environment\.cooling\.h$/] },
];

/** The number of a wish, one that the scenario gives before one that it leaves at its default. */
function granted({ paths, title }: Wish, entries: Entries): Pinnable | null {
  const fit = paths.flatMap((path) => [...entries.numbers.values()].filter((node) => path.test(node.path) && node.slider && node.value !== null));
  const node = fit.find(isOwn) ?? fit[0];
  return node ? { ...node, ...(title ? { title: title(node), symbol: "" } : {}) } : null;
}

function heat(entries: Entries): Pinnable | null {
  const nodes = listHeats(entries);
  const node = nodes.find((one) => /(high|values|value|amplitude)$/.test(one.path)) ?? nodes[0];
  if (!node) return null;
  const unit = node.sort === "number" ? (node.unit ?? "") : (/[A-Za-z]+\s*$/.exec(node.value)?.[0].trim() ?? "");
  return { ...node, title: HEATING[unit] ?? node.title };
}

const usual = computed<Pinnable[]>(() => {
  if (!form.value) return [];
  const entries = entriesOf(form.value.sections);
  return [heat(entries), ...WISHES.map((wish) => granted(wish, entries))].filter((one) => one !== null).slice(0, MOST);
});

/** The controls on top, in their order. */
export const onTop = computed<Pinnable[]>(() => {
  const chosen = chosenControls.value;
  const first = usual.value.filter((node) => chosen[node.path] !== false);
  const known = new Set(first.map((node) => node.path));
  const { numbers } = form.value ? entriesOf(form.value.sections) : { numbers: new Map<string, NumberNode>() };
  const own = Object.keys(chosen).flatMap((path) => {
    const node = chosen[path] && !known.has(path) ? numbers.get(path) : undefined;
    return node ? [{ ...node, title: nameInPart(node) }] : [];
  });
  return [...first, ...own];
});

/** A name that says of which part it is, away from the others of its part. */
function nameInPart({ path, title, symbol }: NumberNode): string {
  const part = path.split(".").at(-2) ?? "";
  return symbol || !part || ["element", "mechanism"].includes(part) ? title : `${title} (${part.replaceAll("_", " ")})`;
}

export const isOnTop = (path: string): boolean => onTop.value.some((node) => node.path === path);

export const putOnTop = (path: string, on: boolean): void => void (chosenControls.value = { ...chosenControls.value, [path]: on });

/** Sections without what stands on top; groups that have nothing else go as well. */
export function withoutTop(sections: GroupNode[]): GroupNode[] {
  const top = new Set(onTop.value.map((node) => node.path));
  const rest = (group: GroupNode): GroupNode => ({
    ...group,
    items: group.items.filter((node) => node.sort === "group" || !top.has(node.path)).map((node): FormNode => (node.sort === "group" ? rest(node) : node)),
  });
  return sections.map(rest);
}
