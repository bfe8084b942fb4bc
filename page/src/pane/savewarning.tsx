/** What saving would break, and what changed unasked, before it is saved: save anyway, or not now. */

import { Button, ControlButton } from "../button";
import { DecisionChanges } from "../changes";
import { useStudio } from "../context";
import { plain } from "../words";

export function SaveWarning() {
  const { lessonTests, session } = useStudio();
  const { regressions, changed } = lessonTests;
  if (regressions === null || session === null) return null;
  return (
    <section class="doubt" role="alert" aria-label="Before it is saved">
      <p>
        <b>{plain(session.name)} is not saved yet.</b>
        {regressions.length > 0 && " Something that worked no longer does:"}
      </p>
      {regressions.length > 0 && (
        <ul>
          {regressions.map((each) => (
            <li key={each}>{plain(each)}</li>
          ))}
        </ul>
      )}
      {changed !== null && (
        <>
          <p>Since it was last saved, beyond what you pressed:</p>
          <DecisionChanges summary={changed} />
        </>
      )}
      <p class="choices">
        <ControlButton
          class="small primary"
          disabled={lessonTests.saving}
          onClick={() => void lessonTests.save(true)}
        >
          Save anyway
        </ControlButton>
        <Button class="small" onClick={() => lessonTests.dismissWarning()}>
          Not now
        </Button>
      </p>
    </section>
  );
}
