/**
 * The properties of a lesson: from here, done within some seconds; whether all lessons still hold; and in how many
 * unseen worlds what is trained succeeds.
 */

import { useState } from "preact/hooks";
import { Button, CloseButton, ControlButton } from "../button";
import { useStudio } from "../context";
import { Form, Input, Select } from "../fields";
import { Progress, Sign, useFirst } from "../lists";
import type { Evaluation, EvaluationResult, Session, LessonTest } from "../protocol";
import { className, formatCount, plain } from "../words";

/** The number of worlds in which the trained automaton is tried at a click. */
const WORLDS = 100;
/** The number of worlds in which it failed that are listed at first. */
const FIRST = 6;

export function Outcomes({ session }: { session: Session }) {
  const studio = useStudio();
  return (
    <>
      <PropertyList session={session} />
      {studio.offers.includes("runs") && <UnseenWorlds session={session} />}
    </>
  );
}

function PropertyList({ session }: { session: Session }) {
  const studio = useStudio();
  const [adding, add] = useState(false);
  const { lessonTests } = studio;
  const tested = lessonTests.fresh
    ? lessonTests.results?.find(({ name }) => name === session.name)
    : undefined;
  return (
    <section class="card outcomes" aria-label="Properties">
      <div class="flex wrap outcomes-head">
        <h3>Properties</h3>
        {session.flags.length > 0 && (
          <ControlButton
            class="link"
            aria-expanded={adding}
            title="What must happen from this moment on (tested by Test lessons)"
            onClick={() => add(!adding)}
          >
            + property
          </ControlButton>
        )}
        <Button
          class="small"
          disabled={lessonTests.testing !== null}
          title="All recorded moments and properties of the library, as everything is now"
          onClick={() => void lessonTests.test()}
        >
          {lessonTests.testing === null ? "Test lessons" : `Testing ${plain(lessonTests.testing)} …`}
        </Button>
      </div>
      {adding && <PropertyAdder session={session} close={() => add(false)} />}
      <ul>
        {session.properties.map((property, index) => (
          <li key={index}>
            <PropertyMark outcome={tested?.properties[index]} />
            <span class="claim">{plain(property)}</span>
            <ControlButton
              class="link"
              title="Go to the moment it starts from"
              request={{ do: "go_to_property", property: index }}
            >
              go there
            </ControlButton>
            <ControlButton
              class="link"
              aria-label={`Remove property: ${property}`}
              title="Remove property"
              request={{ do: "remove_property", property: index }}
              back={{ do: "undo" }}
            >
              ×
            </ControlButton>
          </li>
        ))}
      </ul>
      <Results />
    </section>
  );
}

/** What is trained, tried in worlds that it was not taught in. */
function UnseenWorlds({ session }: { session: Session }) {
  const studio = useStudio();
  const { evaluation } = session;
  if (!studio.live.mapped) return null; // what success is in a body of one's own only the command line is told
  const running = evaluation !== undefined && evaluation.result === null && evaluation.problem === "";
  return (
    <section class="card outcomes" aria-label="Unseen worlds">
      <div class="flex wrap outcomes-head">
        <h3>Unseen worlds</h3>
        {running ? (
          <ControlButton class="small" request={{ do: "cancel_evaluation" }}>
            Cancel
          </ControlButton>
        ) : (
          <ControlButton
            class="small"
            disabled={studio.live.real}
            title="It decides by itself in worlds that it was not taught in, while the one here goes on"
            request={{ do: "evaluate", count: WORLDS }}
          >
            Try in {WORLDS} worlds
          </ControlButton>
        )}
      </div>
      {studio.live.real && <p class="tiny">Not with real robots: there is only the world they are in.</p>}
      {running && (
        <Progress label="Worlds tried" finished={evaluation.finished} total={evaluation.worlds}>
          {plain(evaluation.behavior)}: {evaluation.finished} of {formatCount(evaluation.worlds, "world")}
        </Progress>
      )}
      {evaluation !== undefined && !running && <EvaluationView evaluation={evaluation} session={session} />}
    </section>
  );
}

/** What came of it: the rate, and the worlds in which it failed. */
function EvaluationView({ evaluation, session }: { evaluation: Evaluation; session: Session }) {
  const studio = useStudio();
  const { behavior, worlds, result, problem, edition } = evaluation;
  return (
    <section class="tested" aria-label="How often it succeeded" aria-live="polite">
      <div class="flex wrap outcomes-head">
        <b class={className(result === null && "warn")}>
          {result === null
            ? "It could not be tried"
            : `Succeeded in ${result.succeeded} of ${formatCount(worlds, "world")}`}
        </b>
        <span class="space" />
        <ControlButton class="link" aria-label="Close what was tried" request={{ do: "cancel_evaluation" }}>
          ×
        </ControlButton>
      </div>
      {edition !== session.edition && <p class="tiny">before the lesson changed; try it again</p>}
      {result === null ? (
        <p class="warn">{plain(problem)}</p>
      ) : (
        <>
          <p>95% interval {percent(result.interval)} %</p>
          {result.raised !== "" && (
            <p class={className(result.leaves_shown && "warn")}>{plain(result.raised)}</p>
          )}
          <p class="tiny">
            {plain(behavior)} in worlds {result.first} to {result.last}. Success: {plain(result.success)}
            {(studio.scene?.robots ?? 1) > 1 && "; all robots run it"}.
          </p>
          <FailedWorlds result={result} failed={worlds - result.succeeded} />
        </>
      )}
    </section>
  );
}

/** 79 to 92. */
function percent([low, high]: readonly [number, number]): string {
  return `${Math.round(100 * low)} to ${Math.round(100 * high)}`;
}

function FailedWorlds({ result, failed }: { result: EvaluationResult; failed: number }) {
  const studio = useStudio();
  const [listed, more] = useFirst(result.failed, FIRST, (hidden) => `${hidden} more`);
  return (
    <>
      {failed > 0 && <p class="failed-count">Failed in {formatCount(failed, "world")}:</p>}
      <ul class="failed" aria-label="Worlds in which it failed">
        {listed.map(({ seed, problem }) => (
          <li key={seed} class={className(studio.status?.seed === seed && "on")}>
            <span class="claim">
              World {seed} <span class="soft">{plain(problem)}</span>
            </span>
            <ControlButton
              class="small"
              aria-label={`Open world ${seed}`}
              title="Go to where it goes wrong, and press what is right"
              request={{ do: "visit_unseen_world", seed }}
            >
              Open
            </ControlButton>
          </li>
        ))}
      </ul>
      {more ||
        (result.failed.length < failed && (
          <p class="tiny">and {failed - result.failed.length} more that are not listed</p>
        ))}
    </>
  );
}

/** The result of a property in the last test. */
function PropertyMark({ outcome }: { outcome: LessonTest["properties"][number] | undefined }) {
  if (outcome === undefined) return null;
  if (!outcome.held) {
    return (
      <span class="warn" title={outcome.problem === "" ? "It failed" : outcome.problem}>
        ✗
      </span>
    );
  }
  return outcome.took_s === null ? (
    <span class="passes" title="It held">
      ✓
    </span>
  ) : (
    <span class="passes" title="Time until it was reached">
      ✓ {outcome.took_s.toFixed(1)} s
    </span>
  );
}

function PropertyAdder({ session, close }: { session: Session; close: () => void }) {
  const studio = useStudio();
  const [flag, setFlag] = useState(session.flags[0] ?? "");
  const [seconds, setSeconds] = useState("20");
  const within = Number(seconds);
  const sensible = seconds.trim() !== "" && within > 0;
  const addProperty = async (): Promise<void> => {
    if (!sensible) return;
    const answer = await studio.change({ do: "add_property", flag, within_s: within }, { do: "undo" });
    if (answer.error === undefined) close();
  };
  return (
    <Form class="flex wrap property-adder" submit={() => void addProperty()}>
      <span>From here,</span>
      <Select aria-label="flag" value={flag} among={session.flags} change={setFlag} />
      <label>
        within <Input value={seconds} inputMode="decimal" aria-label="seconds" change={setSeconds} /> s
      </label>
      <ControlButton type="submit" class="small primary" disabled={!sensible}>
        Add property
      </ControlButton>
      <p class="tiny">
        Where everything stands now is kept with the lesson; the automaton starts afresh there.
      </p>
    </Form>
  );
}

/** What was found, an automaton each, the one in training first. */
function Results() {
  const studio = useStudio();
  const { lessonTests } = studio;
  const { results } = lessonTests;
  if (results === null || (results.length === 0 && lessonTests.testing === null)) return null;
  const bad = results.filter(({ works }) => !works).length;
  const otherwise = results.reduce((sum, each) => sum + each.otherwise, 0);
  const held =
    otherwise === 0 ? "All as shown" : `${formatCount(otherwise, "moment")} decided otherwise than shown`;
  return (
    <section class="tested" aria-label="Tested" aria-live="polite">
      <div class="flex wrap outcomes-head">
        <b>
          {lessonTests.testing !== null
            ? "Testing"
            : bad === 0
              ? `${held}, all properties hold`
              : `Failed: ${bad} of ${results.length}`}
        </b>
        {lessonTests.testing === null && !lessonTests.fresh && (
          <span class="tiny">before the lesson changed; test it again</span>
        )}
        <span class="space" />
        <CloseButton class="link" label="Close what was tested" onClick={() => lessonTests.clearResults()} />
      </div>
      <ul>
        {results.map((each) => (
          <Result key={each.name} tested={each} />
        ))}
      </ul>
    </section>
  );
}

function Result({ tested }: { tested: LessonTest }) {
  const { name, works, examples, properties, regressions, differences: rest } = tested;
  const [sign, word] = !works ? ["✗", "worse"] : rest.length > 0 ? ["•", "otherwise"] : ["✓", "as it was"];
  return (
    <li class={className("result", !works && "bad")}>
      <p>
        <Sign tone={works ? "passes" : "warn"} means={word}>
          {sign}
        </Sign>{" "}
        <b>{plain(name)}</b>{" "}
        <span class="tiny">
          {examples === 0 ? "nothing recorded" : formatCount(examples, "moment")}
          {properties.length > 0 &&
            `, ${properties.length} ${properties.length === 1 ? "property" : "properties"}`}
        </span>
      </p>
      {regressions.map((line) => (
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
