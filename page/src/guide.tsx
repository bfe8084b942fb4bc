/** The card of the tour: what to do next, under the world, so that it never covers the robot; a ring around what to press. */

import { useEffect, useRef } from "preact/hooks";
import { Button } from "./button";
import { usePanel, useStudio, useTour } from "./context";
import { nameStateKey } from "./keyname";
import { useSlowNews } from "./news";
import type { Session, State } from "./protocol";
import type { Studio } from "./studio";
import { isThere, STEPS, chooseDirection, type Moment, type Tour } from "./tour";
import { className, toDegrees, hasKeys, plain } from "./words";

interface TourStep {
  text: string;
  /** What to press: a selector. */
  at: string | null;
}

export function Guide() {
  const tour = useTour();
  return tour.active ? <Card tour={tour} /> : null;
}

function Card({ tour }: { tour: Tour }) {
  const studio = useStudio();
  const panel = usePanel();
  useSlowNews(studio.framed);
  const moment = readMoment(studio);
  useEffect(() => {
    if (studio.current) tour.see(moment);
  });
  const advice = advise(tour, moment, studio, panel.form !== null);
  usePointing(advice.at);
  if (studio.status === null) return null;
  return (
    <section class={className("flex", "tour-card", tour.done && "over")} aria-label="Tour">
      <ol class="steps" aria-hidden="true">
        {STEPS.map((name, index) => (
          <li key={name} class={className(index < tour.step && "passed", index === tour.step && "now")} />
        ))}
      </ol>
      <p aria-live="polite">
        <b>{tour.done ? "Done" : `${tour.step + 1} of ${STEPS.length}: ${STEPS[tour.step]}`}.</b>{" "}
        {advice.text}
      </p>
      <Button class="small" onClick={() => tour.leave()}>
        {tour.done ? "Close" : "Leave the tour"}
      </Button>
    </section>
  );
}

/** The way back into a tour that was left. */
export function ResumeTour() {
  const tour = useTour();
  if (!tour.left) return null;
  return (
    <Button class="row soft" onClick={() => tour.begin(false)}>
      Resume the tour
    </Button>
  );
}

/** What the tour looks at, as it is now. */
function readMoment(studio: Studio): Moment {
  const { session, status, motion } = studio;
  const read = (name: string): number => {
    const index =
      session?.features.findIndex(({ label }) => label === `${name}(${session.parameters[0]})`) ?? -1;
    return motion.last?.features[index] ?? NaN;
  };
  const state = session?.states.find(({ name }) => name === session.state);
  return {
    isTaught: session !== null && teaches(session),
    state: session?.state ?? "",
    stopped: state?.flag ?? false,
    presses: session?.presses ?? 0,
    seed: status?.seed ?? null,
    distance: read("distance_to"),
    angle: toDegrees(read("angle_to")),
    works: countWorks(studio),
  };
}

/** Whether it is what the tour teaches: going to a thing. */
function teaches(session: Session): boolean {
  const labels = session.features.map(({ label }) => label);
  const [parameter] = session.parameters;
  const sees = [`distance_to(${parameter})`, `angle_to(${parameter})`].every((each) => labels.includes(each));
  const goes = (["up", "left", "right"] as const).every((way) =>
    session.states.some((each) => each.arrow === way),
  );
  return sees && goes && session.states.some(({ flag }) => flag);
}

const NEW_WORLD = ".time-controls [title='The next world']";

function advise(tour: Tour, moment: Moment, studio: Studio, form: boolean): TourStep {
  const { session } = studio;
  if (tour.done) return concludes(studio);
  if (session === null || !moment.isTaught) {
    if (form)
      return {
        text: "All is chosen already: press Begin.",
        at: ".choice .primary",
      };
    return { text: "Begin goto, or open it again, and the tour goes on.", at: ".library-new" };
  }
  if (tour.step === 5)
    return {
      text: "Now let it run in a hundred worlds in which it was not taught, all at once.",
      at: ".show-grid",
    };
  if (studio.status?.paused === true)
    return { text: `Paused. Press ${hasKeys() ? "Space" : "▶"} to resume.`, at: ".pause" };
  if (!studio.current) return { text: "A new world.", at: null }; // nothing is known of it yet
  if (tour.step < 3) return drives(moment, session);
  if (tour.same(moment))
    return { text: "It has learned from your presses already. Go to a new world.", at: NEW_WORLD };
  if (isThere(moment))
    return { text: "It is there, and has learned from what you pressed. Now another world.", at: NEW_WORLD };
  return corrects(tour, moment, session, studio.motion.last?.time ?? 0);
}

/** In how many of a hundred worlds it works, 0 where there can be none; null before they are on the page. */
function countWorks({ offers, worldGrid }: Studio): number | null {
  if (!offers.includes("runs")) return 0;
  return worldGrid.open ? (worldGrid.grid?.works ?? null) : null;
}

/** What to do with a robot that ran in a hundred worlds. */
function concludes(studio: Studio): TourStep {
  const { grid, open } = studio.worldGrid;
  const fails = grid === null ? 0 : grid.worlds.length - grid.works;
  if (open && fails > 0)
    return {
      text: "You wrote no rule. Where it is red, click: you come to where it goes wrong, and one press corrects it.",
      at: null,
    };
  if (!open && studio.status?.paused === true && studio.session?.mode === "testing")
    return { text: "Press what it should do here. Then let it run in all worlds again.", at: ".show-grid" };
  return {
    text: "It goes there by itself, and you wrote no rule. Save keeps it in the library.",
    at: ".save-controls button:last-child",
  };
}

/** What to press where the robot decides by itself: nothing, unless it does something else than it should for a while. */
function corrects(tour: Tour, moment: Moment, session: Session, time: number): TourStep {
  const advice = drives(moment, session);
  if (!tour.needsHelp(advice.at !== null, time))
    return { text: "It decides by itself. Press only where it does wrong.", at: null };
  return { ...advice, text: `It should do something else. ${advice.text}` };
}

/** What to press to come to A. */
function drives(moment: Moment, session: Session): TourStep {
  const now = session.states.find(({ name }) => name === moment.state);
  const direction = chooseDirection(moment, now?.arrow ?? null);
  const next = session.states.find((each) => (direction === "done" ? each.flag : each.arrow === direction));
  const place = plain(session.targets[session.parameters[0] ?? ""] ?? "place");
  if (direction === null || next === undefined)
    return { text: `Turn until the robot sees the ${place}.`, at: null };
  if (now === next) {
    const wait =
      direction === "up"
        ? `It drives. Wait until it is at the ${place}.`
        : `It turns. Wait until the ${place} is ahead.`;
    return { text: `${wait} Nothing to press now.`, at: null };
  }
  return { text: describePress(next, direction, place), at: `.state[data-state=${CSS.escape(next.name)}]` };
}

function describePress(next: State, direction: string, place: string): string {
  if (direction === "done") return `It is there: press ${describeState(next)}.`;
  if (direction === "up") return `The ${place} is ahead: press ${describeState(next)}.`;
  return `The ${place} is to the ${direction}: press ${describeState(next)}.`;
}

/** A state with its key; where there is no keyboard, without. */
function describeState(state: State): string {
  return hasKeys() ? `${nameStateKey(state)}, ${plain(state.name)}` : plain(state.name);
}

/** A ring around what to press. */
function usePointing(at: string | null): void {
  const pointed = useRef<Element | null>(null);
  const point = (target: Element | null): void => {
    if (target === pointed.current) return;
    pointed.current?.removeAttribute("data-pointed");
    target?.setAttribute("data-pointed", "");
    pointed.current = target;
  };
  useEffect(() => point(at === null ? null : document.querySelector(at)));
  useEffect(() => () => point(null), []);
}
