/** The line that says what just happened, with a way back where there is one. */

import { Button, CloseButton } from "./button";
import { ChangeLine } from "./changes";
import { useStudio } from "./context";
import { className, plain } from "./words";

export function Toast() {
  const studio = useStudio();
  const { notice } = studio;
  const { undo } = notice;
  const question = studio.session?.queries.question?.sentence;
  const undone = undo?.do === "undo" && studio.session?.changed != null; // the line above has the button
  const isVisible = notice.text !== "" && (question === undefined || !notice.text.startsWith(question)); // it has its card
  return (
    <div class="toasts" role="status" aria-live="polite">
      <ChangeLine />
      {isVisible && (
        <div class={className("toast", notice.tone)} key={studio.notices}>
          <span>{plain(notice.text)}</span>
          {undo !== undefined && studio.hasControl && !undone && (
            <Button onClick={() => void studio.ask(undo)}>undo</Button>
          )}
          {notice.tone === "error" && (
            <CloseButton label="Close" onClick={() => studio.say({ text: "", tone: "" })} />
          )}
        </div>
      )}
    </div>
  );
}
