// What things are made of, in colours of the page.

import { Color, DoubleSide, MeshBasicMaterial, MeshLambertMaterial, MeshStandardMaterial } from "three";

export interface Colours {
  back: string;
  ink: string;
  soft: string;
  line: string;
  spring: string;
  weight: string;
  rotor: string;
  accent: string;
}

export type Made =
  | "frame" | "wall" | "link" | "bone" | "pad" | "steel" | "dark" | "spring" | "weight" | "rotor" | "thread" | "wheel"
  | "plate" | "gripped" | "force";

/** How rough, and how much of a metal; without surroundings to mirror, a metal would be black. */
const LOOKS: Record<Made, [roughness: number, metalness: number]> = {
  frame: [0.75, 0], wall: [0.9, 0], link: [0.5, 0.15], bone: [0.55, 0], pad: [0.9, 0], steel: [0.35, 0.3],
  dark: [0.5, 0.2], spring: [0.4, 0.2], weight: [0.4, 0.2], rotor: [0.45, 0.1], thread: [0.8, 0], wheel: [0.45, 0.2],
  plate: [0.5, 0.1], gripped: [0.35, 0], force: [0.6, 0],
};

/** What can be painted. */
export type Paint = MeshLambertMaterial | MeshStandardMaterial;

export class Materials {
  readonly made: Record<Made, Paint>;
  /** What a broken part is covered with. */
  readonly back = new MeshBasicMaterial();

  /** `fine`: with highlights, which cost a processor that draws by itself twice as much. */
  constructor(private readonly fine: boolean) {
    const all = Object.entries(LOOKS).map(([name, [roughness, metalness]]) => [name, this.make(roughness, metalness)]);
    this.made = Object.fromEntries(all) as Record<Made, Paint>;
    this.made.plate.side = DoubleSide;
  }

  /** Take on colours; whether they are those of a dark page. */
  paint(colours: Colours): boolean {
    const { made } = this;
    const [back, ink, soft] = [new Color(colours.back), new Color(colours.ink), new Color(colours.soft)];
    const dark = luminance(back) < 0.3;
    const mixed = (colour: Color, share: number, into: Color): Color => colour.clone().lerp(into, share);
    const white = new Color(0xffffff);
    made.wall.color.copy(mixed(soft, 0.45, back));
    made.frame.color.copy(mixed(soft, 0.3, back));
    made.link.color.copy(mixed(soft, dark ? 0.2 : 0.35, white));
    made.bone.color.set(dark ? 0xd9cfbd : 0xefe3cf);
    made.pad.color.set(dark ? 0x8c6f5c : 0x9c7a63);
    made.steel.color.copy(mixed(soft, 0.3, white));
    made.dark.color.copy(dark ? mixed(soft, 0.55, back) : mixed(ink, 0.25, back));
    made.spring.color.set(colours.spring);
    made.weight.color.set(colours.weight);
    made.rotor.color.set(colours.rotor);
    made.thread.color.copy(soft);
    made.wheel.color.copy(mixed(soft, 0.4, white));
    made.plate.color.copy(mixed(soft, dark ? 0.25 : 0.55, white));
    made.gripped.color.set(colours.accent).lerp(back, 0.35);
    made.force.color.set(colours.accent);
    this.back.color.copy(back);
    return dark;
  }

  make(roughness: number, metalness = 0): Paint {
    return this.fine ? new MeshStandardMaterial({ roughness, metalness }) : new MeshLambertMaterial();
  }

  dispose(): void {
    for (const material of [...Object.values(this.made), this.back]) material.dispose();
  }
}

const luminance = ({ r, g, b }: Color): number => 0.21 * r + 0.72 * g + 0.07 * b;
