/** Bars under the header: the connection is lost; another person directs. */

import { Button } from "./button";
import { useStudio } from "./context";

export function Bars() {
  const studio = useStudio();
  if (studio.refusal !== null) {
    return (
      <div class="flex bar lost" role="alert">
        {studio.refusal}
      </div>
    );
  }
  if (studio.linked === false) {
    return (
      <div class="flex bar lost" role="alert">
        The connection to the studio is lost. The robot is paused, and every press is in the journal. Trying
        again…
      </div>
    );
  }
  if (studio.stage !== "") {
    return (
      <div class="flex bar" role="status">
        {studio.stage} …
      </div>
    );
  }
  if (studio.status === null || studio.hasControl) return null;
  if (studio.closed !== "") {
    return (
      <div class="flex bar lost" role="alert">
        You can only look: {studio.closed}.
      </div>
    );
  }
  return (
    <div class="flex bar" role="status">
      <span>
        {studio.status.is_controlled
          ? studio.status.can_take_control
            ? "Someone else is in control, and has done nothing for a while."
            : "Someone else is in control. You can watch, and take control when nobody is."
          : "No one is in control. Take control to teach the robot."}
      </span>
      {studio.status.can_take_control && (
        <Button class="small" onClick={() => void studio.ask({ do: "take_control" })}>
          Take control
        </Button>
      )}
    </div>
  );
}
