/** Files in the storage of this browser: all that changed is written in one transaction, on the disk when that ends. */

import { listChanges, restoreFiles, type FileChunk, type FileSystem, type Mark } from "./filechanges";

const DATABASE = "understudy";
const CHUNKS = "chunks";
const REACHES_DISK: IDBTransactionOptions = { durability: "strict" };

export class Keeper {
  /** The files as they were kept last. */
  private marks: ReadonlyMap<string, Mark> = new Map();
  /** Only one transaction at a time, so that they end in the order in which files changed. */
  private last: Promise<unknown> = Promise.resolve();

  private constructor(
    private readonly database: IDBDatabase,
    private readonly files: FileSystem,
    private readonly root: string,
  ) {}

  static async open(files: FileSystem, root: string): Promise<Keeper> {
    const opening = indexedDB.open(DATABASE, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore(CHUNKS, { keyPath: ["path", "chunk"] });
    return new Keeper(await finish(opening), files, root);
  }

  /** Put all files back where they were. */
  async restore(): Promise<void> {
    const store = this.database.transaction(CHUNKS).objectStore(CHUNKS);
    this.marks = restoreFiles(this.files, await finish(store.getAll() as IDBRequest<FileChunk[]>));
  }

  /** Keep what changed since the last time, and forget what is gone; an error if the storage cannot take it. */
  keep(): Promise<void> {
    const writing = this.last.then(() => this.write());
    this.last = writing.catch(() => undefined);
    return writing;
  }

  private async write(): Promise<void> {
    const { chunks, ends, marks } = listChanges(this.files, this.root, this.marks);
    if (ends.size === 0) return;
    const writing = this.database.transaction(CHUNKS, "readwrite", REACHES_DISK);
    const store = writing.objectStore(CHUNKS);
    for (const chunk of chunks) store.put(chunk);
    for (const [path, end] of ends) store.delete(IDBKeyRange.bound([path, end], [path, Infinity]));
    await new Promise<void>((resolve, reject) => {
      writing.oncomplete = () => resolve();
      writing.onabort = () => reject(writing.error ?? new Error("the storage was closed"));
    });
    this.marks = marks;
  }
}

function finish<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error("the storage did not answer"));
  });
}
