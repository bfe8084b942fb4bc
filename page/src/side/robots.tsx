/** The robots, and which one is trained. */

import { ControlButton } from "../button";
import { useStudio } from "../context";
import { keyboard } from "../keyboard";
import { useSlowNews } from "../news";
import { className, formatCount, plain } from "../words";
import { describeActivity } from "./activities";
import { Others } from "./others";
import { Squads } from "./squads";

const MOST = 6;

export function RobotList() {
  const studio = useStudio();
  useSlowNews(studio.framed);
  const { scene, session, motion } = studio;
  if (scene === null) return null;
  const chosen = session?.agent ?? motion.last?.agent ?? 0;
  const robots = Array.from({ length: scene.robots }, (_, robot) => robot);
  const few = robots.filter((robot) => robot < MOST || robot === chosen);
  const { sort } = studio;
  return (
    <>
      {scene.squads.length > 0 && <Squads squads={scene.squads} />}
      <section>
        <h2>Robots</h2>
        <ul>
          {few.map((robot) => {
            const trained = sort === null && robot === chosen;
            return (
              <li key={robot}>
                <ControlButton
                  class={className("row", trained && "on")}
                  aria-pressed={trained}
                  disabled={trained}
                  title={
                    trained ? "" : `Train this one${keyboard.shiftsDigits ? "" : " (Shift and its number)"}`
                  }
                  request={{ do: "select_agent", agent: robot }}
                >
                  <span class={className("dot", trained && session?.mode)} />
                  {scene.real_robots[robot] ?? `robot ${robot + 1}`}
                  <span class="soft cut">
                    · {trained && session !== null ? "being trained" : plain(describeActivity(studio, robot))}
                  </span>
                </ControlButton>
              </li>
            );
          })}
        </ul>
        {scene.robots > few.length && (
          <p class="tiny">and {formatCount(scene.robots - few.length, "other")}</p>
        )}
        {sort === null && <Others />}
      </section>
    </>
  );
}
