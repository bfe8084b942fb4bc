/** What can be chosen: each behavior and feature with its parameters bound in every way. */

import type { Desk, DeskNews, Part, Scene } from "./protocol";

export interface Offer {
  name: string;
  /** goto(A), goto(station): all ways to call it. */
  ways: readonly string[];
}

const MOST_WAYS = 24;

/** A name with its parameters bound in every way. */
export function ways(part: Part, names: readonly string[]): string[] {
  let found: string[][] = [[]];
  for (const _ of part.parameters) found = found.flatMap((way) => names.map((name) => [...way, name]));
  return found
    .slice(0, MOST_WAYS)
    .map((way) => (way.length === 0 ? part.name : `${part.name}(${way.join(", ")})`));
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

/** Names separated by commas or spaces. */
export function listed(text: string): string[] {
  return [...new Set(text.split(/[\s,]+/).filter((name) => name !== ""))];
}
