// What the server tells of studies; see martensite.app.calls.studies.

export type Verdict = "reproduced" | "disagrees" | "misprint" | "self-contradictory" | "not comparable" | "recovery";
export type Tally = Record<Verdict, number>;

export interface Claim {
  id: string;
  statement: string;
  source: string;
  published: number | null;
  computed: number | null;
  unit: string;
  tolerance: number | null;
  verdict: Verdict;
  why: string;
  tolerance_reason: string;
  /** What a misprinted equation gives as it is printed. */
  as_printed: number | null;
  /** Of a misprint: what is to be used instead. */
  correction: string;
  /** Of a contradiction: the other printed statement. */
  against: string;
  /** Where nothing can be compared: what is another, or was kept back. */
  differs: string;
}

/** A number computed here for which the source prints none. */
export interface Report {
  id: string;
  statement: string;
  source: string;
  computed: number | null;
  unit: string;
  why: string;
}

export interface Told {
  heading: string;
  text: string;
}

export interface Source {
  key: string;
  text: string;
  note: string;
  link: string;
}

export interface Missing {
  name: string;
  title: string;
  fetch: string;
}

export interface About {
  name: string;
  title: string;
  guide: string[];
  sources: Source[];
  /** What the figure shows. */
  figure: string;
  missing: Missing[];
}

export interface Listed extends About {
  tally: Tally | null;
  /** As `Results.figure`. */
  drawn: string;
}

export interface Results {
  name: string;
  digest: Told[];
  claims: Claim[];
  reports: Report[];
  tally: Tally;
  /** What computed the numbers that came with the study; empty of those computed here. */
  made_by: string;
  /** Key of a file, or `shipped`; empty without a figure. */
  figure: string;
  seconds: number;
}

export interface StudyPage extends About {
  parts: string[];
  scenarios: { title: string; text: string }[];
  results: Results | null;
}

export interface Note {
  doing: string;
  done: number;
  of: number;
  claims: Claim[];
}
