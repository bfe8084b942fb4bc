/** What can be chosen: each behavior and feature with its parameters bound in every way. */

import type { BehaviorCall, BehaviorParameters, Scene, Session, SessionNews } from "./protocol";

export interface Offer {
  name: string;
  /** goto(A), goto(station): all ways to call it. */
  ways: readonly string[];
}

const MOST_WAYS = 24;

/** A name with its parameters bound in every way. */
export function callVariants(part: BehaviorParameters, names: readonly string[]): string[] {
  return bindAll(part, names).map(formatCall);
}

/** A behavior called in every way. */
export function bindAll(part: BehaviorParameters, names: readonly string[]): BehaviorCall[] {
  let bindings: Record<string, string>[] = [{}];
  for (const parameter of part.parameters) {
    bindings = bindings.flatMap((targets) => names.map((name) => ({ ...targets, [parameter]: name })));
  }
  return bindings.slice(0, MOST_WAYS).map((targets) => ({ behavior: part.name, targets }));
}

/** goto(station). */
export function formatCall({ behavior, targets }: BehaviorCall): string {
  const bound = Object.values(targets);
  return bound.length === 0 ? behavior : `${behavior}(${bound.join(", ")})`;
}

export function offerStates(
  scene: Scene,
  status: SessionNews,
  names: readonly string[],
  without: string,
): Offer[] {
  const trained = status.library.trained.filter(({ name }) => name !== without);
  return [...trained, ...scene.behaviors].map((part) => ({
    name: part.name,
    ways: callVariants(part, names),
  }));
}

/** The kit's features, and flags beyond them that trained automata raise. */
export function offerFeatures(scene: Scene, status: SessionNews | null, names: readonly string[]): Offer[] {
  const offers = scene.features.map(({ label, parameters }) => {
    const name = label.replace(/\(.*/, "");
    return { name, ways: callVariants({ name, parameters }, names) };
  });
  const kitNames = new Set(offers.map(({ name }) => name));
  const raised = new Set(status?.library.trained.flatMap(({ flags }) => flags) ?? []);
  return [
    ...offers,
    ...[...raised].filter((flag) => !kitNames.has(flag)).map((name) => ({ name, ways: [name] })),
  ];
}

/** A state in a form: the behavior that it runs, its name if it has one, and its former name. */
export interface StateChoice {
  runs: string;
  name: string;
  was: string | null;
}

export function chooseState(runs: string): StateChoice {
  return { runs, name: "", was: null };
}

/** What the automaton under training can do now, as it is chosen: without its start state and its flags. */
export function chooseLessonStates(session: Session): StateChoice[] {
  return session.states
    .filter((state, index) => index > 0 && !state.flag)
    .map(({ name, runs }) => ({ runs: runs ?? name, name, was: name }));
}

/**
 * What states are called: as they were named, else like their behavior; of several that call one behavior in
 * several ways, each as it runs, so that goto(station) and goto(nearest_food) are two.
 */
export function stateNames(states: readonly StateChoice[]): string[] {
  return states.map(({ runs, name }) => {
    if (name.trim() !== "") return name.trim();
    const alike = states.some((each) => each.runs !== runs && behaviorOf(each.runs) === behaviorOf(runs));
    return alike ? runs : behaviorOf(runs);
  });
}

/** States as they are asked for. */
export function requestStates(states: readonly StateChoice[]): string[] {
  const names = stateNames(states);
  return states.map(({ runs }, index) => {
    const name = names[index] ?? "";
    return name === behaviorOf(runs) ? runs : `${name}=${runs}`;
  });
}

/** The new names of states that have another name now. */
export function listRenamed(states: readonly StateChoice[]): Record<string, string> {
  const names = stateNames(states);
  const pairs = states.map(({ was }, index) => [was ?? "", names[index] ?? ""] as const);
  return Object.fromEntries(pairs.filter(([was, name]) => was !== "" && was !== name));
}

/** One more state that runs the same, after the one at this place, with a name of its own. */
export function duplicateState(states: readonly StateChoice[], index: number): StateChoice[] {
  const state = states[index];
  if (state === undefined) return [...states];
  const taken = new Set(stateNames(states));
  let number = 2;
  while (taken.has(`${behaviorOf(state.runs)}_${number}`)) number += 1;
  const more = { ...chooseState(state.runs), name: `${behaviorOf(state.runs)}_${number}` };
  return [...states.slice(0, index + 1), more, ...states.slice(index + 1)];
}

/** A name that two states would have; null where there is none. */
export function findDuplicate(states: readonly StateChoice[]): string | null {
  const names = stateNames(states);
  return names.find((name, index) => names.indexOf(name) !== index) ?? null;
}

/** What is called: goto of goto(station). */
function behaviorOf(way: string): string {
  return way.replace(/\(.*/, "");
}

/** Names separated by commas or spaces. */
export function splitNames(text: string): string[] {
  return [...new Set(text.split(/[\s,]+/).filter((name) => name !== ""))];
}
