// A refusal is an error with its sentence.

export class Refusal extends Error {
  constructor(
    message: string,
    readonly kind: string,
    readonly status: number,
  ) {
    super(message);
  }
}

const SECTION = /^\[[^\]]*\] /;
const NAMED = /^Parameter `([^`]+)` of `([^`]+)` /;
const beginUpper = (words: string): string => words.charAt(0).toUpperCase() + words.slice(1);

/** A refusal of the library for who sees a form, not a file: without the place in the text of the scenario. */
export const tellRefusal = (sentence: string): string => {
  const plain = sentence.replace(SECTION, "");
  return beginUpper(plain.replace(NAMED, (_, name: string, kind: string) => `${name.replaceAll("_", " ")} of ${kind} `));
};

/** The same beside the field that it is about. */
export const tellBesideField = (sentence: string): string => beginUpper(sentence.replace(SECTION, "").replace(NAMED, ""));
