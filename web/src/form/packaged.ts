// Packaged scenarios in groups, as the list of the bench shows them.

export interface Packaged {
  name: string;
  title: string;
  text: string;
}

/** Title of a group, and what its documents contain; the first that fits. */
const GROUPS: [title: string, mark: RegExp][] = [
  ["Controllers", /^\[+controllers?\b/m],
  ["Beams, motors and tests", /^kind *= *"(beam-|testing-machine)|^\[model\b/m],
  ["Fingers, hands, several wires", /^\[+actuators\b|^kind *= *"(finger|hand|rails)/m],
  ["One wire", /./],
];

/** Return the scenarios by group, one wire first. */
export function groupPackaged(all: Packaged[]): [title: string, scenarios: Packaged[]][] {
  const groupOf = ({ text }: Packaged): string => GROUPS.find(([, mark]) => mark.test(text))![0];
  return GROUPS.map(([title]): [string, Packaged[]] => [title, all.filter((one) => groupOf(one) === title)])
    .filter(([, scenarios]) => scenarios.length > 0)
    .reverse();
}
