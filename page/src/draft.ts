/** What is being chosen in a form, before it is asked for. */

import {
  requestStates,
  chooseState,
  chooseLessonStates,
  splitNames,
  offerFeatures,
  offerStates,
  listRenamed,
  type StateChoice,
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
  states: readonly StateChoice[];
  features: readonly string[];
  watched: boolean;
  reaction: string;
  unlearning: boolean;
  live: boolean;
}

const FIRST_STATES = ["forward", "rotate_left", "rotate_right"];
const FIRST_FEATURES = ["distance_to(A)", "angle_to(A)"];

/** The form as it opens: the present lesson; for a new one, what going to a thing needs, while nothing does that. */
export function makeDraft(form: Form, studio: Studio, scene: Scene): Draft {
  const { session, status } = studio;
  if (form === "choose" && session !== null) {
    return {
      name: session.name,
      parameters: session.parameters.join(", "),
      targets: session.targets,
      flags: session.states.flatMap(({ name, flag }) => (flag ? [name] : [])).join(", "),
      states: chooseLessonStates(session),
      features: session.features.map(({ label }) => label),
      watched: session.watched,
      reaction: String(session.reaction_s),
      unlearning: session.unlearning,
      live: session.live,
    };
  }
  const offered = new Set(scene.features.map(({ label }) => label.replace(/\(.*/, "")));
  const goes = FIRST_FEATURES.every((each) => offered.has(each.replace(/\(.*/, "")));
  const first = goes && (status === null || status.library.trained.length === 0);
  const draft: Draft = {
    name: first ? "goto" : "",
    parameters: first ? "A" : "",
    targets: {},
    flags: "done",
    states: first ? FIRST_STATES.map(chooseState) : [],
    features: first ? FIRST_FEATURES : [],
    watched: false,
    reaction: "0.3",
    unlearning: false,
    live: true,
  };
  return { ...draft, ...keepOffered(draft, studio, scene) };
}

/** The names that behaviors and features can be bound to. */
export function listNames(draft: Draft, scene: Scene): string[] {
  return [...splitNames(draft.parameters), ...scene.targets];
}

export function listOffers(
  draft: Draft,
  studio: Studio,
  scene: Scene,
): { states: Offer[]; features: Offer[] } {
  const bindable = listNames(draft, scene);
  const states = studio.status === null ? [] : offerStates(scene, studio.status, bindable, draft.name);
  return { states, features: offerFeatures(scene, studio.status, bindable) };
}

/** What is chosen and still offered: parameters may have been renamed since. */
function keepOffered(draft: Draft, studio: Studio, scene: Scene): Pick<Draft, "states" | "features"> {
  const { states, features } = listOffers(draft, studio, scene);
  const all = new Set([...states, ...features].flatMap(({ ways }) => ways));
  return {
    states: draft.states.filter(({ runs }) => all.has(runs)),
    features: draft.features.filter((each) => all.has(each)),
  };
}

/** The reaction time that was typed, s; null where it is none. */
export function parseReaction({ reaction }: Pick<Draft, "reaction">): number | null {
  const seconds = Number(reaction.replace(",", "."));
  return reaction.trim() !== "" && Number.isFinite(seconds) && seconds >= 0 ? seconds : null;
}

/** How a draft is asked for. */
export function makeRequest(
  form: Form,
  draft: Draft,
  studio: Studio,
  scene: Scene,
  discard: boolean,
): Request {
  const flags = splitNames(draft.flags);
  const { watched, unlearning, live } = draft;
  const options = { watched, unlearning, live, reaction_s: parseReaction(draft) };
  if (form === "choose") {
    return {
      do: "change_design",
      states: requestStates(draft.states),
      renamed: listRenamed(draft.states),
      features: draft.features,
      flags,
      ...options,
    };
  }
  const parameters = splitNames(draft.parameters);
  const first = scene.targets[0] ?? "";
  const { states, features } = keepOffered(draft, studio, scene);
  return {
    do: "new",
    name: draft.name.trim(),
    states: requestStates(states),
    features,
    parameters,
    flags,
    targets: Object.fromEntries(parameters.map((each) => [each, draft.targets[each] ?? first])),
    ...options,
    discard,
  };
}
