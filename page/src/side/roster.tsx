/** The robots, and which one is trained. */

import { called } from "../calls";
import { useStudio } from "../context";
import { useSlowNews } from "../news";
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
  return (
    <section>
      <h2>Robots</h2>
      <ul class="rows">
        {few.map((robot) => {
          const trained = robot === chosen;
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
                <span class="soft">
                  · {trained && desk !== null ? "being trained" : doing(studio, robot)}
                </span>
              </button>
            </li>
          );
        })}
      </ul>
      {scene.robots > few.length && <p class="tiny">and {counted(scene.robots - few.length, "other")}</p>}
      <Others />
    </section>
  );
}

function doing(studio: Studio, robot: number): string {
  const state = studio.desk?.states[studio.motion.last?.robots.doing[robot] ?? -1];
  if (state !== undefined) return state.name;
  return studio.desk?.others ? called(studio.desk.others) : "idles";
}
