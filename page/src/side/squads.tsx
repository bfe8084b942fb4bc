/** The coordinators as a tree, the topmost first, and what their robots are at. */

import { useMemo, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { useStudio } from "../context";
import type { SquadSort } from "../protocol";
import type { Studio } from "../studio";
import { squadTree, type Squad } from "../squads";
import { className, formatCount, plain } from "../words";
import { countActivities } from "./activities";

/** The largest number of squads that are all shown unfolded at first. */
const FEW = 8;

interface Props {
  squads: readonly SquadSort[];
}

export function Squads({ squads }: Props) {
  const tops = useMemo(() => squadTree(squads), [squads]);
  const [turned, turn] = useState<ReadonlyMap<string, boolean>>(new Map());
  const toggle = (squad: Squad, open: boolean) => turn(new Map(turned).set(squad.name, open));
  return (
    <section>
      <h2>Team</h2>
      <Level squads={tops} opensBelow={tops.length <= FEW} turned={turned} toggle={toggle} />
    </section>
  );
}

interface LevelProps {
  squads: readonly Squad[];
  /** Whether those below are shown by default. */
  opensBelow: boolean;
  /** Squads that a person has unfolded or folded, by name. */
  turned: ReadonlyMap<string, boolean>;
  toggle: (squad: Squad, open: boolean) => void;
}

function Level({ squads, opensBelow, turned, toggle }: LevelProps) {
  const studio = useStudio();
  return (
    <ul>
      {squads.map((squad) => {
        const first = opensBelow || squad.below.some((each) => holds(each, studio));
        const open = squad.below.length > 0 && (turned.get(squad.name) ?? first);
        return (
          <li key={squad.name}>
            <div class="squad-row">
              {squad.below.length > 0 && (
                <Button
                  class="fold"
                  aria-expanded={open}
                  aria-label={`What ${squad.name} is made of`}
                  onClick={() => toggle(squad, !open)}
                />
              )}
              <Coordinator squad={squad} />
            </div>
            {open && (
              <div class="below">
                <Level squads={squad.below} opensBelow={false} turned={turned} toggle={toggle} />
              </div>
            )}
          </li>
        );
      })}
    </ul>
  );
}

function isTrained(squad: Squad, { session, sort, motion }: Studio): boolean {
  return sort === squad.sort && (session?.agent ?? motion.last?.agent ?? 0) === squad.number;
}

/** Whether it or one of those below it is trained. */
function holds(squad: Squad, studio: Studio): boolean {
  return isTrained(squad, studio) || squad.below.some((each) => holds(each, studio));
}

function Coordinator({ squad }: { squad: Squad }) {
  const studio = useStudio();
  const { session } = studio;
  const trained = isTrained(squad, studio);
  return (
    <ControlButton
      class={className("row", trained && "on")}
      aria-pressed={trained}
      disabled={trained}
      title={trained ? squad.doc : `${squad.doc} Train its coordinator`}
      request={{ do: "select_agent", agent: squad.number, sort: squad.sort }}
    >
      <span class={className("dot", trained && session?.mode)} />
      <b>{plain(squad.name)}</b>
      <span class="soft cut">
        ·{" "}
        {studio.sort !== null && session !== null
          ? plain(countActivities(studio, squad.robots))
          : formatCount(squad.robots.length, "robot")}
      </span>
    </ControlButton>
  );
}
