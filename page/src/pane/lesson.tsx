/** The tab Lesson: all examples, undo and redo. */

import { usePanel, useStudio } from "../context";
import { counted } from "../words";
import { Examples } from "./examples";

export function LessonTab() {
  const studio = useStudio();
  const panel = usePanel();
  const { desk } = studio;
  if (desk === null) return <p class="empty">Here every example of the lesson will be listed.</p>;
  const pressed = desk.examples.filter(({ kind }) => kind === "directive" || kind === "confirmation").length;
  const contradictions = desk.examples.filter((example) => example.contradicts).length;
  return (
    <>
      <div class="lesson-head">
        <span>
          {counted(desk.examples.length, "example")}
          <span class="soft">, {pressed} by a press</span>
        </span>
        {contradictions > 0 && <span class="warn">{contradictions} contradict each other</span>}
        <span class="space" />
        <button
          type="button"
          class="small"
          disabled={desk.undoable === null || !studio.directs}
          title={desk.undoable ?? "Nothing to undo"}
          onClick={() => void studio.ask({ do: "undo" })}
        >
          Undo
        </button>
        <button
          type="button"
          class="small"
          disabled={desk.redoable === null || !studio.directs}
          title={desk.redoable ?? "Nothing to redo"}
          onClick={() => void studio.ask({ do: "redo" })}
        >
          Redo
        </button>
      </div>
      {panel.shown.size > 0 && (
        <p class="tiny shown">
          {counted(panel.shown.size, "example")} marked, behind one transition.{" "}
          <button type="button" class="link" onClick={() => panel.showExamples([])}>
            unmark
          </button>
        </p>
      )}
      {desk.examples.length === 0 ? (
        <p class="empty">
          No examples yet. Press a state below the world: what the robot senses at that moment becomes an
          example of when to switch.
        </p>
      ) : (
        <div class="table-place">
          <Examples desk={desk} panel={panel} studio={studio} />
        </div>
      )}
    </>
  );
}
