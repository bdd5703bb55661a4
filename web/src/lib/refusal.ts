// A refusal is an error with its sentence.

import { capital } from "./words.ts";

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
const NAMED = /^Parameter `?([^` ]+)`? of `?([^` :]+)`?(:?) /;

/** Options of the command line stand in parentheses at the end of a clause. */
const OPTION = / \(`?--(?:`[^`]*`|[^)])*\)/g;

/** A sentence of the library without options of the command line. */
export const dropOptions = (sentence: string): string => sentence.replace(OPTION, "");

/** A sentence of the library without the marks of names and options, which a page does not need. */
export const dropMarks = (sentence: string): string => dropOptions(sentence).replaceAll("`", "");

/** A refusal of the library for who sees a form, not a file: without the place in the text of the scenario. */
export const tellRefusal = (sentence: string): string => {
  const plain = sentence.replace(SECTION, "");
  return capital(dropMarks(plain.replace(NAMED, (_, name: string, kind: string, colon: string) => `${name.replaceAll("_", " ")} of ${kind}${colon} `)));
};

/** What was typed, at the beginning of a sentence. */
const TYPED = /^`?([^`]*?)`? (?=is not a (?:number|known unit)|has no unit)/;
/** Examples in the unit of the library; a field has its own. */
const EXAMPLE = /write for example `[^`]*`/;

/** The same beside the field that it is about, which shows a unit. */
export const tellBesideField = (sentence: string, unit = ""): string =>
  capital(dropMarks(sentence.replace(SECTION, "").replace(NAMED, "").replace(TYPED, "“$1” ").replace(EXAMPLE, `write for example 1.5${unit && ` ${unit}`}`)));
