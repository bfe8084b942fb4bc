/** What the page asks to look back, and what it is told: why, promises and tests, versions, simplifying. */

import type { Example } from "./protocol";

export type ReviewRequest =
  | { do: "why" }
  | { do: "promise"; flag: string; within_s: number }
  | { do: "withdraw" | "visit"; outcome: number }
  | { do: "test"; name: string }
  | { do: "save"; name: string | null; anyway?: boolean }
  | { do: "simplify"; pruning: number | null }
  | { do: "prune"; pruning: number }
  | { do: "versions"; name: string }
  | { do: "changes"; name: string; version: number; to: number | null };

export interface ReviewAnswer {
  levels?: readonly Level[];
  last?: Switched | null;
  tested?: Tested;
  /** What worked and no longer does, so that nothing was saved. */
  worse?: readonly string[];
  simpler?: Simpler;
  versions?: readonly Version[];
  changes?: readonly Change[];
  moved?: readonly Moved[];
}

/** Who is behind a decision. */
export interface Behind {
  automaton: string;
  says: string;
  /** What it read, in words. */
  read: string;
  by_hand: boolean;
  /** Whether its examples are those of the lesson that is open. */
  here: boolean;
  examples: readonly Responsible[];
  /** How many examples there are beyond these. */
  more: number;
}

export interface Level extends Behind {
  state: string;
  since_s: number;
  /** It is in training: somebody else decides. */
  yours: boolean;
}

/** The last switch of any level. */
export interface Switched extends Behind {
  time_s: number;
}

export type Responsible = Pick<Example, "number" | "kind" | "correction" | "time_s">;

/** An automaton tested on its lesson. */
export interface Tested {
  name: string;
  works: boolean;
  examples: number;
  /** In the order of the lesson. */
  outcomes: readonly { said: string; took_s: number | null; problem: string }[];
  worse: readonly string[];
  else: readonly string[];
}

/** What the automaton would be with fewer questions. */
export interface Simpler {
  pruning: number;
  /** Null where there are too few examples to tell. */
  suggested: { pruning: number; left_out: number; wrong: number; wrong_pruned: number } | null;
  /** So many examples would be enough. */
  enough: number;
  leaves: { before: number; after: number };
  states: readonly { state: string; before: readonly string[]; after: readonly string[] }[];
  decisions: readonly { number: number; state: string; shown: string; before: string; after: string }[];
  examples: number;
  /** Those of the second before presses. */
  moments: { all: number; changed: number };
}

/** A former version of a behavior, and when it was saved. */
export interface Version {
  number: number;
  saved: string | null;
}

/** What changed in one respect: lines that begin with + (new), - (gone), or neither. */
export interface Change {
  topic: string;
  lines: readonly string[];
}

/** When it goes from one state to another: what is gone of that, what is new, and because of whom. */
export interface Moved {
  from: string;
  to: string;
  what: "moved" | "appeared" | "vanished";
  gone: readonly string[];
  new: readonly string[];
  examples: readonly { number: number; happened: string; how: string }[];
}
