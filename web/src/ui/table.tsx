// A table with headings; columns of numbers stand to the right.

import type { ComponentChildren } from "preact";

export interface TableProps {
  caption: string;
  headings: string[];
  rows: ComponentChildren[][];
  /** Columns of numbers. */
  right?: number[];
  onRow?: (row: number) => void;
  chosen?: number | null;
}

export function Table({ caption, headings, rows, right = [], onRow, chosen = null }: TableProps) {
  const side = (column: number): string | undefined => (right.includes(column) ? "right" : undefined);
  return (
    <div class="scrolling" tabIndex={0} role="region" aria-label={caption}>
      <table>
        <caption>{caption}</caption>
        <thead>
          <tr>
            {headings.map((heading, k) => (
              <th key={k} scope="col" class={side(k)}>
                {heading}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((cells, k) => (
            <tr key={k} class={onRow ? "choosable" : undefined} aria-selected={chosen === k || undefined} onClick={onRow && (() => onRow(k))}>
              {cells.map((cell, column) => (
                <td key={column} class={side(column)}>
                  {cell}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
