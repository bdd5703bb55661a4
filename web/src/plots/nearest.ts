// The row of a run that a place in a plane means.

import type { Mark } from "./picture.ts";

/** Row whose moving point is nearest, as the eye measures distance. */
export function nearestRow(marks: Mark[], x: number, y: number, wide: number, high: number): number {
  let [best, found] = [Infinity, -1];
  for (const mark of marks) {
    for (let i = 0; i < mark.x.length; i++) {
      const dx = ((mark.x[i] as number) - x) / wide;
      const dy = ((mark.y[i] as number) - y) / high;
      const far = dx * dx + dy * dy;
      if (far < best) [best, found] = [far, i];
    }
  }
  return found;
}
