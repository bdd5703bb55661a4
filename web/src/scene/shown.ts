// The stage that is on the page, for those who take its picture.

import type { Stage } from "./stage.ts";

export const shownStage: { current: Stage | null } = { current: null };
