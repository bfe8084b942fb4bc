/** The tab Lesson: all examples, undo and redo. */

import { usePanel, useStudio } from "../context";
import type { Session } from "../protocol";
import { formatCount } from "../words";
import { Examples, KINDS, kindOf } from "./examples";
import { Outcomes } from "./outcomes";

export function LessonTab() {
  const studio = useStudio();
  const panel = usePanel();
  const { desk } = studio;
  if (desk === null) return <p class="empty">Here every example of the lesson will be listed.</p>;
  const contradictions = desk.examples.filter((example) => example.contradicts).length;
  return (
    <>
      <div class="lesson-head">
        <span>{formatCount(desk.examples.length, "example")}</span>
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
      <Kinds desk={desk} />
      {contradictions > 0 && <p class="tiny kinds warn">≠ {contradictions} contradict each other</p>}
      {(desk.examples.length > 0 || desk.outcomes.length > 0) && <Outcomes desk={desk} studio={studio} />}
      {panel.highlighted.size > 0 && (
        <p class="tiny shown">
          {formatCount(panel.highlighted.size, "example")} marked.{" "}
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

/** How many examples of each kind: what the signs in the table mean. */
function Kinds({ desk }: { desk: Session }) {
  const kinds = desk.examples.map(kindOf);
  const counts = Object.entries(KINDS).map(([kind, [sign, word]]) => ({
    sign,
    word,
    count: kinds.filter((each) => each === kind).length,
  }));
  return (
    <p class="tiny kinds">
      {counts
        .filter(({ count }) => count > 0)
        .map(({ sign, word, count }) => (
          <span key={word} class={word}>
            <span aria-hidden="true">{sign}</span> {word} {count}
          </span>
        ))}
    </p>
  );
}
