// What the server tells of studies; see martensite_app.calls.studies.

export type Verdict = "reproduced" | "not reproduced" | "calibrated" | "not checkable";
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
}

export interface Results {
  name: string;
  claims: Claim[];
  tally: Tally;
  /** Key of a file. */
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
