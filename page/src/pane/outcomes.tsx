/** What a lesson promises: from here, done within so many seconds; and whether all lessons still hold. */

import { useState } from "preact/hooks";
import type { Session, Tested } from "../protocol";
import type { Studio } from "../studio";
import { className, counted } from "../words";

export function Outcomes({ desk, studio }: { desk: Session; studio: Studio }) {
  const [adding, add] = useState(false);
  const { trial, directs } = studio;
  const tested = trial.fresh ? trial.found?.find(({ name }) => name === desk.name) : undefined;
  return (
    <section class="outcomes" aria-label="Outcomes">
      <div class="outcomes-head">
        <h3>Outcomes</h3>
        {desk.flags.length > 0 && (
          <button
            type="button"
            class="link"
            aria-expanded={adding}
            disabled={!directs}
            title="What shall come of it from here on: it is tried whenever the lesson is tested"
            onClick={() => add(!adding)}
          >
            + promise
          </button>
        )}
        <button
          type="button"
          class="small"
          disabled={trial.testing !== null}
          title="All recorded moments and outcomes of the library, as everything is now"
          onClick={() => void trial.test()}
        >
          {trial.testing === null ? "Test lessons" : `Testing ${trial.testing} …`}
        </button>
      </div>
      {adding && <Promising desk={desk} studio={studio} close={() => add(false)} />}
      <ul>
        {desk.outcomes.map((said, index) => (
          <li key={index}>
            <Came outcome={tested?.outcomes[index]} />
            <span class="promised">{said}</span>
            <button
              type="button"
              class="link"
              disabled={!directs}
              title="Go to where it was promised"
              onClick={() => void studio.ask({ do: "visit", outcome: index })}
            >
              go there
            </button>
            <button
              type="button"
              class="link"
              disabled={!directs}
              aria-label={`Promise no longer: ${said}`}
              title="Promise it no longer"
              onClick={() => void studio.change({ do: "withdraw", outcome: index }, { do: "undo" })}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
      <Results studio={studio} />
    </section>
  );
}

/** How an outcome came out in the last test. */
function Came({ outcome }: { outcome: Tested["outcomes"][number] | undefined }) {
  if (outcome === undefined) return null;
  if (outcome.took_s === null) {
    return (
      <span class="warn" title={outcome.problem === "" ? "It did not come" : outcome.problem}>
        ✗
      </span>
    );
  }
  return (
    <span class="came" title="It came, after so long">
      ✓ {outcome.took_s.toFixed(1)} s
    </span>
  );
}

function Promising({ desk, studio, close }: { desk: Session; studio: Studio; close: () => void }) {
  const [flag, setFlag] = useState(desk.flags[0] ?? "");
  const [seconds, setSeconds] = useState("20");
  const within = Number(seconds);
  const sensible = seconds.trim() !== "" && within > 0;
  const promise = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (!sensible) return;
    const answer = await studio.change({ do: "promise", flag, within_s: within }, { do: "undo" });
    if (answer.error === undefined) close();
  };
  return (
    <form class="promising" onSubmit={(event) => void promise(event)}>
      <span>From here,</span>
      <select aria-label="flag" value={flag} onChange={(event) => setFlag(event.currentTarget.value)}>
        {desk.flags.map((each) => (
          <option key={each}>{each}</option>
        ))}
      </select>
      <label>
        within{" "}
        <input
          value={seconds}
          inputMode="decimal"
          aria-label="seconds"
          onInput={(event) => setSeconds(event.currentTarget.value)}
        />{" "}
        s
      </label>
      <button type="submit" class="small primary" disabled={!studio.directs || !sensible}>
        Promise
      </button>
      <p class="tiny">
        Where everything stands now is kept with the lesson; the automaton starts afresh there.
      </p>
    </form>
  );
}

/** What was found, an automaton each, the one in training first. */
function Results({ studio }: { studio: Studio }) {
  const { trial } = studio;
  const { found } = trial;
  if (found === null || (found.length === 0 && trial.testing === null)) return null;
  const bad = found.filter(({ works }) => !works).length;
  return (
    <section class="tested" aria-label="Tested" aria-live="polite">
      <div class="outcomes-head">
        <b>
          {trial.testing !== null
            ? "Testing"
            : bad === 0
              ? "All as shown and promised"
              : `Not as shown or promised: ${bad} of ${found.length}`}
        </b>
        {trial.testing === null && !trial.fresh && (
          <span class="tiny">before the lesson changed; test it again</span>
        )}
        <span class="space" />
        <button type="button" class="link" aria-label="Close what was tested" onClick={() => trial.forget()}>
          ×
        </button>
      </div>
      <ul>
        {found.map((each) => (
          <Result key={each.name} tested={each} />
        ))}
      </ul>
    </section>
  );
}

function Result({ tested }: { tested: Tested }) {
  const { name, works, examples, outcomes, worse, else: rest } = tested;
  const [sign, word] = !works ? ["✗", "worse"] : rest.length > 0 ? ["•", "otherwise"] : ["✓", "as it was"];
  return (
    <li class={className("result", !works && "bad")}>
      <p>
        <span role="img" aria-label={word} class={works ? "came" : "warn"}>
          {sign}
        </span>{" "}
        <b>{name}</b>{" "}
        <span class="tiny">
          {examples === 0 ? "nothing recorded" : counted(examples, "moment")}
          {outcomes.length > 0 && `, ${counted(outcomes.length, "outcome")}`}
        </span>
      </p>
      {worse.map((line) => (
        <p key={line} class="line">
          {line}
        </p>
      ))}
      {rest.map((line) => (
        <p key={line} class="line tiny">
          {line}
        </p>
      ))}
    </li>
  );
}
