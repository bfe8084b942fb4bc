/**
 * The properties of a lesson: from here, done within so many seconds; whether all lessons still hold; and in how many
 * unseen worlds what is trained succeeds.
 */

import { useState } from "preact/hooks";
import type { Evaluation, EvaluationResult, Session, Tested } from "../protocol";
import type { Studio } from "../studio";
import { className, counted, plain } from "../words";

/** In so many worlds what is trained is tried at a click. */
const WORLDS = 100;
/** So many worlds in which it failed are listed at first. */
const FIRST = 6;

export function Outcomes({ desk, studio }: { desk: Session; studio: Studio }) {
  return (
    <>
      <Promised desk={desk} studio={studio} />
      <UnseenWorlds desk={desk} studio={studio} />
    </>
  );
}

function Promised({ desk, studio }: { desk: Session; studio: Studio }) {
  const [adding, add] = useState(false);
  const { trial, directs } = studio;
  const tested = trial.fresh ? trial.found?.find(({ name }) => name === desk.name) : undefined;
  return (
    <section class="outcomes" aria-label="Properties">
      <div class="outcomes-head">
        <h3>Properties</h3>
        {desk.flags.length > 0 && (
          <button
            type="button"
            class="link"
            aria-expanded={adding}
            disabled={!directs}
            title="What must happen from this moment on (tested by Test lessons)"
            onClick={() => add(!adding)}
          >
            + property
          </button>
        )}
        <button
          type="button"
          class="small"
          disabled={trial.testing !== null}
          title="All recorded moments and properties of the library, as everything is now"
          onClick={() => void trial.test()}
        >
          {trial.testing === null ? "Test lessons" : `Testing ${plain(trial.testing)} …`}
        </button>
      </div>
      {adding && <Promising desk={desk} studio={studio} close={() => add(false)} />}
      <ul>
        {desk.outcomes.map((said, index) => (
          <li key={index}>
            <Came outcome={tested?.outcomes[index]} />
            <span class="promised">{plain(said)}</span>
            <button
              type="button"
              class="link"
              disabled={!directs}
              title="Go to the moment it starts from"
              onClick={() => void studio.ask({ do: "visit", outcome: index })}
            >
              go there
            </button>
            <button
              type="button"
              class="link"
              disabled={!directs}
              aria-label={`Remove property: ${said}`}
              title="Remove property"
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

/** What is trained, tried in worlds that it was not taught in. */
function UnseenWorlds({ desk, studio }: { desk: Session; studio: Studio }) {
  const { evaluation } = desk;
  if (!studio.live.mapped) return null; // what success is in a body of one's own only the command line is told
  const running = evaluation !== undefined && evaluation.result === null && evaluation.problem === "";
  return (
    <section class="outcomes" aria-label="Unseen worlds">
      <div class="outcomes-head">
        <h3>Unseen worlds</h3>
        {running ? (
          <button
            type="button"
            class="small"
            disabled={!studio.directs}
            onClick={() => void studio.ask({ do: "cancel_evaluation" })}
          >
            Cancel
          </button>
        ) : (
          <button
            type="button"
            class="small"
            disabled={!studio.directs || studio.live.real}
            title="It decides by itself in worlds that it was not taught in, while the one here goes on"
            onClick={() => void studio.ask({ do: "evaluate", count: WORLDS })}
          >
            Try in {WORLDS} worlds
          </button>
        )}
      </div>
      {studio.live.real && <p class="tiny">Not with real robots: there is only the world they are in.</p>}
      {running && <Progress evaluation={evaluation} />}
      {evaluation !== undefined && !running && (
        <Evaluated evaluation={evaluation} desk={desk} studio={studio} />
      )}
    </section>
  );
}

function Progress({ evaluation }: { evaluation: Evaluation }) {
  const { called, worlds, through } = evaluation;
  return (
    <p class="trying">
      <progress aria-label="Worlds tried" value={through} max={worlds} />
      <span class="tiny">
        {plain(called)}: {through} of {counted(worlds, "world")}
      </span>
    </p>
  );
}

/** What came of it: the rate, and the worlds in which it failed. */
function Evaluated({ evaluation, desk, studio }: { evaluation: Evaluation; desk: Session; studio: Studio }) {
  const { called, worlds, result, problem, edition } = evaluation;
  return (
    <section class="tested" aria-label="How often it succeeded" aria-live="polite">
      <div class="outcomes-head">
        <b class={className(result === null && "warn")}>
          {result === null
            ? "It could not be tried"
            : `Succeeded in ${result.succeeded} of ${counted(worlds, "world")}`}
        </b>
        <span class="space" />
        <button
          type="button"
          class="link"
          aria-label="Close what was tried"
          disabled={!studio.directs}
          onClick={() => void studio.ask({ do: "cancel_evaluation" })}
        >
          ×
        </button>
      </div>
      {edition !== desk.edition && <p class="tiny">before the lesson changed; try it again</p>}
      {result === null ? (
        <p class="warn">{plain(problem)}</p>
      ) : (
        <>
          <p>95% interval {percent(result.interval)} %</p>
          {result.raised !== "" && (
            <p class={className(result.leaves_shown && "warn")}>{plain(result.raised)}</p>
          )}
          <p class="tiny">
            {plain(called)} in worlds {result.first} to {result.last}. Success: {plain(result.success)}
            {(studio.scene?.robots ?? 1) > 1 && "; all robots run it"}.
          </p>
          <Failed result={result} failed={worlds - result.succeeded} desk={desk} studio={studio} />
        </>
      )}
    </section>
  );
}

/** 79 to 92. */
function percent([low, high]: readonly [number, number]): string {
  return `${Math.round(100 * low)} to ${Math.round(100 * high)}`;
}

function Failed({
  result,
  failed,
  desk,
  studio,
}: {
  result: EvaluationResult;
  failed: number;
  desk: Session;
  studio: Studio;
}) {
  const [all, setAll] = useState(false);
  const listed = all ? result.failed : result.failed.slice(0, FIRST);
  /** The world from its beginning, and what is trained decides in it. */
  const open = async (seed: number): Promise<void> => {
    if (desk.mode === "training") {
      const { error } = await studio.ask({ do: "turn" });
      if (error !== undefined) return;
    }
    await studio.ask({ do: "reset", seed });
  };
  return (
    <>
      {failed > 0 && <p class="failed-in">Failed in {counted(failed, "world")}:</p>}
      <ul class="failed" aria-label="Worlds in which it failed">
        {listed.map(({ seed, problem }) => (
          <li key={seed} class={className(studio.told?.seed === seed && "on")}>
            <span class="promised">
              World {seed} <span class="soft">{plain(problem)}</span>
            </span>
            <button
              type="button"
              class="small"
              disabled={!studio.directs}
              aria-label={`Open world ${seed}`}
              title="Go to this world and let it try; press what is right where it does wrong"
              onClick={() => void open(seed)}
            >
              Open
            </button>
          </li>
        ))}
      </ul>
      {listed.length < result.failed.length && (
        <p class="earlier">
          <button type="button" class="link" onClick={() => setAll(true)}>
            {result.failed.length - listed.length} more
          </button>
        </p>
      )}
      {all && result.failed.length < failed && (
        <p class="tiny">and {failed - result.failed.length} more that are not listed</p>
      )}
    </>
  );
}

/** The result of a property in the last test. */
function Came({ outcome }: { outcome: Tested["outcomes"][number] | undefined }) {
  if (outcome === undefined) return null;
  if (!outcome.held) {
    return (
      <span class="warn" title={outcome.problem === "" ? "It failed" : outcome.problem}>
        ✗
      </span>
    );
  }
  return outcome.took_s === null ? (
    <span class="came" title="It held">
      ✓
    </span>
  ) : (
    <span class="came" title="Time until it was reached">
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
          <option key={each} value={each}>
            {plain(each)}
          </option>
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
        Add property
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
  const otherwise = found.reduce((sum, each) => sum + each.otherwise, 0);
  const held =
    otherwise === 0 ? "All as shown" : `${counted(otherwise, "moment")} decided otherwise than shown`;
  return (
    <section class="tested" aria-label="Tested" aria-live="polite">
      <div class="outcomes-head">
        <b>
          {trial.testing !== null
            ? "Testing"
            : bad === 0
              ? `${held}, all properties hold`
              : `Failed: ${bad} of ${found.length}`}
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
        <b>{plain(name)}</b>{" "}
        <span class="tiny">
          {examples === 0 ? "nothing recorded" : counted(examples, "moment")}
          {outcomes.length > 0 && `, ${outcomes.length} ${outcomes.length === 1 ? "property" : "properties"}`}
        </span>
      </p>
      {worse.map((line) => (
        <p key={line} class="line">
          {plain(line)}
        </p>
      ))}
      {rest.map((line) => (
        <p key={line} class="line tiny">
          {plain(line)}
        </p>
      ))}
    </li>
  );
}
