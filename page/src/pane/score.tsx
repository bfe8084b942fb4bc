/** In how many new worlds what is trained works, after each press, and what that means; one click turns it off. */

import { useState } from "preact/hooks";
import { ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { ShowGrid } from "../gridview";
import type { Score } from "../protocol";
import { className, plain } from "../words";

export function ScoreLine() {
  const studio = useStudio();
  const panel = usePanel();
  const { session } = studio;
  if (!studio.offers.includes("runs") || session === null || panel.form !== null) return null;
  if (session.score.text === "") return <LineWithoutScore />;
  const { text, trend, enabled, running, goal, worse_since } = session.score;
  const fell = trend === "falling";
  const testable = enabled ? !text.startsWith("not measured") : goal !== "" && text === TURNED_OFF;
  return (
    <section class={className("score", fell && "fell")} aria-label="In new worlds">
      <div class="score-line">
        <p role={fell ? "alert" : undefined} aria-live="polite" aria-busy={running}>
          {MARKS[trend]} {plain(text)}
        </p>
        {fell && session.undoable !== null && worse_since === "" && (
          <ControlButton class="small" request={{ do: "undo" }} back={{ do: "redo" }}>
            Undo
          </ControlButton>
        )}
        {testable && (
          <ControlButton
            class="small"
            title="Test it in new worlds, and go to where it goes wrong, until it holds"
            request={{ do: "keep_going" }}
          >
            Keep going
          </ControlButton>
        )}
        {testable && <ShowGrid />}
        <ControlButton
          class="link"
          title="After each press it runs in worlds that it was not taught in, beside the one here"
          aria-pressed={enabled}
          request={{ do: "toggle_score" }}
        >
          {enabled ? "turn off" : "turn on"}
        </ControlButton>
      </div>
      {worse_since !== "" && (
        <p>
          It worked in more new worlds before.{" "}
          <ControlButton
            class="small"
            title="Back to the version that worked in most new worlds, and to where it goes wrong"
            request={{ do: "go_back_to_best" }}
          >
            Undo {worse_since}
          </ControlButton>
        </p>
      )}
      <GoalLine score={session.score} />
    </section>
  );
}

/** Before the first press here there is no score, but what was taught before can run in other worlds. */
function LineWithoutScore() {
  const studio = useStudio();
  if (studio.session?.score.goal === "" || studio.session?.presses === 0) return null;
  return (
    <section class="score" aria-label="In new worlds">
      <div class="score-line">
        <p>In new worlds</p>
        <ShowGrid />
      </div>
    </section>
  );
}

/** What success means: what counts now, and for a behavior without a flag, goals to choose from. */
function GoalLine({ score }: { score: Score }) {
  const studio = useStudio();
  const [choosing, setChoosing] = useState(false);
  const { goal, chosen, offers } = score;
  if (goal === "" && offers.length === 0) return null;
  const pick = (name: string | null) => {
    setChoosing(false);
    void studio.change({ do: "choose_goal", goal: name }, { do: "undo" });
  };
  const others = offers.filter(({ name }) => name !== goal);
  return (
    <div class="goal">
      {goal !== "" && (
        <p>
          Success: {plain(goal)}
          {offers.length > 0 && (
            <ControlButton class="link" aria-expanded={choosing} onClick={() => setChoosing(!choosing)}>
              change
            </ControlButton>
          )}
        </p>
      )}
      {(choosing || goal === "") && (
        <ul class="choices" aria-label="What success can mean">
          {others.map(({ name, claim }) => (
            <li key={name}>
              <ControlButton class="small" title={plain(claim)} onClick={() => pick(name)}>
                {plain(name)}
              </ControlButton>
            </li>
          ))}
          {chosen && (
            <li>
              <ControlButton class="link" onClick={() => pick(null)}>
                none of them
              </ControlButton>
            </li>
          )}
        </ul>
      )}
    </div>
  );
}

const TURNED_OFF = "not measured: turned off"; // which ends the runs after each press, and no test that is asked for
const MARKS = { "": "", rising: "▲", falling: "▼", slower: "◔" } as const;
