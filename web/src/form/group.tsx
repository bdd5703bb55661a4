// Groups of controls that fold; a search shows what fits, and opens it.

import { signal } from "@preact/signals";
import { KindControl, MaterialControl, OptionControl, TextControl } from "./choice.tsx";
import { NumberControl } from "./number.tsx";
import { capital } from "../lib/words.ts";
import { keepSignals } from "../state/session.ts";
import { search } from "./state.ts";
import type { GroupNode, FormNode, SingleNode } from "./types.ts";

/** So many entries of a part are shown at once. */
const FEW = 6;

/** Groups that were folded or unfolded by hand, by path. */
const folded = signal<Record<string, boolean>>({});
keepSignals("form", { folded, search });

function One({ node }: { node: SingleNode }) {
  switch (node.sort) {
    case "number":
      return <NumberControl node={node} />;
    case "option":
      return <OptionControl node={node} />;
    case "material":
      return <MaterialControl node={node} />;
    default:
      return <TextControl node={node} />;
  }
}

export function Items({ nodes }: { nodes: FormNode[] }) {
  return (
    <>
      {nodes.map((node) => (node.sort === "group" ? <Group key={node.path} group={node} /> : <One key={node.path} node={node} />))}
    </>
  );
}

const changes = (nodes: FormNode[]): number =>
  nodes.reduce((sum, node) => sum + (node.sort === "group" ? changes(node.items) : Number(node.changed)), 0);

interface FoldProps {
  group: GroupNode;
  title: string;
  open: boolean;
  className: string;
  children: preact.ComponentChildren;
}

function Fold({ group, title, open, className, children }: FoldProps) {
  const count = changes(group.items);
  const isOpen = search.value !== "" || (folded.value[group.path] ?? open);
  const toggle = (event: Event): void => {
    const now = (event.currentTarget as HTMLDetailsElement).open;
    if (now !== isOpen) folded.value = { ...folded.value, [group.path]: now };
  };
  return (
    <details class={className} open={isOpen} onToggle={toggle}>
      <summary title={group.meaning}>
        {title}
        {count > 0 && <span class="soft small"> {count} changed</span>}
      </summary>
      {isOpen && <div class="form-inside">{children}</div>}
    </details>
  );
}

/** A part of a part: its kind is always seen, its numbers fold if they are many. */
function Group({ group }: { group: GroupNode }) {
  const title = capital(group.title);
  const items = <Items nodes={group.items} />;
  const few = group.items.length <= FEW;
  if (!group.kind)
    return group.items.length ? (
      <Fold group={group} title={title} open={false} className="form-part">
        {items}
      </Fold>
    ) : null;
  return (
    <div class="form-part" role="group" aria-label={title}>
      <KindControl group={group} title={title} />
      {group.items.length > 0 && (
        <Fold group={group} title={`Parameters of ${group.kind.value}`} open={few} className="form-fold">
          {items}
        </Fold>
      )}
    </div>
  );
}

/** A section of the scenario. */
export function Section({ group, open }: { group: GroupNode; open: boolean }) {
  const [first, ...rest] = group.items;
  const material = first?.sort === "material" ? first : null;
  return (
    <Fold group={group} title={group.title} open={open} className="form-section">
      {group.note && <p class="small soft">{group.note}</p>}
      {material && <MaterialControl node={material} />}
      {group.kind && <KindControl group={group} title="Kind" />}
      <Items nodes={material ? rest : group.items} />
    </Fold>
  );
}

// ---------------------------------------------------------------- search

const words = (text: string): string[] => text.toLowerCase().split(/\s+/).filter(Boolean);

function found(node: FormNode, wanted: string[], above: string): FormNode | null {
  const own = node.sort === "group" ? `${node.title} ${node.kind?.value ?? ""}` : `${node.name} ${node.title} ${node.symbol} ${node.meaning}`;
  const all = `${above} ${node.path} ${own}`.toLowerCase();
  if (node.sort !== "group") return wanted.every((word) => all.includes(word)) ? node : null;
  const items = node.items.map((item) => found(item, wanted, all)).filter((item) => item !== null);
  return items.length ? { ...node, items } : null;
}

/** The sections with what has all words of a search in its name, path or meaning. */
export function matching(sections: GroupNode[], text: string): GroupNode[] {
  const wanted = words(text);
  if (wanted.length === 0) return sections;
  return sections.map((section) => found(section, wanted, "")).filter((one) => one?.sort === "group");
}
