/** What changed of files since they were kept last, in chunks: a journal that grew costs only its last ones. */

/** Bytes of a chunk. */
export const CHUNK = 32 * 1024;
/** Files to which bytes are only appended, or which are written again as a whole. */
const GROWING = /\.journal$/;

export interface FileChunk {
  path: string;
  /** Which one of the file, from 0. */
  chunk: number;
  content: Uint8Array;
  /** When the file was changed, ms. */
  changed: number;
}

interface Stream {
  readonly fd: number;
}

/** The file system of the worker, as far as files are kept from it. */
export interface FileSystem {
  readdir(path: string): string[];
  stat(path: string): { ino: number; mode: number; size: number; mtime: Date };
  isDir(mode: number): boolean;
  open(path: string, flags: string): Stream;
  read(stream: Stream, buffer: Uint8Array, offset: number, length: number, position: number): number;
  close(stream: Stream): void;
  writeFile(path: string, content: Uint8Array): void;
  mkdirTree(path: string): void;
  utime(path: string, accessed: number, changed: number): void;
}

/** What tells whether a file has changed. */
export interface Mark {
  ino: number;
  size: number;
  changed: number;
  /** Whether it was put back: a journal may then lose a torn end before it grows. */
  isRestored?: boolean;
}

export interface FileChanges {
  chunks: readonly FileChunk[];
  /** Of a file, the first chunk that it no longer has. */
  ends: ReadonlyMap<string, number>;
  /** The marks of all files that are there. */
  marks: ReadonlyMap<string, Mark>;
}

/** List what changed in a folder since these marks were taken. */
export function listChanges(files: FileSystem, root: string, before: ReadonlyMap<string, Mark>): FileChanges {
  const chunks: FileChunk[] = [];
  const ends = new Map<string, number>();
  const marks = new Map<string, Mark>();
  for (const path of listFiles(files, root)) {
    const mark = readMark(files, path);
    const last = before.get(path);
    if (last !== undefined && isSame(last, mark)) {
      marks.set(path, last);
      continue;
    }
    marks.set(path, mark);
    const first = last !== undefined && hasGrown(path, last, mark) ? Math.floor(last.size / CHUNK) : 0;
    chunks.push(...readChunks(files, path, mark, first));
    ends.set(path, Math.max(1, Math.ceil(mark.size / CHUNK)));
  }
  for (const path of before.keys()) if (!marks.has(path)) ends.set(path, 0);
  return { chunks, ends, marks };
}

/** Put all files back where they were, and return their marks; the chunks of a file come in their order. */
export function restoreFiles(files: FileSystem, chunks: readonly FileChunk[]): Map<string, Mark> {
  const marks = new Map<string, Mark>();
  const contents = new Map<string, FileChunk[]>();
  for (const chunk of chunks) contents.set(chunk.path, [...(contents.get(chunk.path) ?? []), chunk]);
  for (const [path, parts] of contents) {
    const content = new Uint8Array(parts.reduce((sum, part) => sum + part.content.length, 0));
    let end = 0;
    for (const part of parts) {
      content.set(part.content, end);
      end += part.content.length;
    }
    const changed = Math.max(...parts.map((part) => part.changed));
    files.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    files.writeFile(path, content);
    files.utime(path, changed, changed);
    marks.set(path, { ...readMark(files, path), isRestored: true });
  }
  return marks;
}

function readMark(files: FileSystem, path: string): Mark {
  const { ino, size, mtime } = files.stat(path);
  return { ino, size, changed: mtime.getTime() };
}

function isSame(one: Mark, other: Mark): boolean {
  return one.ino === other.ino && one.size === other.size && one.changed === other.changed;
}

/** Whether a file is a journal to which something was only added. */
function hasGrown(path: string, before: Mark, now: Mark): boolean {
  return (
    GROWING.test(path) && before.isRestored !== true && before.ino === now.ino && before.size <= now.size
  );
}

/** The chunks of a file from one on; an empty file has an empty one. */
function readChunks(files: FileSystem, path: string, mark: Mark, first: number): FileChunk[] {
  const stream = files.open(path, "r");
  const chunks: FileChunk[] = [];
  const { changed, size } = mark;
  for (let chunk = first; chunk === 0 || chunk * CHUNK < size; chunk += 1) {
    const content = new Uint8Array(Math.min(CHUNK, size - chunk * CHUNK));
    files.read(stream, content, 0, content.length, chunk * CHUNK);
    chunks.push({ path, chunk, content, changed });
  }
  files.close(stream);
  return chunks;
}

function* listFiles(files: FileSystem, folder: string): Generator<string> {
  for (const name of files.readdir(folder)) {
    if (name === "." || name === "..") continue;
    const path = `${folder}/${name}`;
    if (files.isDir(files.stat(path).mode)) yield* listFiles(files, path);
    else yield path;
  }
}
