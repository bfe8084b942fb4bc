/** What the page and the server say to each other as text; the binary frames are in frame.ts. */

import type { RealRequest, RealScene, RobotNews } from "./real";
import type { ReviewAnswer, ReviewRequest } from "./review";

export type Kind = "continuous" | "toroidal" | "categorical";
export type Mode = "training" | "testing";
export type Tone = "" | "recorded" | "correction" | "error";
export type Arrow = "up" | "down" | "left" | "right";
export type Targets = Readonly<Record<string, string>>;

/** What the page asks for. The link gives each a number, and the server answers it by that number. */
export type Request =
  | { do: "press"; state: string }
  | { do: "confirm" | "turn" | "undo" | "redo" | "step" | "restart" | "take" | "hand_over" }
  | { do: "pause"; paused: boolean }
  | { do: "speed"; speed: Speed }
  | { do: "reset"; seed: number | null }
  | { do: "rewind"; time_s: number }
  | { do: "rewind"; example: number }
  | { do: "stand_for"; targets: Targets }
  | { do: "open"; name: string; discard?: boolean }
  | Beginning
  | Choice
  | { do: "delete"; number: number }
  | { do: "quarantine"; numbers: readonly number[] }
  | { do: "release"; numbers: readonly number[] }
  | {
      do: "edit";
      number: number;
      state: string | null;
      next: string | null;
      /** As they are shown, by feature label. */
      values: Readonly<Record<string, string>>;
    }
  | { do: "remove" | "restore" | "discard" | "recall"; name: string }
  | { do: "rename" | "duplicate"; name: string; to: string }
  | { do: "go_back"; name: string; version: number }
  | { do: "agent"; agent: number; sort?: string | null; discard?: boolean }
  | { do: "others"; behavior: string | null; targets: Targets }
  | { do: "watch" }
  | { do: "place"; agent: number; x: number; y: number; heading: number | null }
  | { do: "move_object"; slot: number; x: number; y: number }
  | { do: "add_object"; kind: string; x: number; y: number }
  | { do: "remove_object"; slot: number }
  | { do: "add_obstacle"; x: number; y: number; radius: number }
  | { do: "move_obstacle"; index: number; x: number; y: number }
  | { do: "remove_obstacle"; index: number }
  | { do: "advise" }
  | { do: "set_up"; sentence: string }
  | { do: "ask_when"; when: AskWhen }
  | { do: "go_to_mark"; number: number }
  | { do: "use_reaction"; reaction_s: number }
  | { do: "mend"; number: number; next: string }
  | { do: "stand_by"; number: number }
  | RealRequest
  | ReviewRequest;

/** What the robot does in testing where it is unsure: nothing, wait for an answer, or go on and mark the moment. */
export type AskWhen = "never" | "pause" | "mark";

export interface Beginning {
  do: "new";
  name: string;
  states: readonly string[];
  features: readonly string[];
  parameters: readonly string[];
  flags: readonly string[];
  targets: Targets;
  watched: boolean;
  reaction_s: number | null;
  unlearning: boolean;
  discard: boolean;
}

export interface Choice {
  do: "choose";
  states: readonly string[];
  /** New names of states by those they had. */
  renamed: Readonly<Record<string, string>>;
  features: readonly string[];
  flags: readonly string[];
  watched: boolean | null;
  reaction_s: number | null;
  unlearning: boolean | null;
}

export interface Answer extends ReviewAnswer {
  re: number;
  ok?: boolean;
  error?: string;
  ms?: number;
  advice?: readonly Advice[];
  late?: Late | null;
  /** The lesson is large: ask again in a moment. */
  later?: boolean;
  /** What came of setting up a situation, and the number of the run that begins there. */
  sentence?: string;
  run?: number;
}

/** One thing the coach says of a lesson; `place`: it can be set up. */
export interface Advice {
  kind: string;
  sentence: string;
  /** From 0 to 1; above 0.5 it is plainly worth following. */
  weight: number;
  examples: readonly number[];
  /** What a press says that looks like a slip. */
  says: { state: string; next: string } | null;
  place: boolean;
}

/** How late presses seem to come. */
export interface Late {
  reaction_s: number;
  sentence: string;
}

/** A moment at which it was unsure and went on; `run` is null where that run was left. */
export interface UnsureMark {
  number: number;
  time_s: number;
  run: number | null;
  sentence: string;
}

export interface Asking {
  when: AskWhen;
  /** What waits for an answer, and what it would do. */
  question: { sentence: string; next: string } | null;
  marks: readonly UnsureMark[];
}

export interface RobotType {
  name: string;
  radius: number;
  color: string | null;
  team: string | null;
}

export interface ObjectClass {
  name: string;
  color: string | null;
  radius: number;
  food: boolean;
  home: boolean;
  solid: boolean;
  pushable: boolean;
  /** A place that somebody marked. */
  marker: boolean;
  /** Whether it makes sense to add one. */
  offered: boolean;
}

export interface Disc {
  x: number;
  y: number;
  radius: number;
  color: string | null;
}

export interface Sonar {
  name: string;
  from_deg: number;
  to_deg: number;
  range: number;
}

export interface Camera {
  view_deg: number;
  /** m; null: as far as anything is. */
  range: number | null;
}

/** A feature of the kit, or a behavior: a name and what it leaves open. */
export interface Part {
  name: string;
  parameters: readonly string[];
}

export interface KitFeature {
  label: string;
  parameters: readonly string[];
  unit: string;
  kind: Kind;
}

/** The fixed things of the world. */
export interface Scene extends RealScene {
  scenario: string;
  width: number;
  height: number;
  tick_s: number;
  seed: number | null;
  robots: number;
  types: readonly RobotType[];
  robot_type: readonly number[];
  classes: readonly ObjectClass[];
  walls: readonly (readonly [number, number, number, number])[];
  polygons: readonly (readonly (readonly [number, number])[])[];
  discs: readonly Disc[];
  targets: readonly string[];
  sonars: readonly (readonly Sonar[])[];
  cameras: readonly (readonly Camera[])[];
  features: readonly KitFeature[];
  behaviors: readonly Part[];
  /** The sorts of squads, the topmost first: for each squad the robots in it. */
  squads: readonly SquadSort[];
}

export interface SquadSort {
  name: string;
  doc: string;
  squads: readonly (readonly number[])[];
}

/** A state as it is drawn; those of nested automata, too. */
export interface Shape {
  name: string;
  flag: boolean;
  runs: string | null;
  /** The trained automaton it runs. */
  automaton: string | null;
  arrow?: Arrow | null;
}

export interface State extends Shape {
  key: string;
  arrow: Arrow | null;
}

/** An automaton that a state runs. */
export interface Inner {
  states: readonly Shape[];
  edges: readonly Way[];
}

export interface Feature {
  label: string;
  unit: string;
  kind: Kind;
  labels?: readonly string[];
}

export interface Example {
  number: number;
  state: string;
  next: string;
  values: readonly string[];
  kind: "directive" | "default" | "confirmation" | "watched";
  correction: boolean;
  /** When it was shown, in the time of its world; null where it was typed. */
  time_s: number | null;
  contradicts: boolean;
  /** Why it teaches nothing for now; empty where it teaches. */
  quarantined: string;
}

/** What the last correction came to, where it raised a doubt that nobody has acted on. */
export interface Doubt {
  reason: string;
  suspects: readonly { number: number; reason: string }[];
}

/** When it goes from one state to another, in words, a line for each way. */
export interface Way {
  from: string;
  to: string;
  when: readonly string[];
}

/** What was learned, and from which examples. */
export interface Edge extends Way {
  examples: readonly number[];
}

/** A behavior, and what its parameters stand for. */
export interface Call {
  behavior: string;
  targets: Targets;
}

/** How many times as fast as in life, or as fast as it goes. */
export type Speed = number | "fastest";

/** The automaton under training. */
export interface Desk {
  name: string;
  parameters: readonly string[];
  targets: Targets;
  mode: Mode;
  state: string;
  path: readonly string[];
  flag: string | null;
  waiting: string | null;
  agent: number;
  states: readonly State[];
  features: readonly Feature[];
  examples: readonly Example[];
  edges: readonly Edge[];
  /** The automata it runs, directly or through others, by name. */
  nested: Readonly<Record<string, Inner>>;
  watched: boolean;
  /** Whether silence is consent now, in a lesson with watched examples. */
  watching: boolean;
  /** What the robots run that are not trained; null: they idle. */
  others: Call | null;
  /** What robots do that a trained coordinator orders about, by the numbers in frames. */
  doing: readonly string[];
  reaction_s: number;
  /** Whether a correction puts bad examples in quarantine by itself. */
  unlearning: boolean;
  asking: Asking;
  /** What it can raise: done, failed, or any name. */
  flags: readonly string[];
  /** What the lesson promises: "done within 20 s in forage, A = station". */
  outcomes: readonly string[];
  /** How many examples each leaf must set right; 0: nothing is pruned, null: there are no trees. */
  pruning: number | null;
  /** Grows whenever the lesson changes. */
  edition: number;
  undoable: string | null;
  redoable: string | null;
  unsaved: boolean;
  taught: number;
  doubt: Doubt | null;
}

export interface Trained {
  name: string;
  parameters: readonly string[];
  runs: readonly string[];
  /** What it can say: done, failed, or any name. */
  flags: readonly string[];
  examples: number;
  /** Former ones. */
  versions: number;
  complete: boolean;
  why_not: string | null;
}

/** A lesson that was cut off before it was saved; opening it goes on with it. */
export interface CutOff {
  name: string;
  examples: number;
  began: string;
}

export interface Library {
  folder: string;
  basic: readonly string[];
  trained: readonly Trained[];
  trash: readonly string[];
  cut_off: readonly CutOff[];
}

export interface Said {
  text: string;
  tone: Tone;
}

export interface Hello {
  is: "hello";
  version: string;
  key: string;
  directs: boolean;
  scene: Scene;
}

export interface SceneNews {
  is: "scene";
  scene: Scene;
}

export interface DeskNews {
  is: "desk";
  library: Library;
  desk: Desk | null;
  said: Said;
  directs: boolean;
  viewers: number;
  paused: boolean;
  speed: Speed;
  seed: number | null;
  /** The sort of squads whose coordinator is trained; null: a robot is. */
  sort: string | null;
  /** Which run of the world this is, and from when of its time one can go back in it. */
  run: { number: number; from_s: number };
  /** Whether anybody directs. */
  directed: boolean;
  /** The robots, where they are real. */
  robots: readonly RobotNews[];
}

export type News = Hello | SceneNews | DeskNews;
export type Message = News | Answer;

/** A message of the server from its text; null where this page does not know its sort. */
export function parsed(text: string): Message | null {
  const value: unknown = JSON.parse(text);
  if (typeof value !== "object" || value === null) return null;
  if ("re" in value) return value as Answer;
  if (!("is" in value)) return null;
  const known = value.is === "hello" || value.is === "scene" || value.is === "desk";
  return known ? (value as News) : null;
}
