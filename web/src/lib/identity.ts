// Random identities of tabs, files and questions.

/** An identity that nobody else has. */
export const makeId = (): string => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
