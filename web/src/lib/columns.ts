// Answers whose long lists of numbers came as binary (`pack_columns` of src/martensite/app/messages.py).

export const COLUMNS_TYPE = "application/x-martensite-columns";
const NUMBERS = "$numbers";
const SIZE = 8;

/** The numbers, whose bytes stand in planes: the first of every number, then the second of every number … */
function readNumbers(planes: Uint8Array): Float64Array {
  const count = Math.floor(planes.length / SIZE);
  const bytes = new Uint8Array(count * SIZE);
  const little = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;
  for (let k = 0; k < SIZE; k++) {
    const from = k * count;
    for (let i = 0, to = little ? k : SIZE - 1 - k; i < count; i++, to += SIZE) bytes[to] = planes[from + i] as number;
  }
  return new Float64Array(bytes.buffer);
}

/** What JSON has no number for is null, as it would be in JSON. */
const listed = (numbers: Float64Array): (number | null)[] => Array.from(numbers, (value) => (Number.isFinite(value) ? value : null));

export function unpackColumns(body: ArrayBuffer): unknown {
  const length = new DataView(body).getUint32(0, true);
  const head: unknown = JSON.parse(new TextDecoder().decode(new Uint8Array(body, 4, length)));
  const numbers = readNumbers(new Uint8Array(body, 4 + length));
  const fill = (value: unknown): unknown => {
    if (typeof value !== "object" || value === null) return value;
    if (Array.isArray(value)) return value.map(fill);
    const table = value as Record<string, unknown>;
    const place = table[NUMBERS] as [number, number] | undefined;
    if (place) return listed(numbers.subarray(place[0], place[0] + place[1]));
    for (const [name, item] of Object.entries(table)) table[name] = fill(item);
    return table;
  };
  return fill(head);
}
