/** Files in the storage of this browser: all that changed is written in one transaction, on the disk when that ends. */

const DATABASE = "understudy";
const FILES = "files";
const REACHES_DISK: IDBTransactionOptions = { durability: "strict" };

export interface FileRecord {
  path: string;
  content: Uint8Array;
  changed: number;
}

/** The file system of the worker, as far as files are kept from it. */
export interface FileSystem {
  readdir(path: string): string[];
  stat(path: string): { ino: number; mode: number; size: number; mtime: Date };
  isDir(mode: number): boolean;
  readFile(path: string): Uint8Array;
  writeFile(path: string, content: Uint8Array): void;
  mkdirTree(path: string): void;
  utime(path: string, accessed: number, changed: number): void;
}

export class Keeper {
  /** Of each file that is kept, what tells whether it has changed since. */
  private readonly marks = new Map<string, string>();
  /** Only one transaction at a time, so that they end in the order in which files changed. */
  private last: Promise<unknown> = Promise.resolve();

  private constructor(
    private readonly database: IDBDatabase,
    private readonly files: FileSystem,
    private readonly root: string,
  ) {}

  static async open(files: FileSystem, root: string): Promise<Keeper> {
    const opening = indexedDB.open(DATABASE, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore(FILES, { keyPath: "path" });
    return new Keeper(await finish(opening), files, root);
  }

  /** Put all files back where they were. */
  async restore(): Promise<void> {
    const store = this.database.transaction(FILES).objectStore(FILES);
    for (const { path, content, changed } of await finish(store.getAll() as IDBRequest<FileRecord[]>)) {
      this.files.mkdirTree(path.slice(0, path.lastIndexOf("/")));
      this.files.writeFile(path, content);
      this.files.utime(path, changed, changed);
      this.marks.set(path, this.mark(path));
    }
  }

  /** Keep what changed since the last time, and forget what is gone; an error if the storage cannot take it. */
  keep(): Promise<void> {
    const writing = this.last.then(() => this.write());
    this.last = writing.catch(() => undefined);
    return writing;
  }

  private async write(): Promise<void> {
    const present = new Set(this.list(this.root));
    const changed = [...present].filter((path) => this.mark(path) !== this.marks.get(path));
    const gone = [...this.marks.keys()].filter((path) => !present.has(path));
    if (changed.length + gone.length === 0) return;
    const marks = changed.map((path) => [path, this.mark(path)] as const);
    const writing = this.database.transaction(FILES, "readwrite", REACHES_DISK);
    const store = writing.objectStore(FILES);
    for (const path of changed) {
      const file: FileRecord = {
        path,
        content: this.files.readFile(path),
        changed: this.files.stat(path).mtime.getTime(),
      };
      store.put(file);
    }
    for (const path of gone) store.delete(path);
    await new Promise<void>((resolve, reject) => {
      writing.oncomplete = () => resolve();
      writing.onabort = () => reject(writing.error ?? new Error("the storage was closed"));
    });
    for (const [path, mark] of marks) this.marks.set(path, mark);
    for (const path of gone) this.marks.delete(path);
  }

  private mark(path: string): string {
    const { ino, size, mtime } = this.files.stat(path);
    return `${ino} ${size} ${mtime.getTime()}`;
  }

  private *list(folder: string): Generator<string> {
    for (const name of this.files.readdir(folder)) {
      if (name === "." || name === "..") continue;
      const path = `${folder}/${name}`;
      if (this.files.isDir(this.files.stat(path).mode)) yield* this.list(path);
      else yield path;
    }
  }
}

function finish<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error("the storage did not answer"));
  });
}
