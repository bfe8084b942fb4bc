/** Failing worlds: what went wrong in each, whether it still does, and the way into it, to correct it there. */

import { ControlButton } from "../button";
import { useStudio } from "../context";
import { Progress, Sign } from "../lists";
import type { FailingWorld, Failures } from "../protocol";
import { className, formatCount, plain } from "../words";

const MARKS: Readonly<Record<FailingWorld["state"], readonly [string, string, string]>> = {
  "not run": ["○", "soft", "Not run yet with what is trained"],
  fails: ["✗", "warn", "Still fails"],
  passes: ["✓", "passes", "Passes now"],
  unknown: ["?", "warn", "Could not be run"],
};

export function FailuresPart() {
  const studio = useStudio();
  const failures = studio.status?.failures ?? null;
  if (
    !studio.offers.includes("runs") ||
    failures === null ||
    failures.worlds.length + failures.problems.length === 0
  )
    return null;
  const { worlds, problems, running } = failures;
  return (
    <section class="card outcomes failures" aria-label="Failing worlds">
      <div class="flex wrap outcomes-head">
        <h3>Failing worlds</h3>
        <ControlButton
          class="small"
          disabled={running}
          title="Run all of them, and the properties of the library, with what is trained as it stands"
          request={{ do: "rerun_failures" }}
        >
          {running ? "Running …" : "Run again"}
        </ControlButton>
      </div>
      <PassCount failures={failures} />
      <ul class="failed" aria-label="Failing worlds, the worst and most different first">
        {worlds.map((world) => (
          <FailureItem key={world.name} world={world} open={failures.open === world.name} />
        ))}
      </ul>
      {problems.map((problem) => (
        <p key={problem} class="warn">
          {problem}
        </p>
      ))}
    </section>
  );
}

/** How many of them pass; while they are run, how far that is. */
function PassCount({ failures }: { failures: Failures }) {
  const { worlds, running, finished, stale, previous_world } = failures;
  const tested = worlds.filter(({ state }) => state === "fails" || state === "passes");
  const passed = tested.filter(({ state }) => state === "passes").length;
  return (
    <>
      {running && (
        <Progress label="Failing worlds run" finished={finished} total={Math.max(1, worlds.length)} />
      )}
      <p class="tiny" aria-live="polite">
        {tested.length === 0
          ? "Open one, and press what is right where it goes wrong."
          : `${passed} of ${formatCount(worlds.length, "world")} ${passed === 1 ? "passes" : "pass"} now`}
        {stale && tested.length > 0 && !running && ", before the lesson changed; run them again"}
        {previous_world !== null && (
          <>
            {" · "}
            <ControlButton
              class="link"
              title="Leave the failing world; what is trained goes along"
              request={{ do: "leave_failure" }}
            >
              back to {plain(previous_world)}
            </ControlButton>
          </>
        )}
      </p>
    </>
  );
}

function FailureItem({ world, open }: { world: FailingWorld; open: boolean }) {
  const { name, behavior, summary, sentences, state, problem } = world;
  const [mark, tone, means] = MARKS[state];
  return (
    <li class={className(open && "on")}>
      <Sign tone={tone} means={means}>
        {mark}
      </Sign>
      <span class="claim" title={plain(sentences.join(" "))}>
        {name}{" "}
        <span class="soft">
          {!name.startsWith(behavior) && `${plain(behavior)}: `}
          {plain(problem === "" ? summary : problem)}
        </span>
      </span>
      <ControlButton
        class="small"
        aria-label={`Open failing world ${name}`}
        title="Go to this world, shortly before it goes wrong, and press what is right; what is trained goes along"
        request={{ do: "open_failure", name }}
      >
        Open
      </ControlButton>
    </li>
  );
}
