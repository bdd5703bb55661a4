// What the server tells of boards; see martensite.app.calls.boards.

export interface Boards {
  boards?: { name: string; title: string; emulated: boolean }[];
  ports?: { name: string; about: string }[];
  /** The name of an emulator in the place of a port. */
  emulator?: string;
  /** What an emulator lacks; empty if nothing. */
  missing?: string;
  scenarios?: { name: string; title: string; text: string }[];
}

/** How a column in SI is shown. */
export interface Shown {
  display_unit: string;
  factor: number;
  offset: number;
}

export interface Counts {
  good: number;
  lost: number;
  doubled: number;
  garbled: number;
  reordered: number;
}

/** Columns by name, in SI; those of a note are what is new. */
export type Columns = Record<string, number[]>;

export interface Note {
  stage?: string;
  outputs?: Record<string, Shown>;
  columns?: Columns;
  share?: number;
  counts?: Counts;
  armed?: boolean;
}

export interface Outcome {
  /** Of the log; empty if nothing was heard. */
  key: string;
  name: string;
  columns: Columns;
  outputs: Record<string, Shown>;
  counts: Counts;
  /** Why it ended before its time; empty if it did not. */
  ended: string;
  /** Whether the board is disarmed, in words. */
  safe: string;
  /** The scenario that fits the log. */
  rig: string;
}
