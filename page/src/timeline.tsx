/** The run so far as a line to go back on, with a mark for each press that was recorded, and where it was unsure. */

import { useRef } from "preact/hooks";
import { useStudio } from "./context";
import { useSlowNews } from "./news";
import type { RunHistory } from "./runhistory";
import { className, formatTime } from "./words";

const STEP_S = 0.5;

export function Timeline() {
  const studio = useStudio();
  useSlowNews(studio.framed);
  const pending = useRef(false);
  const { runHistory, session } = studio;
  if (session === null || studio.live.fixed) return null; // real robots cannot go back, nor can a body of one's own

  const goBack = async (time: number): Promise<void> => {
    if (pending.current) return; // the last one counts, when the server is ready for it
    pending.current = true;
    await studio.ask({ do: "rewind", time_s: time });
    pending.current = false;
  };

  return (
    <div class="flex timeline">
      <div class="line">
        {runHistory.marks.map((mark) => (
          <span
            key={mark.number}
            class={className("mark", mark.correction && "correction")}
            style={{ left: share(runHistory, mark.time) }}
            title={`example ${mark.number}, at ${formatTime(mark.time)}`}
          />
        ))}
        {session.queries.marks
          .filter(({ run, time_s }) => run === studio.status?.run.number && time_s <= runHistory.latest)
          .map((mark) => (
            <span
              key={`unsure ${mark.number}`}
              class="mark unsure"
              style={{ left: share(runHistory, mark.time_s) }}
              title={`unsure at ${formatTime(mark.time_s)}`}
            />
          ))}
        <input
          type="range"
          aria-label="Rewind"
          aria-valuetext={formatTime(runHistory.now)}
          min={runHistory.from}
          max={runHistory.latest}
          step="any"
          value={runHistory.now}
          disabled={!studio.hasControl || runHistory.latest - runHistory.from < STEP_S}
          onInput={(event) => void goBack(Number(event.currentTarget.value))}
          onKeyDown={(event) => {
            const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
            if (way === undefined) return;
            event.preventDefault();
            void goBack(
              Math.min(runHistory.latest, Math.max(runHistory.from, runHistory.now + way * STEP_S)),
            );
          }}
        />
      </div>
      <span class="hint">
        {runHistory.now < runHistory.latest ? "going on begins here" : "drag to rewind"}
      </span>
    </div>
  );
}

function share(past: RunHistory, time: number): string {
  const length = Math.max(past.latest - past.from, STEP_S);
  return `${(100 * Math.min(1, Math.max(0, (time - past.from) / length))).toFixed(2)}%`;
}
