/** The line that says what just happened, with a way back where there is one. */

import { useStudio } from "./context";
import { className } from "./words";

export function Toast() {
  const studio = useStudio();
  const { notice } = studio;
  const { undo } = notice;
  return (
    <div class="toasts" role="status" aria-live="polite">
      {notice.text !== "" && (
        <div class={className("toast", notice.tone)} key={studio.notices}>
          <span>{notice.text}</span>
          {undo !== undefined && studio.directs && (
            <button type="button" onClick={() => void studio.ask(undo)}>
              undo
            </button>
          )}
          {notice.tone === "error" && (
            <button type="button" aria-label="Close" onClick={() => studio.say({ text: "", tone: "" })}>
              ×
            </button>
          )}
        </div>
      )}
    </div>
  );
}
