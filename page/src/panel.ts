/** What the right column shows: its tab, the form for choosing, what is selected. */

import { News } from "./news";

export const TABS = ["automaton", "lesson", "coach", "library"] as const;
export type Tab = (typeof TABS)[number];
/** A form beside the running world: a new automaton, or other states and features for the present one. */
export type Form = "new" | "choose";

export class Panel {
  readonly news = new News();
  tab: Tab = "automaton";
  form: Form | null = null;
  /** The selected edge, "from to". */
  edge: string | null = null;
  example: number | null = null;
  /** The automaton for which "why" was asked. */
  why: string | null = null;
  /** Whether the tab Automaton shows what the last press or edit changed. */
  showsChanges = false;
  /** The behavior of the library that was asked for, another object each time. */
  behavior: { name: string } | null = null;
  /** Examples pointed at: those behind an edge. */
  highlighted: ReadonlySet<number> = new Set();

  open(tab: Tab): void {
    if (tab !== "library") this.behavior = null;
    this.tab = tab;
    this.form = null;
    this.news.tell();
  }

  choose(form: Form | null): void {
    this.form = form;
    this.news.tell();
  }

  selectEdge(edge: string | null): void {
    this.edge = this.edge === edge ? null : edge;
    this.news.tell();
  }

  selectExample(example: number | null): void {
    this.example = this.example === example ? null : example;
    this.news.tell();
  }

  /** Tell why, or no longer. */
  askWhy(automaton: string | null): void {
    this.why = automaton;
    this.news.tell();
  }

  /** Show what changed, with the edge where there is one selected. */
  showChanges(edge: string | null): void {
    this.showsChanges = true;
    this.edge = edge;
    this.open("automaton");
  }

  hideChanges(): void {
    this.showsChanges = false;
    this.edge = null;
    this.news.tell();
  }

  /** Show one example in the lesson, open. */
  openExample(number: number): void {
    this.highlighted = new Set([number]);
    this.example = number;
    this.open("lesson");
  }

  showBehavior(name: string): void {
    this.behavior = { name };
    this.open("library");
  }

  showExamples(numbers: readonly number[]): void {
    this.highlighted = new Set(numbers);
    this.example = null;
    this.open("lesson");
  }
}
