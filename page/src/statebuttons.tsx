/** The row of buttons that direct the robot: one for each state, and "Confirm". */

import { useStudio } from "./context";
import type { Session, State } from "./protocol";
import type { Studio } from "./studio";
import { className, keyName, plain } from "./words";

export function StateButtons() {
  const studio = useStudio();
  const { desk } = studio;
  if (desk === null) return null;
  const corrected = studio.notice.tone === "correction";
  return (
    <div
      class={className("state-buttons", desk.mode, corrected && "corrected")}
      role="toolbar"
      aria-label="Direct the robot"
    >
      <div class="states">
        {desk.states.map((state) => (
          <StateButton key={state.name} state={state} studio={studio} desk={desk} />
        ))}
      </div>
      <div class="confirm-buttons">
        {desk.watched && (
          <button
            type="button"
            class="keep"
            role="switch"
            aria-checked={!desk.watching}
            disabled={!studio.directs}
            title={desk.watching ? "Learning from silence: on" : "Learning from silence: off"}
            onClick={() => void studio.ask({ do: "watch" })}
          >
            {desk.watching ? "" : "✓ "}Stop learning from silence
          </button>
        )}
        <button
          type="button"
          class="keep"
          disabled={!studio.directs}
          aria-keyshortcuts="Enter"
          onClick={(event) => void studio.confirm(event.timeStamp)}
        >
          Confirm <kbd aria-hidden="true">↵</kbd>
        </button>
      </div>
    </div>
  );
}

function StateButton({ state, studio, desk }: { state: State; studio: Studio; desk: Session }) {
  const active = desk.state === state.name;
  const waiting = desk.waiting === state.name || studio.asking === state.name;
  const key = keyName(state);
  return (
    <button
      type="button"
      class={className("state", active && "on", waiting && "waiting", state.flag && "flag")}
      aria-pressed={active}
      data-state={state.name}
      aria-keyshortcuts={key}
      disabled={!studio.directs}
      title={title(state, desk)}
      onClick={(event) => void studio.press(state.name, event.timeStamp)}
    >
      {key !== "" && <kbd aria-hidden="true">{key}</kbd>}
      {state === desk.states[0] ? "stand still" : plain(state.name)}
      {state.flag && <span aria-hidden="true">⚑</span>}
    </button>
  );
}

function title(state: State, desk: Session): string {
  if (state === desk.states[0])
    return `Direct it back to ${state.name}, its first state, where it stands still. An example, as every press.`;
  const name = plain(state.name);
  const runs = state.runs === null || state.runs === state.name ? "" : ` It runs ${plain(state.runs)}.`;
  const what = desk.mode === "testing" ? `Correct it: go to ${name}.` : `Direct it to ${name}.`;
  return what + (state.flag ? " It stops there and raises this flag." : runs);
}
