/** The row of buttons that direct the robot: one for each state, and "Confirm". */

import { ControlButton } from "./button";
import { useStudio } from "./context";
import { keyboard } from "./keyboard";
import { nameStateKey } from "./keyname";
import { useNews } from "./news";
import type { Session, State } from "./protocol";
import { className, plain } from "./words";

export function StateButtons() {
  const studio = useStudio();
  const { session } = studio;
  if (session === null) return null;
  const corrected = studio.notice.tone === "correction";
  return (
    <div
      class={className("state-buttons", session.mode, corrected && "corrected")}
      role="toolbar"
      aria-label="Direct the robot"
    >
      <div class="states">
        {session.states.map((state) => (
          <StateButton key={state.name} state={state} session={session} />
        ))}
      </div>
      <div class="confirm-buttons">
        {session.watched && (
          <ControlButton
            class="keep"
            role="switch"
            aria-checked={!session.watching}
            title={session.watching ? "Learning from silence: on" : "Learning from silence: off"}
            request={{ do: "toggle_watching" }}
          >
            {session.watching ? "" : "✓ "}Stop learning from silence
          </ControlButton>
        )}
        <ControlButton
          class="keep"
          aria-keyshortcuts="Enter"
          onClick={(event) => void studio.confirm(event.timeStamp)}
        >
          Confirm <kbd aria-hidden="true">↵</kbd>
        </ControlButton>
      </div>
    </div>
  );
}

function StateButton({ state, session }: { state: State; session: Session }) {
  const studio = useStudio();
  const active = session.state === state.name;
  const waiting = session.pending === state.name || studio.asking === state.name;
  useNews(keyboard.news);
  const key = nameStateKey(state);
  return (
    <ControlButton
      class={className("flex", "state", active && "on", waiting && "waiting", state.flag && "flag")}
      aria-pressed={active}
      data-state={state.name}
      aria-keyshortcuts={key}
      title={title(state, session)}
      onClick={(event) => void studio.press(state.name, event.timeStamp)}
    >
      {key !== "" && <kbd aria-hidden="true">{key}</kbd>}
      {state === session.states[0] ? "stand still" : plain(state.name)}
      {state.flag && <span aria-hidden="true">⚑</span>}
    </ControlButton>
  );
}

function title(state: State, session: Session): string {
  if (state === session.states[0])
    return `Direct it back to ${state.name}, its first state, where it stands still. An example, as every press.`;
  const name = plain(state.name);
  const runs = state.runs === null || state.runs === state.name ? "" : ` It runs ${plain(state.runs)}.`;
  const what = session.mode === "testing" ? `Correct it: go to ${name}.` : `Direct it to ${name}.`;
  return what + (state.flag ? " It stops there and raises this flag." : runs);
}
