/** Whether lessons still hold: what saving would break, and what a test of the library found. */

import type { Answer, ChangeSummary, Request, Session, Tested } from "./protocol";

export interface Asking {
  ask: (request: Request) => Promise<Answer>;
  readonly desk: Session | null;
  /** The automata of the library that can be tested. */
  readonly testable: readonly string[];
  readonly news: { tell: () => void };
}

/** Which lesson something was found out about. */
interface Of {
  name: string;
  edition: number;
}

export class Trial {
  private warned: { of: Of; worse: readonly string[]; changed: ChangeSummary | null } | null = null;
  private tests: { of: Of | null; found: Tested[] } | null = null;
  /** What is being tested now. */
  testing: string | null = null;
  /** Whether saving is being looked at. */
  saving = false;

  constructor(private readonly studio: Asking) {}

  /** What worked and would no longer once the lesson is saved as it is; null where nothing is known of it. */
  get worse(): readonly string[] | null {
    return this.warned !== null && this.isNow(this.warned.of) ? this.warned.worse : null;
  }

  /** What the automaton decides otherwise than the saved one, apart from what presses say; null: nothing is known. */
  get changed(): ChangeSummary | null {
    return this.warned !== null && this.isNow(this.warned.of) ? this.warned.changed : null;
  }

  /** What was tested; null where nothing was. */
  get found(): readonly Tested[] | null {
    return this.tests?.found ?? null;
  }

  /** Whether what was tested is still as it was. */
  get fresh(): boolean {
    return this.tests !== null && this.isNow(this.tests.of);
  }

  /** Save what is trained, unless something broke or changed unasked, which is shown then; whether it is saved. */
  async save(anyway = false): Promise<boolean> {
    const of = this.now();
    this.saving = true;
    this.studio.news.tell();
    const { error, worse, changed = null } = await this.studio.ask({ do: "save", name: null, anyway });
    this.saving = false;
    this.warned = of === null || worse === undefined ? null : { of, worse, changed };
    this.studio.news.tell();
    return error === undefined && worse === undefined;
  }

  /** Do not save for now. */
  leave(): void {
    this.warned = null;
    this.studio.news.tell();
  }

  /** Test all lessons of the library, one after the other; what is trained first, as it stands. */
  async test(): Promise<void> {
    if (this.testing !== null) return;
    const of = this.now();
    const names = [...new Set([...(of === null ? [] : [of.name]), ...this.studio.testable])];
    const found: Tested[] = [];
    this.tests = { of, found };
    for (const name of names) {
      this.testing = name;
      this.studio.news.tell();
      const { tested } = await this.studio.ask({ do: "test", name });
      if (tested !== undefined) found.push(tested);
    }
    this.testing = null;
    this.studio.news.tell();
  }

  /** Put away what was tested. */
  forget(): void {
    this.tests = null;
    this.studio.news.tell();
  }

  private now(): Of | null {
    const { desk } = this.studio;
    return desk === null ? null : { name: desk.name, edition: desk.edition };
  }

  private isNow(of: Of | null): boolean {
    const now = this.now();
    return now?.name === of?.name && now?.edition === of?.edition;
  }
}
