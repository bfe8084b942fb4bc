/** What to do first, while nothing is trained. */

import { Button, ControlButton } from "./button";
import { usePanel, useStudio, useTour } from "./context";
import { makeDraft } from "./draft";
import { Discard } from "./pane/interrupted";
import { formatCount, plain } from "./words";

export function Welcome() {
  const studio = useStudio();
  const panel = usePanel();
  const tour = useTour();
  if (studio.status === null || studio.session !== null || panel.form !== null) return null;
  const { trained, interrupted: cutOff } = studio.status.library;
  const [left] = cutOff;
  const empty = trained.length === 0 && left === undefined;
  const shows = empty && studio.scene !== null && makeDraft("new", studio, studio.scene).name !== "";
  return (
    <div class="welcome">
      <p class="big">Teach a robot by showing it.</p>
      <p>
        Begin an automaton, then drive the robot by pressing the names of behaviors. It learns when to switch.
      </p>
      {left !== undefined && (
        <span class="resume">
          <ControlButton class="primary" request={{ do: "open", name: left.name }}>
            Resume {plain(left.name)} ({formatCount(left.examples, "example")})
          </ControlButton>
          <Discard name={left.name} />
        </span>
      )}
      <ControlButton class={left === undefined ? "primary" : ""} onClick={() => panel.choose("new")}>
        Teach something new
      </ControlButton>
      {shows && (
        <ControlButton
          title="A tour of six steps: a robot that goes to a place by itself"
          onClick={() => {
            tour.begin(true);
            panel.choose("new");
          }}
        >
          Show me how
        </ControlButton>
      )}
      {trained.length > 0 && <Button onClick={() => panel.open("library")}>Open one of the library</Button>}
    </div>
  );
}
