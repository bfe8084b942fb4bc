/** The worker in which the studio runs where there is no server: Python, with the same messages as over a WebSocket. */

import type { FileSystem } from "./filechanges";
import { Keeper } from "./keeping";
import type { FileRequest, FromWorker, ToWorker } from "./workermessages";

const ROOT = "/kept";
const PACKAGES = "/packages";
const LOCK = "understudy-library";
/** How long a page that was closed or loaded again may hold its lock, ms. */
const LOCK_MS = 6000;
const KEPT =
  "This library is kept in this browser only. Export it as a zip to keep it for good, or to move it elsewhere.";
const NOT_KEPT =
  "This browser keeps nothing for this page, as in a private window: export the library as a zip before you close it.";
const CLOSED =
  "the studio is open in another tab of this browser: this tab only reads until the other is closed";
const BEGIN = `
import asyncio, sys
sys.path.insert(0, packages)
sys.dont_write_bytecode = True
from pathlib import Path
from understudy.ui.web.page_studio import PageStudio
studio = PageStudio(Path(root), post, keep, world=world, storage_note=storage_note, closed=closed)
running = asyncio.ensure_future(studio.run())
running.add_done_callback(lambda task: fail(repr(task.exception())))
async def fetch(path, sends, query, content):
    pairs = [(str(name), str(value)) for name, value in query.to_py()]
    reply = await studio.fetch(path, sends=sends, query=pairs, content=content.to_bytes())
    return tuple(reply)
`;

interface PythonValue {
  destroy(): void;
  toJs(options?: object): unknown;
}

interface Python {
  FS: FileSystem;
  globals: {
    get(
      name: string,
    ): PythonValue & { hear(text: string): void } & ((...values: unknown[]) => Promise<PythonValue>);
    set(name: string, value: unknown): void;
  };
  runPython(code: string): unknown;
  unpackArchive(content: ArrayBuffer, format: string, options: { extractDir: string }): void;
}

interface Scope {
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
}

const scope = self as unknown as Scope;
const early: ToWorker[] = [];

scope.onmessage = ({ data }) => {
  if (typeof data === "object" && "parts" in data) {
    begin(data.parts, data.world).catch((error: unknown) => scope.postMessage({ failed: describe(error) }));
  } else early.push(data);
};

async function begin(parts: string, world: string): Promise<void> {
  const at = (name: string): string => new URL(name, parts).href;
  const locked = holdLock();
  scope.postMessage({ stage: "Loading Python" });
  const app = load(at("understudy.zip"));
  app.catch(() => undefined); // said where it is awaited
  const { loadPyodide } = (await import(/* @vite-ignore */ at("pyodide.mjs"))) as {
    loadPyodide(options: object): Promise<Python>;
  };
  const env = { UNDERSTUDY_KERNELS: "python", HOME: ROOT };
  const python = await loadPyodide({ indexURL: parts, packages: ["numpy"], env });
  scope.postMessage({ stage: "Loading the studio" });
  python.FS.mkdirTree(PACKAGES);
  python.unpackArchive(await app, "zip", { extractDir: PACKAGES });
  python.FS.mkdirTree(ROOT);
  const closed = (await locked) ? "" : CLOSED;
  const keeper = await openKeeper(python.FS);
  scope.postMessage({ stage: "Beginning" });
  const values = {
    packages: PACKAGES,
    root: ROOT,
    world,
    storage_note: keeper === null ? NOT_KEPT : KEPT,
    closed,
    post,
    keep: () => keep(keeper),
    fail: (failed: string) => scope.postMessage({ failed }),
  };
  for (const [name, value] of Object.entries(values)) python.globals.set(name, value);
  python.runPython(BEGIN);
  const studio = python.globals.get("studio");
  const take = (message: ToWorker): void => {
    if (typeof message === "string") studio.hear(message);
    else if ("file" in message) void answerFile(python, message);
  };
  scope.onmessage = ({ data }) => take(data);
  scope.postMessage({ ready: true });
  early.forEach(take);
}

async function load(address: string): Promise<ArrayBuffer> {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address} cannot be loaded (${answer.status})`);
  return answer.arrayBuffer();
}

/** Hold the lock of the library until this worker ends; false if another tab has it, until which this one only reads. */
function holdLock(): Promise<boolean> {
  if (navigator.locks === undefined) return Promise.resolve(true); // as on an address without https
  return new Promise((resolve) => {
    const patience = AbortSignal.timeout(LOCK_MS);
    const held = navigator.locks.request(LOCK, { signal: patience }, () => {
      resolve(true);
      return new Promise(() => undefined);
    });
    held.catch(() => {
      resolve(false);
      void navigator.locks.request(LOCK, () => scope.postMessage({ reload: true }));
    });
  });
}

/** The files as they were kept; null where this browser keeps nothing. */
async function openKeeper(files: FileSystem): Promise<Keeper | null> {
  try {
    const keeper = await Keeper.open(files, ROOT);
    await keeper.restore();
    return keeper;
  } catch {
    return null;
  }
}

/** Keep all files; return why that failed, else an empty text. */
async function keep(keeper: Keeper | null): Promise<string> {
  try {
    await keeper?.keep();
    return "";
  } catch (error) {
    return `this browser cannot keep it (${describe(error)}): export the library as a zip, and make room`;
  }
}

/** Post what the studio says: a text, or the bytes of a frame. */
function post(content: string | PythonValue): void {
  if (typeof content === "string") {
    scope.postMessage(content);
    return;
  }
  const { buffer } = content.toJs() as Uint8Array<ArrayBuffer>;
  scope.postMessage(buffer, [buffer]);
}

async function answerFile(python: Python, request: FileRequest): Promise<void> {
  const { file, path, sends, query, content } = request;
  const fetchFile = python.globals.get("fetch");
  const reply = await fetchFile(path, sends, query, new Uint8Array(content));
  const [status, headers, bytes] = reply.toJs({ dict_converter: Object.fromEntries }) as [
    number,
    Record<string, string>,
    Uint8Array<ArrayBuffer>,
  ];
  reply.destroy();
  scope.postMessage({ file, status, headers, content: bytes.buffer }, [bytes.buffer]);
}

function describe(error: unknown): string {
  if (!(error instanceof Error)) return String(error);
  const lines = error.message.trim().split("\n");
  return lines.at(-1) ?? error.name;
}
