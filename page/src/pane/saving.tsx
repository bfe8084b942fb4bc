/** What saving would break, before it does: save anyway, or not now. */

import { useStudio } from "../context";
import { plain } from "../words";

export function SavingCard() {
  const { trial, desk, directs } = useStudio();
  const { worse } = trial;
  if (worse === null || desk === null) return null;
  return (
    <section class="doubt" role="alert" aria-label="Before it is saved">
      <p>
        <b>{plain(desk.name)} is not saved yet.</b> Something that worked no longer does:
      </p>
      <ul>
        {worse.map((each) => (
          <li key={each}>{plain(each)}</li>
        ))}
      </ul>
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
