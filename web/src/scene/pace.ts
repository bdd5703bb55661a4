// How pictures adapt to a processor that draws them: the cost of the last one decides resolution, shadow and rest.

/** Shortest time between two pictures while something can be held, or runs follow a slider [ms]: two frames of the
 * browser, so that curves and controls keep their share of the processor. */
export const SELDOM = 30;
/** Shortest rest before a picture with all details [ms]. */
const REST = 400;
/** Rest per cost of a picture. */
const RESTS = 3;
/** A rest is also twice as long as the pause between changes, for pauses up to this [ms]: every change would end a rest. */
const PAUSE = 3000;
/** Changes closer than this belong to one motion [ms]. */
const MOTION = 100;
/** Shortest time between two shadows in motion [ms], and as a multiple of the cost. */
const [SHADOW, SHADOWS] = [400, 10];
/** Cost up to which motion is drawn with all pixels, and from which with the fewest [ms]. */
const [CHEAP, DEAR] = [25, 120];
/** Pixels of the picture per pixel of the page in motion. */
const [COARSE, COARSEST] = [0.7, 0.5];
/** Rows of a picture, at least: with fewer, a wire is thinner than a pixel and disappears. */
const FEWEST = 150;

export class Pace {
  /** Cost of the last picture with one pixel per pixel of the page [ms]. */
  private cost = 0;
  private changed = -Infinity;
  private pause = 0;
  private shaded = -Infinity;
  /** What the last picture lacks. */
  private isCoarse = false;
  private isOld = false;

  /** Note a change of the scene at a time [ms]. */
  change(now: number): void {
    const since = now - this.changed;
    if (since > MOTION) this.pause = since < PAUSE ? since : 0;
    this.changed = now;
  }

  /** Return resolution and shadow of the next picture, which is `height` pixels of the page high. */
  begin(now: number, isMoving: boolean, height: number): { pixels: number; shadow: boolean } {
    const chosen = !isMoving || this.cost <= CHEAP ? 1 : this.cost < DEAR ? COARSE : COARSEST;
    const pixels = Math.min(Math.max(chosen, FEWEST / height), 1);
    const shadow = !isMoving || now - this.shaded > Math.max(SHADOW, SHADOWS * this.cost);
    if (shadow) this.shaded = now;
    this.isCoarse = pixels < 1;
    this.isOld = !shadow;
    return { pixels, shadow };
  }

  /** Note that the picture took a time [ms] at a resolution. */
  end(took: number, pixels: number): void {
    this.cost = took / pixels ** 2;
  }

  /** Time until the picture with all details may be drawn [ms]; null if the last one has them. */
  get rest(): number | null {
    return this.isCoarse || this.isOld ? Math.max(REST, RESTS * this.cost, 2 * this.pause) : null;
  }
}
