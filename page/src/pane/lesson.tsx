/** The tab Lesson: all examples, undo and redo. */

import { Button, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import type { Session } from "../protocol";
import { formatCount } from "../words";
import { Examples, KINDS, kindOf } from "./examples";
import { Outcomes } from "./outcomes";

export function LessonTab() {
  const studio = useStudio();
  const panel = usePanel();
  const { session } = studio;
  if (session === null) return <p class="empty">Here every example of the lesson will be listed.</p>;
  const contradictions = session.examples.filter((example) => example.contradicts).length;
  return (
    <>
      <div class="flex lesson-head">
        <span>{formatCount(session.examples.length, "example")}</span>
        <span class="space" />
        <ControlButton
          class="small"
          disabled={session.undoable === null}
          title={session.undoable ?? "Nothing to undo"}
          request={{ do: "undo" }}
        >
          Undo
        </ControlButton>
        <ControlButton
          class="small"
          disabled={session.redoable === null}
          title={session.redoable ?? "Nothing to redo"}
          request={{ do: "redo" }}
        >
          Redo
        </ControlButton>
      </div>
      <Kinds session={session} />
      {contradictions > 0 && <p class="tiny kinds warn">≠ {contradictions} contradict each other</p>}
      {(session.examples.length > 0 || session.properties.length > 0) && <Outcomes session={session} />}
      {panel.highlighted.size > 0 && (
        <p class="tiny shown">
          {formatCount(panel.highlighted.size, "example")} marked.{" "}
          <Button class="link" onClick={() => panel.showExamples([])}>
            unmark
          </Button>
        </p>
      )}
      {session.examples.length === 0 ? (
        <p class="empty">
          No examples yet. Press a state below the world: what the robot senses at that moment becomes an
          example of when to switch.
        </p>
      ) : (
        <div class="table-place">
          <Examples session={session} panel={panel} />
        </div>
      )}
    </>
  );
}

/** How many examples of each kind: what the signs in the table mean. */
function Kinds({ session }: { session: Session }) {
  const kinds = session.examples.map(kindOf);
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
