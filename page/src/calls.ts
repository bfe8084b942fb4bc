/** What can be chosen: each behavior and feature with its parameters bound in every way. */

import type { Call, Desk, DeskNews, Part, Scene, State } from "./protocol";

export interface Offer {
  name: string;
  /** goto(A), goto(station): all ways to call it. */
  ways: readonly string[];
}

const MOST_WAYS = 24;

/** A name with its parameters bound in every way. */
export function ways(part: Part, names: readonly string[]): string[] {
  return calls(part, names).map(called);
}

/** A behavior called in every way. */
export function calls(part: Part, names: readonly string[]): Call[] {
  let found: Record<string, string>[] = [{}];
  for (const parameter of part.parameters) {
    found = found.flatMap((targets) => names.map((name) => ({ ...targets, [parameter]: name })));
  }
  return found.slice(0, MOST_WAYS).map((targets) => ({ behavior: part.name, targets }));
}

/** goto(station). */
export function called({ behavior, targets }: Call): string {
  const bound = Object.values(targets);
  return bound.length === 0 ? behavior : `${behavior}(${bound.join(", ")})`;
}

export function offeredStates(
  scene: Scene,
  told: DeskNews,
  names: readonly string[],
  without: string,
): Offer[] {
  const trained = told.library.trained.filter(({ name }) => name !== without);
  return [...trained, ...scene.behaviors].map((part) => ({ name: part.name, ways: ways(part, names) }));
}

export function offeredFeatures(scene: Scene, names: readonly string[]): Offer[] {
  return scene.features.map(({ label, parameters }) => {
    const name = label.replace(/\(.*/, "");
    return { name, ways: ways({ name, parameters }, names) };
  });
}

/** What the automaton under training can do now, as it is chosen: without its start state and its flags. */
export function chosenStates(desk: Desk): string[] {
  return desk.states
    .filter((state, index) => index > 0 && !state.flag)
    .map((state) => state.runs ?? state.name);
}

/**
 * States as they are asked for: those there are keep their names; of several that run one behavior, each is
 * called as it runs, so that goto(station) and goto(nearest_food) are two.
 */
export function askedStates(chosen: readonly string[], states: readonly State[]): string[] {
  const known = states.filter((state, index) => index > 0 && !state.flag);
  const ways = [...new Set(chosen)];
  return ways.flatMap((way) => {
    const before = known.filter((state) => (state.runs ?? state.name) === way);
    if (before.length > 0) return before.map(({ name }) => `${name}=${way}`);
    const alike = ways.filter((each) => behaviorOf(each) === behaviorOf(way));
    return alike.length > 1 ? `${way}=${way}` : way;
  });
}

/** What is called: goto of goto(station). */
function behaviorOf(way: string): string {
  return way.replace(/\(.*/, "");
}

/** Names separated by commas or spaces. */
export function listed(text: string): string[] {
  return [...new Set(text.split(/[\s,]+/).filter((name) => name !== ""))];
}
