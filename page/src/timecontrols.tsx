/** Time: reset, pause, step, speed. */

import { Button, ControlButton } from "./button";
import { useQuietStudio } from "./context";
import { useSlowNews } from "./news";
import type { SpeedFactor } from "./protocol";
import type { Studio } from "./studio";
import { formatTime } from "./words";

const SPEEDS: readonly SpeedFactor[] = [0.25, 0.5, 1, 2, 4, 8, 16, "fastest"];

export function TimeControls({ studio }: { studio: Studio }) {
  const paused = studio.status?.paused ?? false;
  const off = !studio.hasControl;
  const { real } = studio.live; // their time is that of the person, and there is no going back
  return (
    <div class="time-controls" role="toolbar" aria-label="Time">
      {!real && <Worlds studio={studio} />}
      <Button
        class="pause"
        disabled={off}
        aria-label={paused ? "Resume" : "Pause"}
        title={paused ? "Resume" : "Pause"}
        onClick={() => void studio.ask({ do: "pause", paused: !paused })}
      >
        {paused ? "▶" : "❚❚"} <kbd>␣</kbd>
      </Button>
      <Button
        disabled={off || !paused}
        aria-label="Step"
        title="One tick"
        onClick={() => void studio.ask({ do: "step" })}
      >
        Step <kbd>.</kbd>
      </Button>
      {!real && studio.session !== null && studio.session.mode !== "training" && (
        <Button
          disabled={off}
          title="Skip to where it needs you: nothing is learned on the way"
          onClick={() => void studio.ask({ do: "skip" })}
        >
          Skip <kbd>F</kbd>
        </Button>
      )}
      {!real && <SpeedSelect studio={studio} />}
      <Time />
    </div>
  );
}

function Worlds({ studio }: { studio: Studio }) {
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

function SpeedSelect({ studio }: { studio: Studio }) {
  return (
    <select
      aria-label="Speed"
      disabled={!studio.hasControl}
      value={String(studio.status?.speed ?? 1)}
      onChange={(event) => {
        const speed = SPEEDS.find((each) => String(each) === event.currentTarget.value);
        if (speed !== undefined) void studio.ask({ do: "speed", speed });
        event.currentTarget.blur();
      }}
    >
      {SPEEDS.map((speed) => (
        <option key={speed} value={String(speed)}>
          {speed === "fastest" ? speed : `${speed}×`}
        </option>
      ))}
    </select>
  );
}

function Time() {
  const studio = useQuietStudio();
  useSlowNews(studio.framed);
  return (
    <span class="soft time" title="Time in the world">
      {formatTime(studio.motion.last?.time ?? 0)}
    </span>
  );
}
