// A scenario file of the reader's disk: text of a sensible size, or a sentence.

const LARGEST = 2 ** 20;

/** The text of a file.
 * @throws Error with a sentence: it is too large, or no text. */
export async function textOf(file: File): Promise<string> {
  if (file.size > LARGEST) throw new Error(`“${file.name}” has ${(file.size / LARGEST).toFixed(1)} MiB; a scenario has at most 1 MiB.`);
  const bytes = await file.arrayBuffer();
  let text: string;
  try {
    text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    throw new Error(`“${file.name}” is not text in UTF-8; a scenario is a TOML file.`);
  }
  if (text.includes("\0")) throw new Error(`“${file.name}” is not text; a scenario is a TOML file.`);
  if (!text.trim()) throw new Error(`“${file.name}” is empty.`);
  return text;
}
