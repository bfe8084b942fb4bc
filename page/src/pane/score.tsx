/** In how many new worlds what is trained works, after each press; one click turns it off. */

import { usePanel, useStudio } from "../context";
import { className, plain } from "../words";

export function ScoreLine() {
  const studio = useStudio();
  const panel = usePanel();
  const { desk } = studio;
  if (desk === null || panel.form !== null || desk.score.text === "") return null;
  const { text, trend, enabled, running } = desk.score;
  const fell = trend === "falling";
  return (
    <section class={className("score", fell && "fell")} aria-label="In new worlds">
      <p role={fell ? "alert" : undefined} aria-live="polite" aria-busy={running}>
        {MARKS[trend]} {plain(text)}
      </p>
      {fell && desk.undoable !== null && (
        <button
          type="button"
          class="small"
          disabled={!studio.directs}
          onClick={() => void studio.change({ do: "undo" }, { do: "redo" })}
        >
          Undo
        </button>
      )}
      {!text.startsWith("not measured") && (
        <button
          type="button"
          class="small"
          disabled={!studio.directs}
          title="Test it in new worlds, and go to where it goes wrong, until it holds"
          onClick={() => void studio.ask({ do: "keep_going" })}
        >
          Keep going
        </button>
      )}
      <button
        type="button"
        class="link"
        disabled={!studio.directs}
        title="After each press it runs in worlds that it was not taught in, beside the one here"
        aria-pressed={enabled}
        onClick={() => void studio.ask({ do: "score" })}
      >
        {enabled ? "turn off" : "turn on"}
      </button>
    </section>
  );
}

const MARKS = { "": "", rising: "▲", falling: "▼", slower: "◔" } as const;
