/** The connection to the server: numbered requests and their answers, and reconnecting when it is lost. */

import type { Answer, News, Request } from "./protocol";
import { findParts, WorkerChannel } from "./workerlink";

const FIRST_WAIT = 300;
const LONGEST_WAIT = 4000;
const REFUSED = 4403;
const KEPT = "understudy-key";

export interface LinkListener {
  receive(news: News): void;
  receiveFrame(frame: ArrayBuffer): void;
  setConnected(open: boolean): void;
  /** How far the start of a studio in this page is, in words. */
  note(stage: string): void;
  /** The server lets this page in no more, or there is no studio in this page; a sentence says why. */
  refuse(reason: string): void;
}

/** What a request for a file asks for, and what it sends. */
export interface FileOptions {
  query?: readonly (readonly [string, string])[];
  content?: Blob | string | null;
  /** Whether it sends anything, be it nothing (POST). */
  sends?: boolean;
}

/** What carries the messages: a WebSocket, or a worker of this page. */
export interface Channel {
  readonly readyState: number;
  onopen: (() => void) | null;
  onmessage: ((event: MessageEvent<string | ArrayBuffer>) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  send(text: string): void;
}

export class Link {
  private channel: Channel | null = null;
  private worker: WorkerChannel | null = null;
  private number = 0;
  private wait = FIRST_WAIT;
  private key = sessionStorage.getItem(KEPT);
  private readonly pending = new Map<number, (answer: Answer) => void>();

  constructor(private readonly listener: LinkListener) {}

  open(): void {
    const channel = this.openChannel();
    channel.onopen = () => {
      this.wait = FIRST_WAIT;
      this.listener.setConnected(true);
    };
    channel.onmessage = (event) => this.take(event.data);
    channel.onclose = (event) => this.reconnect(event);
    this.channel = channel;
  }

  private openChannel(): Channel {
    const parts = findParts();
    if (parts === null) return openSocket(this.address("ws")) as Channel;
    this.worker = new WorkerChannel(parts);
    this.worker.onstage = (stage) => this.listener.note(stage);
    return this.worker;
  }

  /** What the studio answers to a request for a file, or with one. */
  fetch(path: string, options: FileOptions = {}): Promise<Response> {
    const { query = [], content = null, sends = false } = options;
    if (this.worker !== null) return this.worker.fetch(path, query, content, sends);
    const address = this.address(path);
    for (const [name, value] of query) address.searchParams.append(name, value);
    return fetch(address, sends ? { method: "POST", body: content } : {});
  }

  /** What the server answers; an error where nothing can be sent. */
  ask(request: Request): Promise<Answer> {
    this.number += 1;
    const id = this.number;
    if (this.channel?.readyState !== WebSocket.OPEN) {
      return Promise.resolve({ re: id, error: "The connection to the studio is lost: nothing was sent." });
    }
    this.channel.send(JSON.stringify({ id, ...request }));
    return new Promise((resolve) => this.pending.set(id, resolve));
  }

  private take(data: string | ArrayBuffer): void {
    if (typeof data !== "string") {
      this.listener.receiveFrame(data);
      return;
    }
    const message = parseMessage(data);
    if (message === null) return;
    if ("re" in message) {
      const { re } = message;
      if (re === null) return;
      this.pending.get(re)?.(message);
      this.pending.delete(re);
      return;
    }
    if (message.is === "hello") this.keep(message.key);
    this.listener.receive(message);
  }

  /** The key makes this page the director again after a lost connection, and after a reload. */
  private keep(key: string): void {
    this.key = key;
    sessionStorage.setItem(KEPT, key);
  }

  private reconnect(event: CloseEvent): void {
    this.channel = null;
    for (const [id, resolve] of this.pending) {
      resolve({ re: id, error: "The connection was lost before the answer came." });
    }
    this.pending.clear();
    this.listener.setConnected(false);
    if (event.code === REFUSED) {
      const problem =
        this.worker === null
          ? "The studio does not let this page in"
          : "The studio cannot run in this browser";
      this.listener.refuse(`${problem}: ${event.reason}`);
      return;
    }
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(this.wait * 1.6, LONGEST_WAIT);
  }

  /** Where the server's `path` is for this page, with its key. */
  private address(path: string): URL {
    const here = serverAddress(path);
    if (this.key !== null) here.searchParams.set("key", this.key);
    return here;
  }
}

/** Where the server's `path` is for this page, with the token that lets it in. */
export function serverAddress(path: string): URL {
  const here = new URL(path, document.baseURI);
  const token = new URL(location.href).searchParams.get("token");
  if (token !== null) here.searchParams.set("token", token);
  return here;
}

export function openSocket(address: URL): WebSocket {
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(address.href);
  socket.binaryType = "arraybuffer";
  return socket;
}

/** A message of the server from its text; null where this page does not know its sort. */
function parseMessage(text: string): News | Answer | null {
  const value: unknown = JSON.parse(text);
  if (typeof value !== "object" || value === null) return null;
  if ("re" in value) return value as Answer;
  if (!("is" in value)) return null;
  const types = ["hello", "scene", "session", "team"].includes(String(value.is));
  return types ? (value as News) : null;
}
