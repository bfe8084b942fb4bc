/** What robots are at, in words. */

import { formatCall } from "../calls";
import type { Studio } from "../studio";

/** How many robots do what: "3 attack, 1 home". */
export function countActivities(studio: Studio, robots: readonly number[]): string {
  const counts = new Map<string, number>();
  for (const robot of robots) {
    const what = describeActivity(studio, robot);
    counts.set(what, (counts.get(what) ?? 0) + 1);
  }
  return [...counts].map(([what, count]) => `${count} ${what}`).join(", ");
}

export function describeActivity(studio: Studio, robot: number): string {
  const number = studio.motion.last?.robots.doing[robot] ?? -1;
  const { session } = studio;
  if (studio.sort !== null && session !== null) return session.activities[number] ?? "idle";
  const state = session?.states[number];
  if (state !== undefined) return state.name;
  const agent = studio.team?.agents.find(({ name }) => name === studio.scene?.real_robots[robot]);
  if (agent !== undefined && !studio.session?.others) return agent.states[0] ?? "idle";
  return studio.session?.others ? formatCall(studio.session.others) : "idle";
}
