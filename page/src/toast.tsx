/** The line that says what just happened, with a way back where there is one. */

import { ChangedLine } from "./changed";
import { useStudio } from "./context";
import { className, plain } from "./words";

export function Toast() {
  const studio = useStudio();
  const { notice } = studio;
  const { undo } = notice;
  const asked = studio.desk?.asking.question?.sentence;
  const undone = undo?.do === "undo" && studio.desk?.changed != null; // the line above has the button
  const shown = notice.text !== "" && (asked === undefined || !notice.text.startsWith(asked)); // it has its card
  return (
    <div class="toasts" role="status" aria-live="polite">
      <ChangedLine />
      {shown && (
        <div class={className("toast", notice.tone)} key={studio.notices}>
          <span>{plain(notice.text)}</span>
          {undo !== undefined && studio.directs && !undone && (
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
