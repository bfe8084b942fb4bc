/** The page on which a person drives: the timeline that grows, the world, the stick, and the review of the drive. */

import { useEffect } from "preact/hooks";
import { Button } from "../button";
import { listenTo } from "../listen";
import { useNews } from "../news";
import { listen } from "../recording/page";
import { Bar, ReviewButton } from "../recording/bar";
import { ReviewPane } from "../recording/pane";
import { TimelineView } from "../recording/timeline";
import { hasKeys } from "../words";
import { Controls } from "./controls";
import type { DriveController } from "./driving";
import { DrivenWorld } from "./world";

export function DrivePage({ driving }: { driving: DriveController }) {
  const { recording, status, scene } = driving;
  useNews(driving.news);
  useNews(recording.news);
  useEffect(() => driving.listen(), [driving]);
  useEffect(() => steer(driving), [driving]);
  useEffect(() => listen(recording, () => driving.steers), [driving]);
  if (status === null || scene === null) return <p class="wait">{driving.lost || "Opening the world …"}</p>;
  const { review, series } = recording;
  const error = driving.lost || status.error || recording.error;
  const idle = recording.busy === null;
  return (
    <div class="recording driving">
      <DriveBar driving={driving} error={error} />
      <main>
        {review === null || series === null ? (
          <Hint driving={driving} />
        ) : (
          <TimelineView recording={recording} review={review} series={series.series} live={driving.driving} />
        )}
        <DrivenWorld driving={driving} />
      </main>
      <div class="beside">
        <Controls driving={driving} />
        {review !== null && <ReviewPane recording={recording} review={review} />}
        {review !== null && idle && status.folder !== null && (
          <p class="tiny soft kept">Recorded in the folder {status.folder}.</p>
        )}
      </div>
    </div>
  );
}

function DriveBar({ driving, error }: { driving: DriveController; error: string }) {
  const { recording, scene } = driving;
  const { review, busy } = recording;
  const driven = review === null ? 0 : recording.ticks * review.tick_s;
  const moves = driving.driving || driving.automatic;
  const changes = busy !== null && busy !== "drive" && busy !== "automatic";
  return (
    <Bar title={scene?.scenario} error={error}>
      <span class="soft seed">seed {scene?.seed}</span>
      <span class="soft">{driven.toFixed(0)} s</span>
      <span class="space" />
      {review !== null && (
        <ReviewButton recording={recording} disabled={!review.can_undo} request={{ do: "undo" }}>
          Undo
        </ReviewButton>
      )}
      <Button
        disabled={moves || changes}
        title="The same drive goes on in another world"
        onClick={() => driving.send({ do: "new_world" })}
      >
        New world
      </Button>
      {review !== null && (
        <Button
          disabled={review.learned === null || busy !== null || driving.lost !== ""}
          title={
            review.learned === null
              ? "Learn from the labels first"
              : "The automaton that was learned drives, until you move the stick"
          }
          onClick={(event) => {
            driving.letDrive();
            event.currentTarget.blur();
          }}
        >
          Let it drive
        </Button>
      )}
      <Button
        class="primary turn"
        disabled={changes || driving.lost !== ""}
        onClick={(event) => {
          driving.turn();
          if (event.detail > 0) event.currentTarget.blur(); // the space bar is the page's again
        }}
      >
        {moves ? "Pause" : "Drive"}
      </Button>
    </Bar>
  );
}

/** What to do, before anything was driven. */
function Hint({ driving }: { driving: DriveController }) {
  return (
    <section class="driving-hint" aria-label="Timeline">
      <p>
        <b>Drive the robot, and it learns from how you drive.</b>
      </p>
      <p class="soft">
        Drag the stick with the mouse or a finger
        {hasKeys() && ", use the arrow keys after a press of the space bar"}
        {driving.hasPad
          ? ", or the left stick of the gamepad after a press of Start."
          : ", or connect a gamepad."}{" "}
        The behaviors that explain your commands appear here while you drive.
      </p>
    </section>
  );
}

/** Keys: the space bar drives and pauses; while a person drives, arrows and letters are the stick's. */
function steer(driving: DriveController): () => void {
  const down = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLInputElement) return;
    if (event.key === " ") {
      if (event.target instanceof HTMLButtonElement) return; // which it presses
      if (!event.repeat) driving.turn();
    } else if (!driving.steers || !driving.stick.press(event)) return;
    else if (!event.repeat) driving.steer();
    event.preventDefault();
  };
  const up = (event: KeyboardEvent): void => {
    driving.stick.lift(event);
    if (driving.driving || driving.automatic) driving.steer();
  };
  return listenTo(globalThis, { keydown: down, keyup: up });
}
