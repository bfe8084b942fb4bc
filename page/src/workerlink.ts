/** The studio in a worker of this page, behind what a WebSocket offers. */

import type { Channel } from "./link";
import type { FileReply, FromWorker, ToWorker } from "./workermessages";

/** The name of the <meta> that says where the parts are of a page without a server. */
const PARTS = "understudy-parts";
const WORLD = "world";
const REFUSED = 4403;

/** The folder of the parts if this page needs no server, else null. */
export function findParts(): string | null {
  const meta = document.querySelector<HTMLMetaElement>(`meta[name=${PARTS}]`);
  return meta === null ? null : new URL(meta.content, document.baseURI).href;
}

export class WorkerChannel implements Channel {
  readyState: number = WebSocket.CONNECTING;
  onopen: (() => void) | null = null;
  onmessage: ((event: MessageEvent<string | ArrayBuffer>) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  /** How far the start is. */
  onstage: ((stage: string) => void) | null = null;
  private readonly worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
  private readonly files = new Map<number, (reply: FileReply) => void>();
  private number = 0;

  constructor(parts: string) {
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => this.take(event);
    this.worker.onerror = (event) => this.fail(event.message);
    const world = new URL(location.href).searchParams.get(WORLD) ?? "forage";
    this.post({ parts, world });
  }

  send(text: string): void {
    this.post(text);
  }

  /** What the studio answers to a request for a file, or with one. */
  async fetch(
    path: string,
    query: readonly (readonly [string, string])[],
    content: Blob | string | null,
    sends: boolean,
  ): Promise<Response> {
    this.number += 1;
    const file = this.number;
    const bytes = await new Blob(content === null ? [] : [content]).arrayBuffer();
    const reply = await new Promise<FileReply>((resolve) => {
      this.files.set(file, resolve);
      this.post({ file, path: `/${path}`, sends, query, content: bytes });
    });
    return new Response(reply.content, { status: reply.status, headers: reply.headers });
  }

  private post(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  private take(event: MessageEvent<FromWorker>): void {
    const { data } = event;
    if (typeof data === "string" || data instanceof ArrayBuffer) {
      this.onmessage?.(event as MessageEvent<string | ArrayBuffer>);
    } else if ("file" in data) {
      this.files.get(data.file)?.(data);
      this.files.delete(data.file);
    } else if ("stage" in data) this.onstage?.(data.stage);
    else if ("failed" in data) this.fail(data.failed);
    else if ("reload" in data)
      location.reload(); // the other tab is closed, and what it kept is to be read
    else {
      this.readyState = WebSocket.OPEN;
      this.onopen?.();
    }
  }

  private fail(reason: string): void {
    this.readyState = WebSocket.CLOSED;
    this.worker.terminate();
    this.onclose?.(new CloseEvent("close", { code: REFUSED, reason }));
  }
}
