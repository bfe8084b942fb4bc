/** The header: what is trained and where, time, mode, saving. */

import { useQuietStudio, useStudio } from "./context";
import { useSlowNews } from "./news";
import type { Studio } from "./studio";
import { className, clock } from "./words";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];

export function Header() {
  const studio = useStudio();
  const { desk, scene } = studio;
  return (
    <header class="header">
      <h1 class="logo">Understudy</h1>
      <span class="divider" />
      <span class="what">
        {desk === null ? (
          <span class="soft">nothing is trained yet</span>
        ) : (
          <b>
            {desk.name}
            {desk.parameters.length > 0 && <span class="soft"> ({desk.parameters.join(", ")})</span>}
          </b>
        )}
      </span>
      {scene !== null && <Place studio={studio} scenario={scene.scenario} />}
      <span class="space" />
      <Running studio={studio} />
      <span class="space" />
      {desk !== null && <ModeSwitch studio={studio} />}
      <Saving studio={studio} />
    </header>
  );
}

function Place({ studio, scenario }: { studio: Studio; scenario: string }) {
  const seed = studio.told?.seed ?? studio.scene?.seed ?? null;
  const go = (event: Event): void => {
    const field = event.currentTarget as HTMLInputElement;
    const wanted = Number(field.value);
    if (field.value === "" || !Number.isInteger(wanted) || wanted < 0) field.value = String(seed ?? "");
    else void studio.ask({ do: "reset", seed: wanted });
    field.blur();
  };
  return (
    <span class="soft place">
      in {scenario},{" "}
      <label>
        seed{" "}
        <input
          class="seed"
          inputMode="numeric"
          disabled={!studio.directs}
          value={seed === null ? "" : String(seed)}
          onChange={go}
          title="Another number, another world"
        />
      </label>
    </span>
  );
}

function Running({ studio }: { studio: Studio }) {
  const paused = studio.told?.paused ?? false;
  const off = !studio.directs;
  const seed = studio.told?.seed ?? studio.scene?.seed ?? 0;
  return (
    <div class="running" role="toolbar" aria-label="Time">
      <button
        type="button"
        class="icon"
        disabled={off}
        aria-label="Reset"
        title="The same world again"
        onClick={() => void studio.ask({ do: "reset", seed: null })}
      >
        ↺
      </button>
      <button
        type="button"
        disabled={off}
        title="The next world"
        onClick={() => void studio.ask({ do: "reset", seed: seed + 1 })}
      >
        New world
      </button>
      <button
        type="button"
        class="pause"
        disabled={off}
        aria-pressed={paused}
        aria-label={paused ? "Go on" : "Pause"}
        onClick={() => void studio.ask({ do: "pause", paused: !paused })}
      >
        {paused ? "▶ Go on" : "❚❚ Pause"} <kbd>␣</kbd>
      </button>
      <button
        type="button"
        disabled={off || !paused}
        aria-label="Step"
        title="One tick"
        onClick={() => void studio.ask({ do: "step" })}
      >
        Step <kbd>.</kbd>
      </button>
      <select
        aria-label="Speed"
        disabled={off}
        value={String(studio.told?.speed ?? 1)}
        onChange={(event) => {
          void studio.ask({ do: "speed", speed: Number(event.currentTarget.value) });
          event.currentTarget.blur();
        }}
      >
        {SPEEDS.map((speed) => (
          <option key={speed} value={String(speed)}>
            {speed}×
          </option>
        ))}
      </select>
      <Time />
    </div>
  );
}

function Time() {
  const studio = useQuietStudio();
  useSlowNews(studio.framed, 90);
  return (
    <span class="soft time" title="Time in the world">
      {clock(studio.motion.last?.time ?? 0)}
    </span>
  );
}

function ModeSwitch({ studio }: { studio: Studio }) {
  const mode = studio.desk?.mode ?? "training";
  return (
    <div class={className("modes", mode)} role="group" aria-label="Mode">
      {(["training", "testing"] as const).map((each) => (
        <button
          type="button"
          key={each}
          aria-pressed={mode === each}
          disabled={!studio.directs}
          title={
            each === "training" ? "You decide; each press is an example" : "It decides; a press corrects it"
          }
          onClick={() => void (mode !== each && studio.ask({ do: "turn" }))}
        >
          {each === "training" ? "Training" : "Testing"}
          {mode !== each && <kbd>T</kbd>}
        </button>
      ))}
    </div>
  );
}

function Saving({ studio }: { studio: Studio }) {
  const { desk, told } = studio;
  if (desk === null) return null;
  const saved = told?.library.trained.some(({ name }) => name === desk.name) ?? false;
  return (
    <div class="saving">
      <span class="soft" title="Every press is written to a journal at once, so nothing is ever lost.">
        <span class={className("dot", (desk.unsaved || !saved) && "open")} />
        {desk.unsaved ? "every press kept" : saved ? "in the library" : "nothing to save yet"}
      </span>
      {(told?.viewers ?? 1) > 1 && studio.directs && (
        <button
          type="button"
          title="Let somebody else direct"
          onClick={() => void studio.ask({ do: "hand_over" })}
        >
          Hand over
        </button>
      )}
      <button
        type="button"
        disabled={!studio.directs || !desk.unsaved}
        onClick={() => void studio.ask({ do: "save", name: null })}
      >
        Save
      </button>
    </div>
  );
}
