// What the page draws of a run that it made itself.

import type { Run } from "../lib/types.ts";
import { describeRun } from "../views/run.ts";
import type { RunCore, Scenario } from "./types.ts";

export const drawRun = (scenario: Scenario, core: RunCore): Run => describeRun(core, scenario);
