/** A team as a tree: which squads each squad is made of. */

import type { SquadSort } from "./protocol";

export interface Squad {
  sort: string;
  /** Its number among those of its sort. */
  number: number;
  /** squad 3; of one of its kind, its sort alone. */
  name: string;
  doc: string;
  robots: readonly number[];
  below: readonly Squad[];
}

/** The topmost squads, each with those below it; sorts are given the topmost first. */
export function squadTree(sorts: readonly SquadSort[]): Squad[] {
  const tops: Squad[] = [];
  const over = new Map<number, Squad[]>(); // the squads below the last one that a robot was found in
  for (const { name: sort, doc, squads } of sorts) {
    const places = squads.map((robots) => over.get(robots[0] ?? -1) ?? tops);
    squads.forEach((robots, number) => {
      const below: Squad[] = [];
      const name = squads.length > 1 ? `${sort} ${number + 1}` : sort;
      places[number]?.push({ sort, number, name, doc, robots, below });
      for (const robot of robots) over.set(robot, below);
    });
  }
  return tops;
}
