/** What to do first, while nothing is trained. */

import { usePanel, useStudio } from "./context";
import { counted } from "./words";

export function Welcome() {
  const studio = useStudio();
  const panel = usePanel();
  if (studio.told === null || studio.desk !== null || panel.form !== null) return null;
  const { trained, cut_off: cutOff } = studio.told.library;
  const [left] = cutOff;
  return (
    <div class="welcome">
      <p class="big">Teach a robot by showing it.</p>
      <p>
        Begin an automaton, then drive the robot by pressing the names of behaviors. It learns when to switch.
      </p>
      {left !== undefined && (
        <button
          type="button"
          class="primary"
          disabled={!studio.directs}
          onClick={() => void studio.ask({ do: "open", name: left.name })}
        >
          Go on with {left.name} ({counted(left.examples, "example")})
        </button>
      )}
      <button
        type="button"
        class={left === undefined ? "primary" : ""}
        disabled={!studio.directs}
        onClick={() => panel.choose("new")}
      >
        New automaton
      </button>
      {trained.length > 0 && (
        <button type="button" onClick={() => panel.open("library")}>
          Open one of the library
        </button>
      )}
    </div>
  );
}
