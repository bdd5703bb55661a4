// What the server tells of a run; see martensite.app.calls.run.

export interface Output {
  unit: string;
  /** Unit it is shown in; empty for none. shown = SI * factor + offset. */
  shown: string;
  factor: number;
  offset: number;
  long_name: string;
  symbol: string;
}

export interface Alarm {
  kind: string;
  quantity: string;
  unit: string;
  worst: number;
  limit: number;
  excess: number;
  first: number;
  duration: number;
}

export interface Run {
  text: string;
  title: string;
  described: string;
  status: string;
  accuracy: number | null;
  steps: number;
  step: number;
  stroke: number;
  coordinate: string;
  ports: string[];
  cautions: string[];
  warnings: string[];
  alarms: Alarm[];
  runtime: string;
  seconds: number;
  times: number[];
  columns: Record<string, number[]>;
  outputs: Record<string, Output>;
}
