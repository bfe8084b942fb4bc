/** What the page knows of the run so far: from when to when one can go back, and when examples were shown. */

import type { Example } from "./protocol";

/** How long the server keeps the moments of a run, s. */
export const KEPT_S = 300;
const HAIR_S = 1e-6;

export interface Mark {
  number: number;
  time: number;
  correction: boolean;
}

export class RunHistory {
  /** When the run began as far as is known, where it is now, and how far it went before the person went back. */
  start = 0;
  now = 0;
  latest = 0;
  marks: readonly Mark[] = [];
  private exampleNumbers: ReadonlySet<number> = new Set();

  get from(): number {
    return Math.max(this.start, this.latest - KEPT_S);
  }

  /** Another run begins at this time. */
  begin(time: number): void {
    this.start = this.now = this.latest = time;
    this.marks = [];
  }

  /** A moment of the run was seen: it went on, or the person went back. */
  record(time: number): void {
    if (time > this.now + HAIR_S) this.advance(time);
    else this.now = time;
  }

  /** The lesson's examples; those that are new were shown now. */
  markExamples(examples: readonly Example[], fresh: boolean): void {
    const numbers = new Set(examples.map((example) => example.number));
    const added = examples.filter(
      (example) => fresh && example.kind !== "default" && !this.exampleNumbers.has(example.number),
    );
    this.marks = [
      ...this.marks.filter((mark) => numbers.has(mark.number)),
      ...added.map(({ number, correction }) => ({ number, correction, time: this.now })),
    ];
    this.exampleNumbers = numbers;
  }

  private advance(time: number): void {
    const back = this.latest > this.now + HAIR_S;
    if (back) this.marks = this.marks.filter((mark) => mark.time <= this.now + HAIR_S);
    this.latest = time;
    this.now = time;
  }
}
