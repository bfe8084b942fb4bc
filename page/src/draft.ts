/** What is being chosen in a form, before it is asked for. */

import {
  askedStates,
  chosen,
  chosenStates,
  listed,
  offeredFeatures,
  offeredStates,
  renamedStates,
  type Chosen,
  type Offer,
} from "./calls";
import type { Form } from "./panel";
import type { Request, Scene, Targets } from "./protocol";
import type { Studio } from "./studio";

export interface Draft {
  name: string;
  parameters: string;
  targets: Targets;
  flags: string;
  states: readonly Chosen[];
  features: readonly string[];
  watched: boolean;
  reaction: string;
  unlearning: boolean;
  live: boolean;
}

const FIRST_STATES = ["forward", "rotate_left", "rotate_right"];
const FIRST_FEATURES = ["distance_to(A)", "angle_to(A)"];

/** The form as it opens: the present lesson; for a new one, what going to a thing needs, while nothing does that. */
export function drafted(form: Form, studio: Studio, scene: Scene): Draft {
  const { desk, told } = studio;
  if (form === "choose" && desk !== null) {
    return {
      name: desk.name,
      parameters: desk.parameters.join(", "),
      targets: desk.targets,
      flags: desk.states.flatMap(({ name, flag }) => (flag ? [name] : [])).join(", "),
      states: chosenStates(desk),
      features: desk.features.map(({ label }) => label),
      watched: desk.watched,
      reaction: String(desk.reaction_s),
      unlearning: desk.unlearning,
      live: desk.live,
    };
  }
  const offered = new Set(scene.features.map(({ label }) => label.replace(/\(.*/, "")));
  const goes = FIRST_FEATURES.every((each) => offered.has(each.replace(/\(.*/, "")));
  const first = goes && (told === null || told.library.trained.length === 0);
  const draft: Draft = {
    name: first ? "goto" : "",
    parameters: first ? "A" : "",
    targets: {},
    flags: "done",
    states: first ? FIRST_STATES.map(chosen) : [],
    features: first ? FIRST_FEATURES : [],
    watched: false,
    reaction: "0.3",
    unlearning: false,
    live: true,
  };
  return { ...draft, ...kept(draft, studio, scene) };
}

/** The names that behaviors and features can be bound to. */
export function names(draft: Draft, scene: Scene): string[] {
  return [...listed(draft.parameters), ...scene.targets];
}

export function offers(draft: Draft, studio: Studio, scene: Scene): { states: Offer[]; features: Offer[] } {
  const known = names(draft, scene);
  const states = studio.told === null ? [] : offeredStates(scene, studio.told, known, draft.name);
  return { states, features: offeredFeatures(scene, studio.told, known) };
}

/** What is chosen and still offered: parameters may have been renamed since. */
function kept(draft: Draft, studio: Studio, scene: Scene): Pick<Draft, "states" | "features"> {
  const { states, features } = offers(draft, studio, scene);
  const all = new Set([...states, ...features].flatMap(({ ways }) => ways));
  return {
    states: draft.states.filter(({ runs }) => all.has(runs)),
    features: draft.features.filter((each) => all.has(each)),
  };
}

/** The reaction time that was typed, s; null where it is none. */
export function reaction({ reaction }: Pick<Draft, "reaction">): number | null {
  const seconds = Number(reaction.replace(",", "."));
  return reaction.trim() !== "" && Number.isFinite(seconds) && seconds >= 0 ? seconds : null;
}

/** How a draft is asked for. */
export function request(form: Form, draft: Draft, studio: Studio, scene: Scene, discard: boolean): Request {
  const flags = listed(draft.flags);
  const { watched, unlearning, live } = draft;
  const options = { watched, unlearning, live, reaction_s: reaction(draft) };
  if (form === "choose") {
    return {
      do: "choose",
      states: askedStates(draft.states),
      renamed: renamedStates(draft.states),
      features: draft.features,
      flags,
      ...options,
    };
  }
  const parameters = listed(draft.parameters);
  const first = scene.targets[0] ?? "";
  const { states, features } = kept(draft, studio, scene);
  return {
    do: "new",
    name: draft.name.trim(),
    states: askedStates(states),
    features,
    parameters,
    flags,
    targets: Object.fromEntries(parameters.map((each) => [each, draft.targets[each] ?? first])),
    ...options,
    discard,
  };
}
