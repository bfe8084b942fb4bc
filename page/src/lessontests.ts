/** Whether lessons still hold: what saving would break, and what a test of the library found. */

import type { Answer, ChangeSummary, Request, Session, LessonTest } from "./protocol";

export interface TestSource {
  ask: (request: Request) => Promise<Answer>;
  readonly session: Session | null;
  /** The automata of the library that can be tested. */
  readonly testable: readonly string[];
  readonly news: { tell: () => void };
}

/** Which lesson something was found out about. */
interface LessonEdition {
  name: string;
  edition: number;
}

export class LessonTests {
  private warned: {
    of: LessonEdition;
    regressions: readonly string[];
    changed: ChangeSummary | null;
  } | null = null;
  private tests: { of: LessonEdition | null; results: LessonTest[] } | null = null;
  /** What is being tested now. */
  testing: string | null = null;
  /** Whether saving is being looked at. */
  saving = false;

  constructor(private readonly studio: TestSource) {}

  /** What worked and would no longer once the lesson is saved as it is; null where nothing is known of it. */
  get regressions(): readonly string[] | null {
    return this.warned !== null && this.isCurrent(this.warned.of) ? this.warned.regressions : null;
  }

  /** What the automaton decides otherwise than the saved one, apart from what presses say; null: nothing is known. */
  get changed(): ChangeSummary | null {
    return this.warned !== null && this.isCurrent(this.warned.of) ? this.warned.changed : null;
  }

  /** What was tested; null where nothing was. */
  get results(): readonly LessonTest[] | null {
    return this.tests?.results ?? null;
  }

  /** Whether what was tested is still as it was. */
  get fresh(): boolean {
    return this.tests !== null && this.isCurrent(this.tests.of);
  }

  /** Save what is trained, unless something broke or changed unasked, which is shown then; whether it is saved. */
  async save(anyway = false): Promise<boolean> {
    const of = this.currentEdition();
    this.saving = true;
    this.studio.news.tell();
    const { error, regressions, changed = null } = await this.studio.ask({ do: "save", name: null, anyway });
    this.saving = false;
    this.warned = of === null || regressions === undefined ? null : { of, regressions, changed };
    this.studio.news.tell();
    return error === undefined && regressions === undefined;
  }

  /** Do not save for now. */
  dismissWarning(): void {
    this.warned = null;
    this.studio.news.tell();
  }

  /** Test all lessons of the library, one after the other; what is trained first, as it stands. */
  async test(): Promise<void> {
    if (this.testing !== null) return;
    const of = this.currentEdition();
    const names = [...new Set([...(of === null ? [] : [of.name]), ...this.studio.testable])];
    const results: LessonTest[] = [];
    this.tests = { of, results };
    for (const name of names) {
      this.testing = name;
      this.studio.news.tell();
      const { test } = await this.studio.ask({ do: "test", name });
      if (test !== undefined) results.push(test);
    }
    this.testing = null;
    this.studio.news.tell();
  }

  /** Put away what was tested. */
  clearResults(): void {
    this.tests = null;
    this.studio.news.tell();
  }

  private currentEdition(): LessonEdition | null {
    const { session } = this.studio;
    return session === null ? null : { name: session.name, edition: session.edition };
  }

  private isCurrent(of: LessonEdition | null): boolean {
    const currentEdition = this.currentEdition();
    return currentEdition?.name === of?.name && currentEdition?.edition === of?.edition;
  }
}
