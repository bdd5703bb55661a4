// Words for people, and their way into the clipboard.

/** Words with a capital letter at the start. */
export const capital = (words: string): string => words.charAt(0).toUpperCase() + words.slice(1);

/** Copy a text; returns the sentence of success or of a browser that does not allow it. */
export async function copyText(text: string, done: string, refused: string): Promise<string> {
  try {
    await navigator.clipboard.writeText(text);
    return done;
  } catch {
    return refused;
  }
}
