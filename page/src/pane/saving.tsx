/** What saving would break, and what changed unasked, before it is saved: save anyway, or not now. */

import { ChangedDecisions } from "../changed";
import { useStudio } from "../context";
import { plain } from "../words";

export function SavingCard() {
  const { trial, desk, directs } = useStudio();
  const { worse, changed } = trial;
  if (worse === null || desk === null) return null;
  return (
    <section class="doubt" role="alert" aria-label="Before it is saved">
      <p>
        <b>{plain(desk.name)} is not saved yet.</b>
        {worse.length > 0 && " Something that worked no longer does:"}
      </p>
      {worse.length > 0 && (
        <ul>
          {worse.map((each) => (
            <li key={each}>{plain(each)}</li>
          ))}
        </ul>
      )}
      {changed !== null && (
        <>
          <p>Since it was last saved, beyond what you pressed:</p>
          <ChangedDecisions summary={changed} />
        </>
      )}
      <p class="choices">
        <button
          type="button"
          class="small primary"
          disabled={!directs || trial.saving}
          onClick={() => void trial.save(true)}
        >
          Save anyway
        </button>
        <button type="button" class="small" onClick={() => trial.leave()}>
          Not now
        </button>
      </p>
    </section>
  );
}
