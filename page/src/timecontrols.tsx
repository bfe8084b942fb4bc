/** Time: reset, pause, step, speed. */

import { ControlButton } from "./button";
import { useQuietStudio, useStudio } from "./context";
import { ControlSelect } from "./fields";
import { KeyName } from "./keyname";
import { useSlowNews } from "./news";
import type { SpeedFactor } from "./protocol";
import { formatTime } from "./words";

const SPEEDS: readonly SpeedFactor[] = [0.25, 0.5, 1, 2, 4, 8, 16, "fastest"];

export function TimeControls() {
  const studio = useStudio();
  const paused = studio.status?.paused ?? false;
  const { real } = studio.live; // their time is that of the person, and there is no going back
  return (
    <div class="flex time-controls" role="toolbar" aria-label="Time">
      {!real && <Worlds />}
      <ControlButton
        class="pause"
        aria-label={paused ? "Resume" : "Pause"}
        title={paused ? "Resume" : "Pause"}
        request={{ do: "pause", paused: !paused }}
      >
        {paused ? "▶" : "❚❚"} <kbd>␣</kbd>
      </ControlButton>
      <ControlButton disabled={!paused} aria-label="Step" title="One tick" request={{ do: "step" }}>
        Step <KeyName place="Period" />
      </ControlButton>
      {!real && studio.session !== null && studio.session.mode !== "training" && (
        <ControlButton
          title="Skip to where it needs you: nothing is learned on the way"
          request={{ do: "skip" }}
        >
          Skip <KeyName place="KeyF" shift />
        </ControlButton>
      )}
      {!real && <SpeedSelect />}
      <Time />
    </div>
  );
}

function Worlds() {
  const studio = useStudio();
  const seed = studio.status?.seed ?? studio.scene?.seed ?? 0;
  return (
    <>
      <ControlButton
        class="icon"
        aria-label="Reset"
        title="The same world again"
        request={{ do: "reset", seed: null }}
      >
        ↺
      </ControlButton>
      <ControlButton title="The next world" request={{ do: "reset", seed: seed + 1 }}>
        New world
      </ControlButton>
    </>
  );
}

function SpeedSelect() {
  const studio = useStudio();
  return (
    <ControlSelect
      aria-label="Speed"
      value={String(studio.status?.speed ?? 1)}
      among={SPEEDS.map((speed) => [String(speed), speed === "fastest" ? speed : `${speed}×`])}
      change={(wanted) => {
        const speed = SPEEDS.find((each) => String(each) === wanted);
        if (speed !== undefined) void studio.ask({ do: "speed", speed });
      }}
    />
  );
}

function Time() {
  const studio = useQuietStudio();
  useSlowNews(studio.framed);
  return (
    <span class="soft number time" title="Time in the world">
      {formatTime(studio.motion.last?.time ?? 0)}
    </span>
  );
}
