// Choices: options of a part, its kind, the material; and texts.

import { useSignal } from "@preact/signals";
import { whyFixed } from "../engine/fixed.ts";
import { faulty, Fixed, idOf, Row } from "./row.tsx";
import { form, refusals, restructure, send } from "./state.ts";
import type { NamedPart, GroupNode, MaterialNode, OptionNode, RowNode, TextNode } from "./types.ts";
import { Select } from "../ui/select.tsx";

export function OptionControl({ node }: { node: OptionNode }) {
  return (
    <Row node={node}>
      <Select
        id={idOf(node.path)}
        key={`${node.value} ${refusals.value[node.path] ?? ""}`}
        value={node.value}
        onChange={(event) => send({ [node.path]: event.currentTarget.value })}
        {...faulty(node.path)}
      >
        {!node.value && <option value="">choose …</option>}
        {node.choices.map((choice) => (
          <option key={choice} value={choice}>
            {choice}
          </option>
        ))}
      </Select>
    </Row>
  );
}

interface PickProps {
  id: string;
  path: string;
  value: string;
  choices: NamedPart[];
  label?: string;
}

/** A choice that takes the rest of the scenario with it. */
function Pick({ id, path, value, choices, label }: PickProps) {
  const fault = useSignal("");
  const about = choices.find((one) => one.name === value)?.summary;
  const pick = async (select: HTMLSelectElement): Promise<void> => {
    fault.value = await restructure({ [path]: select.value });
    if (fault.value) select.value = value;
  };
  return (
    <>
      <Select
        id={id}
        aria-label={label}
        value={value}
        aria-invalid={fault.value ? "true" : undefined}
        aria-describedby={`${id}-about`}
        onChange={(event) => void pick(event.currentTarget)}
      >
        {choices.map((one) => (
          <option key={one.name} value={one.name} title={one.summary}>
            {one.name || "none"}
          </option>
        ))}
      </Select>
      <p class="small soft summary" id={`${id}-about`}>
        {about?.replaceAll("`", "")}
      </p>
      {fault.value && (
        <p class="fault small" role="alert">
          {fault.value}
        </p>
      )}
    </>
  );
}

export function MaterialControl({ node }: { node: MaterialNode }) {
  return (
    <Row node={node}>
      <Pick id={idOf(node.path)} path={node.path} value={node.value} choices={node.materials} />
    </Row>
  );
}

export function KindControl({ group, title }: { group: GroupNode; title: string }) {
  const kind = group.kind;
  if (!kind) return null;
  const id = idOf(kind.path);
  const fixed = whyFixed(kind.path);
  const pick = <Pick id={id} path={kind.path} value={kind.value} choices={form.value?.registries[kind.registry] ?? []} />;
  return (
    <div class={`form-row kind ${kind.changed ? "changed" : ""}`}>
      <div class="form-label">
        <label for={id} title={group.meaning}>
          {title}
        </label>
      </div>
      {fixed ? <Fixed words={fixed}>{pick}</Fixed> : pick}
    </div>
  );
}

/** What is sent for a text that stands for several. */
function items(node: TextNode | RowNode, text: string): unknown {
  if (node.sort === "text" && !node.several) return text;
  const parts = text
    .split(",")
    .map((part) => part.trim())
    .filter(Boolean);
  const values = node.sort === "row" && !node.quantities ? parts.map((part) => (Number.isFinite(Number(part)) ? Number(part) : part)) : parts;
  if (!node.several) return values[0] ?? "";
  return node.sort === "text" && values.length === 1 ? values[0] : values;
}

export function TextControl({ node }: { node: TextNode | RowNode }) {
  return (
    <Row node={node}>
      <input
        id={idOf(node.path)}
        key={node.value}
        type="text"
        spellcheck={false}
        autocomplete="off"
        defaultValue={node.value}
        placeholder={node.several ? "separated by commas" : ""}
        onChange={(event) => send({ [node.path]: items(node, event.currentTarget.value) })}
        {...faulty(node.path)}
      />
    </Row>
  );
}
