/** The page of a recording: its timeline, what is selected, questions, and what was learned. */

import { useEffect } from "preact/hooks";
import { keyboard, readShortcut } from "../keyboard";
import { listenTo } from "../listen";
import { useNews } from "../news";
import { Bar, ReviewButton } from "./bar";
import { PathView } from "./path";
import { filesIn, type Recording } from "./recording";
import { ReviewPane } from "./pane";
import { TimelineView } from "./timeline";

export function RecordingPage({ recording }: { recording: Recording }) {
  useNews(recording.news);
  useEffect(() => listen(recording), [recording]);
  const { review, series, error } = recording;
  if (review === null || series === null) return <p class="wait">{error || "Reading the recording …"}</p>;
  const files = filesIn(review, { first: 0, end: recording.ticks });
  const seconds = review.episodes.reduce((sum, { first, end }) => sum + (end - first) * review.tick_s, 0);
  return (
    <div class="recording">
      <Bar title={files.join(", ")} error={error}>
        <span class="soft">{seconds.toFixed(0)} s</span>
        <span class="space" />
        <ReviewButton recording={recording} disabled={!review.can_undo} request={{ do: "undo" }}>
          Undo
        </ReviewButton>
      </Bar>
      <main>
        <TimelineView recording={recording} review={review} series={series.series} />
        {series.path.length > 1 && <PathView recording={recording} review={review} series={series} />}
      </main>
      <ReviewPane recording={recording} review={review} />
    </div>
  );
}

/** Keys: digits label what is selected, arrows go to the next span, Ctrl Z takes back. */
export function listen(recording: Recording, suspended = (): boolean => false): () => void {
  const press = (event: KeyboardEvent): void => {
    keyboard.learn(event);
    if (event.target instanceof HTMLInputElement || suspended()) return;
    const digit = keyboard.digit(event);
    if ((event.ctrlKey || event.metaKey) && !event.altKey && readShortcut(event) === "z")
      void recording.ask({ do: "undo" });
    else if (event.ctrlKey || event.metaKey || event.altKey) return;
    else if (digit !== null)
      void recording.label((digit === 0 ? (recording.review?.labels.length ?? 0) : digit) - 1);
    else if (event.key === "ArrowRight" || event.key === "ArrowLeft")
      recording.step(event.key === "ArrowRight" ? 1 : -1);
    else if (event.key === "Escape") recording.select(null);
    else return;
    event.preventDefault();
  };
  void keyboard.ask();
  return listenTo(globalThis, { keydown: press });
}
