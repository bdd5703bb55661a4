// A text as letters that may stand in an address: deflated, base64 for addresses. The twin of
// martensite.cli.commands.web_bench. Links of the page are JSON in the format of zlib, whose checksum tells when
// letters are missing or changed; those of the command line are the bare text.

async function through(data: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  const piped = new Blob([data]).stream().pipeThrough(stream);
  return new Uint8Array(await new Response(piped).arrayBuffer());
}

export async function packed(text: string, format: CompressionFormat = "deflate-raw"): Promise<string> {
  const data = await through(new TextEncoder().encode(text) as Uint8Array<ArrayBuffer>, new CompressionStream(format));
  let letters = "";
  for (const byte of data) letters += String.fromCharCode(byte);
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

export async function unpacked(letters: string, format: CompressionFormat = "deflate-raw"): Promise<string> {
  const binary = atob(letters.replaceAll("-", "+").replaceAll("_", "/"));
  const data = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
  return new TextDecoder().decode(await through(data, new DecompressionStream(format)));
}

/** What a link to the bench holds. */
export interface Linked {
  /** The scenario, TOML. */
  text: string;
  /** What other parts of the session bring with it. */
  parts: Record<string, unknown>;
}

export const packLink = (link: Linked): Promise<string> => packed(JSON.stringify(link), "deflate");

/** First letter of what is in the format of zlib; a bare deflated text has none that begins so. */
const ZLIB = "e";

/** Read the letters of a link, old or new.
 * @throws Error: they are damaged. */
export async function unpackLink(letters: string): Promise<Linked> {
  if (!letters.startsWith(ZLIB)) {
    const text = await unpacked(letters);
    if (!text.trim()) throw new Error("There is no scenario in it.");
    return { text, parts: {} };
  }
  const { text, parts } = JSON.parse(await unpacked(letters, "deflate")) as Partial<Linked>;
  if (typeof text !== "string" || typeof parts !== "object" || parts === null) throw new Error("There is no scenario in it.");
  return { text, parts };
}
