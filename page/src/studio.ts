/** The state of the page: the server's latest messages, and the page's own requests. */

import type { Frame } from "./frame";
import { Link, type FileOptions, type LinkListener } from "./link";
import { Live } from "./live";
import { FeatureHistory } from "./history";
import { RunHistory } from "./runhistory";
import { LessonTests } from "./lessontests";
import { WorldGridRuns } from "./worldgrid";
import type {
  Answer,
  ExportTarget,
  News as ServerNews,
  Offer,
  Request,
  Scene,
  Session,
  SessionNews,
  StatusMessage,
  Team,
} from "./protocol";
import { FrameReceiver } from "./world/receiver";

/** The longest time from the choice of another world to its first frame. */
const LATE_MS = 500;

export interface Notice extends StatusMessage {
  /** What takes it back, where something does. */
  undo?: Request;
}

export interface Latency {
  /** From the key to the answer, ms. */
  whole: number;
  /** The server's part of it, until the press was in the journal. */
  server: number | null;
}

/** The last switch from one state to another. */
export interface Switch {
  from: string;
  to: string;
  corrected: boolean;
  /** When, by the page's clock. */
  at: number;
}

export class Studio extends FrameReceiver implements LinkListener {
  readonly history = new FeatureHistory();
  readonly runHistory = new RunHistory();
  readonly lessonTests = new LessonTests(this);
  readonly worldGrid = new WorldGridRuns(this);
  readonly live = new Live(this);
  scene: Scene | null = null;
  status: SessionNews | null = null;
  /** The running team that the studio watches; null without one. */
  team: Team | null = null;
  /** What the page shows where there is a team. */
  view: "team" | "training" = "team";

  /** The sort of squads whose coordinator is trained; null: a robot is. */
  get sort(): string | null {
    return this.status?.sort ?? null;
  }

  /** The automata of the library that can be tested. */
  get testable(): readonly string[] {
    return this.status?.library.trained.flatMap(({ name, complete }) => (complete ? [name] : [])) ?? [];
  }

  /** Whether there is a connection; null before there was ever one. */
  linked: boolean | null = null;
  hasControl = false;
  /** Why there is no studio for this page; null while there is. */
  refusal: string | null = null;
  notice: Notice = { text: "", tone: "" };
  /** How many there were, to tell one from the next. */
  notices = 0;
  latency: Latency | null = null;
  asking: string | null = null;
  switch: Switch | null = null;
  /** Whether the last frame is of the present run: after another world was chosen it comes a moment later. */
  current = true;
  version = "";
  /** The targets that automata can be exported to. */
  exports: readonly ExportTarget[] = [];
  /** What can be done here; the rest is left out. */
  offers: readonly Offer[] = [];
  /** Where the library is kept, if that is not in files; else empty. */
  storageNote = "";
  /** Why no page can take control; empty if one can. */
  closed = "";
  /** How far the start of a studio in this page is; empty with a server. */
  stage = "";
  private back: Request | null = null;
  private readonly link = new Link(this);

  open(): void {
    this.link.open();
  }

  get session(): Session | null {
    return this.status?.session ?? null;
  }

  /** Ask, and say what went wrong where something did. */
  async ask(request: Request): Promise<Answer> {
    const answer = await this.link.ask(request);
    if (answer.error !== undefined) this.say({ text: answer.error, tone: "error" });
    return answer;
  }

  /** Ask for something that can be taken back; what the server says of it, which follows, offers that. */
  async change(request: Request, back: Request): Promise<Answer> {
    const answer = await this.ask(request);
    if (answer.error === undefined) this.back = back;
    return answer;
  }

  /** What the studio answers to a request for a file, or with one. */
  fetch(path: string, options?: FileOptions): Promise<Response> {
    return this.link.fetch(path, options);
  }

  /** Direct to a state; `since` is when its key went down, by the page's clock. */
  async press(state: string, since: number): Promise<void> {
    this.asking = state;
    this.news.tell();
    await this.measureLatency({ do: "press", state }, since);
    this.asking = null;
    this.news.tell();
  }

  confirm(since: number): Promise<void> {
    return this.measureLatency({ do: "confirm" }, since);
  }

  say(notice: Notice): void {
    this.notice = notice;
    this.notices += 1;
    this.news.tell();
  }

  switchView(what: "team" | "training"): void {
    this.view = what;
    this.news.tell();
  }

  setConnected(open: boolean): void {
    if (open || this.linked !== null) this.linked = open;
    if (!open) this.hasControl = false;
    this.news.tell();
  }

  note(stage: string): void {
    this.stage = stage;
    this.news.tell();
  }

  refuse(reason: string): void {
    this.refusal = reason;
    this.news.tell();
  }

  receive(news: ServerNews): void {
    if (news.is === "session") this.update(news);
    else if (news.is === "team") this.team = news.team;
    else {
      this.scene = news.scene;
      if (news.is === "hello") {
        this.team = news.team ?? null;
        this.hasControl = news.has_control;
        this.version = news.version;
        this.exports = news.exports;
        this.offers = news.offers;
        this.storageNote = news.storage_note;
        this.closed = news.closed;
        this.stage = "";
      }
    }
    this.news.tell();
  }

  protected keepFrame(frame: Frame): void {
    this.current = true;
    this.history.record(frame.tick, frame.features);
    this.runHistory.record(frame.time);
  }

  private async measureLatency(request: Request, since: number): Promise<void> {
    const answer = await this.ask(request);
    if (answer.error === undefined) {
      this.latency = { whole: performance.now() - since, server: answer.ms ?? null };
      this.news.tell();
    }
  }

  private update(news: SessionNews): void {
    const before = this.session;
    const { session, message: message } = news;
    const grew = before !== null && session !== null && before.examples.length < session.examples.length;
    const recorded = grew && (message.tone === "recorded" || message.tone === "correction");
    if (news.message_number !== this.status?.message_number) {
      const undo: Request | null = recorded ? { do: "undo" } : this.back;
      this.notice = undo === null ? message : { ...message, undo };
      this.back = null;
      this.notices += 1;
    }
    if (session === null || before?.name !== session.name) this.switch = null;
    else if (before.state !== session.state) {
      const corrected = message.tone === "correction";
      this.switch = { from: before.state, to: session.state, corrected, at: performance.now() };
    }
    if (joinLabels(before) !== joinLabels(session)) this.history.clear();
    if (news.run.number !== this.status?.run.number) {
      this.runHistory.begin(news.run.from_s);
      this.current = this.status === null;
      setTimeout(() => (this.current = true), LATE_MS); // a frame that is as the last is not sent
    }
    this.runHistory.markExamples(session?.examples ?? [], grew && before?.name === session?.name);
    this.status = news;
    this.hasControl = news.has_control;
  }
}

function joinLabels(session: Session | null): string {
  return (session?.features ?? []).map((feature) => feature.label).join("\n");
}
