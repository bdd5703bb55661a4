// Scenario documents in the page: the TOML that they are written in, read, changed and written
// again as martensite.scenario.overrides does it. Numbers keep their letters.

export class Written {
  constructor(readonly letters: string) {}
}

export type Value = string | boolean | Written | Value[] | Table;
export interface Table {
  [key: string]: Value;
}

const isTable = (value: Value | undefined): value is Table =>
  typeof value === "object" && !Array.isArray(value) && !(value instanceof Written);

const BARE = /^[A-Za-z0-9_-]+/;
const NUMBER = /^[+-]?(?:inf|nan|\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?)/;
const ESCAPES: Record<string, string> = { n: "\n", t: "\t", r: "\r", b: "\b", f: "\f", '"': '"', "\\": "\\" };

/** Reads a document; throws where it is not the TOML of a scenario. */
export function readToml(text: string): Table {
  const document: Table = {};
  const reader = new Reader(text);
  let table = document;
  for (reader.skip(true); !reader.done; reader.skip(true)) {
    if (reader.take("[")) {
      table = descend(document, reader.key());
      reader.expect("]");
    } else {
      reader.entry(table);
    }
    reader.endLine();
  }
  return document;
}

function descend(table: Table, keys: string[]): Table {
  for (const key of keys) {
    const below = table[key] ?? (table[key] = {});
    if (!isTable(below)) throw new Error(`\`${key}\` is a value, not a table.`);
    table = below;
  }
  return table;
}

class Reader {
  private at = 0;
  constructor(private readonly text: string) {}

  get done(): boolean {
    return this.at >= this.text.length;
  }

  /** Blanks and comments; line ends, too, if they do not matter. */
  skip(lines: boolean): void {
    const pattern = lines ? /(?:\s|#[^\n]*)*/y : /(?:[ \t]|#[^\n]*)*/y;
    pattern.lastIndex = this.at;
    this.at += pattern.exec(this.text)?.[0].length ?? 0;
  }

  take(letters: string): boolean {
    if (!this.text.startsWith(letters, this.at)) return false;
    this.at += letters.length;
    return true;
  }

  expect(letters: string): void {
    this.skip(false);
    if (!this.take(letters)) throw new Error(`The document is no TOML at letter ${this.at}.`);
  }

  endLine(): void {
    this.skip(false);
    if (!this.done && !/[\r\n]/.test(this.text[this.at]!)) throw new Error(`The document is no TOML at letter ${this.at}.`);
  }

  private match(pattern: RegExp): string {
    const found = pattern.exec(this.text.slice(this.at, this.at + 400))?.[0];
    if (!found) throw new Error(`The document is no TOML at letter ${this.at}.`);
    this.at += found.length;
    return found;
  }

  key(): string[] {
    const found: string[] = [];
    do {
      this.skip(false);
      found.push(/["']/.test(this.text[this.at] ?? "") ? this.string() : this.match(BARE));
      this.skip(false);
    } while (this.take("."));
    return found;
  }

  entry(table: Table): void {
    const keys = this.key();
    this.expect("=");
    this.skip(false);
    descend(table, keys.slice(0, -1))[keys.at(-1)!] = this.value();
  }

  private value(): Value {
    if (this.take("[")) return this.list();
    if (this.take("{")) return this.inline();
    if (/["']/.test(this.text[this.at] ?? "")) return this.string();
    if (this.take("true")) return true;
    if (this.take("false")) return false;
    return new Written(this.match(NUMBER));
  }

  private list(): Value[] {
    const found: Value[] = [];
    for (this.skip(true); !this.take("]"); this.skip(true)) {
      found.push(this.value());
      this.skip(true);
      if (!this.take(",")) {
        this.skip(true);
        this.expect("]");
        return found;
      }
    }
    return found;
  }

  private inline(): Table {
    const found: Table = {};
    for (this.skip(true); !this.take("}"); this.skip(true)) {
      this.entry(found);
      this.skip(true);
      if (!this.take(",")) {
        this.expect("}");
        return found;
      }
    }
    return found;
  }

  private string(): string {
    const quote = this.text[this.at]!;
    const long = this.take(quote.repeat(3));
    if (!long) this.at++;
    const end = long ? quote.repeat(3) : quote;
    let found = "";
    if (long && this.take("\r\n") === false) this.take("\n");
    while (!this.take(end)) {
      const letter = this.text[this.at++];
      if (letter === undefined) throw new Error("A text in the document has no end.");
      if (letter !== "\\" || quote === "'") {
        found += letter;
        continue;
      }
      const escaped = this.text[this.at++] ?? "";
      if (escaped === "u") {
        found += String.fromCharCode(Number.parseInt(this.text.slice(this.at, this.at + 4), 16));
        this.at += 4;
      } else {
        found += ESCAPES[escaped] ?? escaped;
      }
    }
    return found;
  }
}

const writeKey = (key: string): string => (/^[A-Za-z0-9_-]+$/.test(key) ? key : JSON.stringify(key));

export function writeValue(value: Value): string {
  if (value instanceof Written) return value.letters;
  if (Array.isArray(value)) return `[${value.map(writeValue).join(", ")}]`;
  if (typeof value !== "object") return JSON.stringify(value);
  return `{ ${Object.entries(value).map(([key, one]) => `${writeKey(key)} = ${writeValue(one)}`).join(", ")} }`;
}

/** One section for each table, tables below it inline. */
export function writeToml(document: Table): string {
  const line = ([key, value]: [string, Value]): string => `${writeKey(key)} = ${writeValue(value)}`;
  const plain = Object.entries(document).filter(([, value]) => !isTable(value)).map(line);
  const sections = Object.entries(document).flatMap(([name, table]) =>
    isTable(table) ? ["", `[${writeKey(name)}]`, ...Object.entries(table).map(line)] : [],
  );
  return `${[...plain, ...sections].join("\n").trim()}\n`;
}

/** What is written in the place of a value. */
export type Given = string | number | (string | number)[];

const writtenOf = (given: Given): Value =>
  Array.isArray(given) ? given.map(writtenOf) : typeof given === "number" ? new Written(String(given)) : given;

/** A copy with values at dotted paths replaced. */
export function changeDocument(document: Table, changes: Record<string, Given>): Table {
  const copy = structuredCloneTable(document);
  for (const [path, value] of Object.entries(changes)) {
    const keys = path.split(".");
    let node = copy;
    keys.slice(0, -1).forEach((key, depth) => {
      let below = node[key] ?? (node[key] = {});
      if (typeof below === "string" && depth > 0) below = node[key] = { kind: below };
      if (!isTable(below)) throw new Error(`\`${path}\` cannot be set: \`${keys.slice(0, depth + 1).join(".")}\` is a value, not a table.`);
      node = below;
    });
    node[keys.at(-1)!] = writtenOf(value);
  }
  return copy;
}

function structuredCloneTable(table: Table): Table {
  const copy = (value: Value): Value =>
    Array.isArray(value) ? value.map(copy) : isTable(value) ? structuredCloneTable(value) : value;
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [key, copy(value)]));
}

/** What stands in a list, as `flattenTable` writes it; null if it is none. */
export function readList(text: string): string[] | null {
  const value = text.startsWith("[") ? readToml(`list = ${text}`)["list"] : null;
  return Array.isArray(value) ? value.map((one) => (typeof one === "string" ? one : writeValue(one))) : null;
}

/** Dotted path and value, as it is written, of every entry. */
export function flattenTable(table: Table, above = ""): Map<string, string> {
  const found = new Map<string, string>();
  for (const [key, value] of Object.entries(table)) {
    const path = `${above}${key}`;
    if (isTable(value)) flattenTable(value, `${path}.`).forEach((one, below) => found.set(below, one));
    else found.set(path, typeof value === "string" ? value : writeValue(value));
  }
  return found;
}
