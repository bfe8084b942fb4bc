/** The header: what is trained and where, time, mode, saving. */

import { useRef, useState } from "preact/hooks";
import { Button, ControlButton } from "./button";
import { useStudio } from "./context";
import { ControlSelect } from "./fields";
import { KeyName } from "./keyname";
import { TimeControls } from "./timecontrols";
import { className, plain } from "./words";

export function Header() {
  const studio = useStudio();
  const { session, scene } = studio;
  const { real } = studio.live;
  const overview = studio.team !== null && studio.view === "team";
  return (
    <header class="flex header">
      <h1 class="logo">Understudy</h1>
      <span class="divider" />
      {studio.team !== null && <Views />}
      {overview ? null : (
        <>
          <span class="what cut">
            {session === null ? (
              <span class="soft">No automaton open</span>
            ) : (
              <b>
                {plain(session.name)}
                {session.parameters.length > 0 && (
                  <span class="soft"> ({session.parameters.join(", ")})</span>
                )}
              </b>
            )}
          </span>
        </>
      )}
      {scene !== null && !real && <WorldPlace scenario={scene.scenario} />}
      {real && studio.team === null && <span class="soft">on {scene?.real_robots.join(", ")}</span>}
      <span class="space" />
      {!overview && <TimeControls />}
      <span class="space" />
      {!overview && session !== null && <ModeSwitch />}
      <SaveControls />
    </header>
  );
}

/** Whether the page shows the running team, or the training of one of its agents. */
function Views() {
  const studio = useStudio();
  return (
    <div class="segments" role="group" aria-label="View">
      {(["team", "training"] as const).map((each) => (
        <Button key={each} aria-pressed={studio.view === each} onClick={() => studio.switchView(each)}>
          {each === "team" ? "Team" : "Training"}
        </Button>
      ))}
    </div>
  );
}

function WorldPlace({ scenario }: { scenario: string }) {
  const studio = useStudio();
  const seed = studio.status?.seed ?? studio.scene?.seed ?? null;
  const [typed, setTyped] = useState<string | null>(null);
  const edited = useRef(false);
  const go = (event: Event): void => {
    const field = event.currentTarget as HTMLInputElement;
    if (!edited.current) return;
    edited.current = false; // leaving the field is a change, too
    const wanted = Number(field.value);
    const sensible = field.value !== "" && Number.isInteger(wanted) && wanted >= 0;
    if (sensible) void studio.ask({ do: "reset", seed: wanted });
    else if (field.value.trim() !== "")
      studio.say({
        text: `The seed ${field.value} is no whole number of 0 or more: 42, for example`,
        tone: "error",
      });
    setTyped(null);
    field.blur();
  };
  return (
    <span class="soft place">
      {studio.status?.places.can_save === true ? (
        <label class="where">
          in{" "}
          <ControlSelect
            value={scenario}
            among={studio.status.places.worlds}
            aria-label="Scenario"
            title="Another scenario; more in the tab Library"
            change={(name) => void studio.ask({ do: "open_world", name, discard: false })}
          />
        </label>
      ) : (
        <span class="cut">in {studio.live.mapped ? plain(scenario) : scenario},</span>
      )}
      <label>
        seed{" "}
        <input
          class="seed"
          inputMode="numeric"
          disabled={!studio.hasControl}
          value={typed ?? (seed === null ? "" : String(seed))}
          onInput={(event) => {
            edited.current = true;
            setTyped(event.currentTarget.value);
          }}
          onChange={go}
          onBlur={() => setTyped(null)}
          onKeyDown={(event) => {
            if (event.key === "Enter") go(event); // the present seed, too, which is no change
          }}
          title="Another number, another world"
        />
      </label>
    </span>
  );
}

function ModeSwitch() {
  const studio = useStudio();
  const mode = studio.session?.mode ?? "live";
  const tries = mode === "testing";
  const teaching = studio.session?.live
    ? "It decides, and learns from every press"
    : "You decide; each press is an example";
  return (
    <div class={className("segments", "modes", mode)} role="group" aria-label="Mode">
      {[false, true].map((each) => (
        <ControlButton
          key={String(each)}
          aria-pressed={tries === each}
          title={each ? "It decides, and learns nothing; a press corrects it, and you teach again" : teaching}
          onClick={() => void (tries !== each && studio.ask({ do: "toggle_mode" }))}
        >
          {each ? "Try" : "Teach"}
          {tries !== each && <KeyName place="KeyT" />}
        </ControlButton>
      ))}
    </div>
  );
}

function SaveControls() {
  const studio = useStudio();
  const { session, status } = studio;
  const saved = status?.library.trained.some(({ name }) => name === session?.name) ?? false;
  return (
    <div class="flex save-controls">
      {session !== null && (
        <span class="soft" title="Every press is written to a journal at once, so nothing is ever lost.">
          <span class={className("dot", (session.unsaved || !saved) && "open")} />
          {session.unsaved ? "not saved yet" : saved ? "in the library" : "nothing yet"}
        </span>
      )}
      {(status?.viewers ?? 1) > 1 && studio.hasControl && (
        <Button title="Hand over control" onClick={() => void studio.ask({ do: "release_control" })}>
          Hand over
        </Button>
      )}
      {session !== null && (
        <ControlButton
          disabled={!session.unsaved || studio.lessonTests.saving}
          onClick={() => void studio.lessonTests.save()}
        >
          Save
        </ControlButton>
      )}
    </div>
  );
}
