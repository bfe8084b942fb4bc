/** A drive under way: the world as it moves, the stick, what the server says, and the review of what was driven. */

import type { Frame } from "../frame";
import { openSocket, serverAddress } from "../link";
import { listenTo } from "../listen";
import { News } from "../news";
import type { DriveNews, DriveRequest, Scene, SceneNews } from "../protocol";
import { Recording } from "../recording/recording";
import { makeTimer } from "../timer";
import type { PictureSession } from "../world/picture";
import { FrameReceiver } from "../world/receiver";
import type { WorldSource } from "../world/stage";
import { readGamepad, Stick } from "./stick";

/** Interval at which the stick is sent while driving, ms; after a longer silence the server takes it as at rest. */
const EVERY_MS = 50;
const AGAIN_MS = 1000;
const REFUSED = 4403;
const TAKEN = 4409;

export class DriveController extends FrameReceiver implements WorldSource {
  /** Tells when the stick moves. */
  readonly moved = new News();
  readonly recording = new Recording();
  readonly stick = new Stick();
  readonly sort = null;
  readonly hasControl = false;
  readonly live = { fixed: true };
  status: DriveNews | null = null;
  scene: Scene | null = null;
  session: PictureSession | null = null;
  /** Why this page does not drive; empty while it does. */
  lost = "";
  /** The world's time, s. */
  time = 0;
  hasPad = false;
  private socket: WebSocket | null = null;
  private fetching = false;
  private fetched = 0;
  private started = false;
  private begins = false;
  /** What is shown of the stick. */
  private lastStick = "";

  open(): void {
    const socket = openSocket(serverAddress("drive"));
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.take(event.data);
    socket.onclose = (event) => this.leave(event);
    this.socket = socket;
  }

  /** True while driving: labels cannot be changed then. */
  get driving(): boolean {
    return this.status?.driving ?? false;
  }

  /** True while the automaton that was learned drives. */
  get automatic(): boolean {
    return this.status?.automatic ?? false;
  }

  send(request: DriveRequest): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  /** True while the keys command the stick: from the press of Drive on, and to take over from the automaton. */
  get steers(): boolean {
    return this.driving || this.automatic || this.begins;
  }

  /** Drive, or pause. */
  turn(): void {
    if (this.driving || this.automatic) this.send({ do: "pause_drive" });
    else this.begin();
  }

  /** Let the automaton that was learned drive. */
  letDrive(): void {
    this.stick.release();
    this.send({ do: "let_drive" });
  }

  /** Begin to drive unless it is driven already; the world waits for the stick. */
  begin(): void {
    if (
      this.driving ||
      this.automatic ||
      this.lost !== "" ||
      (this.recording.busy !== null && this.recording.busy !== "drive")
    )
      return;
    this.begins = true;
    this.send({ do: "drive" });
  }

  /** The stick moved, or may have. */
  steer(): void {
    const { right, up } = this.stick.lean;
    const held = this.stick.listHeld(this.status?.held.length ?? 0);
    if (this.driving || this.automatic) this.send({ do: "steer", right, up, held });
    const lastStick = [right, up, this.stick.pulled !== null, ...held].join();
    if (lastStick === this.lastStick) return;
    this.lastStick = lastStick;
    this.moved.tell();
  }

  /** Nobody holds anything: the robot rests at once. */
  release(): void {
    this.stick.release();
    this.steer();
  }

  /** Listen to the gamepad, and to the page that is left; what ends that. */
  listen(): () => void {
    const look = (): void => {
      this.readPad();
      if (this.driving || this.automatic) this.steer();
    };
    const turn = makeTimer(look, EVERY_MS);
    const stop = this.news.listen(() => turn(this.hasPad || this.driving || this.automatic));
    const hide = (): void => {
      this.release();
      if (document.hidden && (this.driving || this.automatic)) this.send({ do: "pause_drive" });
    };
    look();
    const ends = [
      stop,
      () => turn(false),
      listenTo(globalThis, { gamepadconnected: look, focus: look, blur: () => this.release() }),
      listenTo(document, { visibilitychange: hide }),
    ];
    return () => ends.forEach((end) => end());
  }

  private readPad(): void {
    const gamepad = document.hasFocus() ? navigator.getGamepads?.().find((pad) => pad !== null) : undefined;
    const pad = gamepad === undefined || gamepad === null ? null : readGamepad(gamepad);
    if (this.hasPad !== (pad !== null)) {
      this.hasPad = pad !== null;
      this.news.tell();
    }
    if (pad?.start === true && !this.started) this.turn();
    this.started = pad?.start ?? false;
    this.stick.pad = pad;
  }

  private take(data: string | ArrayBuffer): void {
    if (typeof data !== "string") return this.receiveFrame(data);
    const news = JSON.parse(data) as DriveNews | SceneNews;
    if (news.is === "scene") {
      this.scene = news.scene;
      this.motion.trail.length = 0;
    } else if (news.is === "drive") this.hear(news);
    this.news.tell();
  }

  private hear(news: DriveNews): void {
    const { recording } = this;
    const was = this.driving;
    this.status = news;
    if (news.driving || news.error !== "") this.begins = false;
    this.lost = "";
    this.session = { mode: "training", features: news.features, activities: [] };
    const { busy } = recording;
    if (busy === null || busy === "drive" || busy === "automatic") {
      recording.busy = news.automatic ? "automatic" : news.driving || !news.current ? "drive" : null;
    }
    if (news.driving) recording.select(null);
    if (was && !news.driving) this.release();
    void this.refresh();
    recording.news.tell();
  }

  protected keepFrame(frame: Frame): void {
    this.time = frame.time;
  }

  /** Fetch the review if it changed since the last time. */
  private async refresh(): Promise<void> {
    if (this.fetching) return;
    this.fetching = true;
    while (this.fetched !== (this.status?.version ?? 0)) {
      this.fetched = this.status?.version ?? 0;
      await this.recording.refresh();
    }
    this.fetching = false;
    this.news.tell();
  }

  private leave(event: CloseEvent): void {
    this.socket = null;
    this.begins = false;
    this.release();
    if (this.status !== null) {
      this.status = { ...this.status, driving: false, waiting: false, automatic: false };
    }
    if (event.code === TAKEN)
      this.lost = "Another page drives this robot now. Load this page again to drive it.";
    else if (event.code === REFUSED) this.lost = event.reason;
    else {
      this.lost = "The connection to the studio is lost. The robot rests.";
      setTimeout(() => this.open(), AGAIN_MS);
    }
    this.news.tell();
  }
}
