/** The robots, and which one is trained. */

import { called } from "../calls";
import { useStudio } from "../context";
import { useSlowNews } from "../news";
import type { SquadSort } from "../protocol";
import type { Studio } from "../studio";
import { className, counted } from "../words";
import { Others } from "./others";

const MOST = 6;

export function Roster() {
  const studio = useStudio();
  useSlowNews(studio.framed, 200);
  const { scene, desk, directs, motion } = studio;
  if (scene === null) return null;
  const chosen = desk?.agent ?? motion.last?.agent ?? 0;
  const shown = Array.from({ length: scene.robots }, (_, robot) => robot);
  const few = shown.filter((robot) => robot < MOST || robot === chosen);
  const { sort } = studio;
  return (
    <>
      {scene.squads.length > 0 && <Squads studio={studio} squads={scene.squads} />}
      <section>
        <h2>Robots</h2>
        <ul class="rows">
          {few.map((robot) => {
            const trained = sort === null && robot === chosen;
            return (
              <li key={robot}>
                <button
                  type="button"
                  class={className("row", trained && "on")}
                  aria-pressed={trained}
                  disabled={!directs || trained}
                  title={trained ? "" : "Train this one (Shift and its number)"}
                  onClick={() => void studio.ask({ do: "agent", agent: robot })}
                >
                  <span class={className("dot", trained && desk?.mode)} />
                  robot {robot + 1}
                  <span class="soft cut">
                    · {trained && desk !== null ? "being trained" : doing(studio, robot)}
                  </span>
                </button>
              </li>
            );
          })}
        </ul>
        {scene.robots > few.length && <p class="tiny">and {counted(scene.robots - few.length, "other")}</p>}
        {sort === null && <Others />}
      </section>
    </>
  );
}

interface SquadsProps {
  studio: Studio;
  squads: readonly SquadSort[];
}

/** The coordinators, the topmost first, and what their robots are at. */
function Squads({ studio, squads }: SquadsProps) {
  const { desk, directs, sort, motion } = studio;
  const chosen = desk?.agent ?? motion.last?.agent ?? 0;
  return (
    <section>
      <h2>Team</h2>
      <ul class="rows">
        {squads.map(({ name, doc, squads: numbered }) =>
          numbered.map((robots, number) => {
            const trained = sort === name && chosen === number;
            return (
              <li key={`${name} ${number}`}>
                <button
                  type="button"
                  class={className("row", trained && "on")}
                  aria-pressed={trained}
                  disabled={!directs || trained}
                  title={trained ? doc : `${doc} Train its coordinator`}
                  onClick={() => void studio.ask({ do: "agent", agent: number, sort: name })}
                >
                  <span class={className("dot", trained && desk?.mode)} />
                  <b>
                    {name}
                    {numbered.length > 1 ? ` ${number + 1}` : ""}
                  </b>
                  <span class="soft cut">
                    · {trained && desk !== null ? atWork(studio, robots) : counted(robots.length, "robot")}
                  </span>
                </button>
              </li>
            );
          }),
        )}
      </ul>
    </section>
  );
}

/** How many robots do what: "3 attack, 1 home". */
function atWork(studio: Studio, robots: readonly number[]): string {
  const counts = new Map<string, number>();
  for (const robot of robots) {
    const what = doing(studio, robot);
    counts.set(what, (counts.get(what) ?? 0) + 1);
  }
  return [...counts].map(([what, count]) => `${count} ${what}`).join(", ");
}

function doing(studio: Studio, robot: number): string {
  const number = studio.motion.last?.robots.doing[robot] ?? -1;
  const { desk } = studio;
  if (studio.sort !== null && desk !== null) return desk.doing[number] ?? "idles";
  const state = desk?.states[number];
  if (state !== undefined) return state.name;
  return studio.desk?.others ? called(studio.desk.others) : "idles";
}
