import { expect, test } from "vitest";
import {
  CHUNK,
  listChanges,
  restoreFiles,
  type FileChanges,
  type FileChunk,
  type FileSystem,
} from "../src/filechanges";

const ROOT = "/kept";

/** Files in memory, as Emscripten has them: a file that is made anew has another number. */
class Memory implements FileSystem {
  files = new Map<string, { ino: number; content: Uint8Array; changed: number }>();
  now = 0;
  private inodes = 0;

  readdir(folder: string): string[] {
    const inside = [...this.files.keys()].filter((path) => path.startsWith(`${folder}/`));
    return [".", "..", ...new Set(inside.map((path) => path.slice(folder.length + 1).split("/")[0] ?? ""))];
  }

  stat(path: string) {
    const file = this.files.get(path);
    const { ino, content, changed } = file ?? { ino: 0, content: new Uint8Array(), changed: 0 };
    return { ino, size: content.length, mtime: new Date(changed), mode: file === undefined ? 1 : 0 };
  }

  isDir = (mode: number): boolean => mode === 1;
  open = (path: string) => ({ fd: 0, path });
  close = (): void => undefined;
  mkdirTree = (): void => undefined;

  read(stream: { fd: number }, buffer: Uint8Array, offset: number, length: number, position: number): number {
    const file = this.files.get((stream as { path: string } & typeof stream).path);
    buffer.set(file?.content.subarray(position, position + length) ?? [], offset);
    return length;
  }

  writeFile(path: string, content: Uint8Array): void {
    this.files.set(path, { ino: (this.inodes += 1), content, changed: this.now });
  }

  append(path: string, size: number): void {
    const file = this.files.get(path);
    if (file === undefined) return this.writeFile(path, make(size));
    file.content = new Uint8Array([...file.content, ...make(size)]);
    file.changed = this.now;
  }

  cut(path: string, size: number): void {
    const file = this.files.get(path);
    if (file === undefined) return;
    file.content = file.content.slice(0, size);
    file.changed = this.now;
  }

  utime(path: string, _: number, changed: number): void {
    const file = this.files.get(path);
    if (file !== undefined) file.changed = changed;
  }
}

let filler = 0;

function make(size: number): Uint8Array {
  filler += 1;
  return new Uint8Array(size).fill(filler % 251);
}

/** What is kept, as a store would have it. */
class Kept {
  chunks: FileChunk[] = [];
  changes: FileChanges = { chunks: [], ends: new Map(), marks: new Map() };

  keep(files: Memory): void {
    this.changes = listChanges(files, ROOT, this.changes.marks);
    const { chunks, ends } = this.changes;
    const isOld = ({ path, chunk }: FileChunk) =>
      chunks.some((each) => each.path === path && each.chunk === chunk) ||
      chunk >= (ends.get(path) ?? Infinity);
    this.chunks = [...this.chunks.filter((each) => !isOld(each)), ...chunks];
    this.chunks.sort((one, other) => one.path.localeCompare(other.path) || one.chunk - other.chunk);
  }

  restore(): Map<string, string> {
    const files = new Memory();
    restoreFiles(files, this.chunks);
    return contents(files);
  }
}

function contents(files: Memory): Map<string, string> {
  return new Map(
    [...files.files].map(([path, { content, changed }]) => [path, `${changed} ${content.join()}`]),
  );
}

const JOURNAL = `${ROOT}/library/.journals/goto.journal`;
const DOCUMENT = `${ROOT}/library/goto.json`;
const CASES: readonly (readonly [string, (files: Memory) => void, readonly string[]])[] = [
  ["nothing", () => undefined, []],
  ["a press", (files) => files.append(JOURNAL, 10), [`${JOURNAL} 2`]],
  ["a long stretch", (files) => files.append(JOURNAL, CHUNK), [`${JOURNAL} 2`, `${JOURNAL} 3`]],
  [
    "a journal that was recovered",
    (files) => files.cut(JOURNAL, CHUNK + 1),
    [`${JOURNAL} 0`, `${JOURNAL} 1`],
  ],
  ["a document that was saved", (files) => files.writeFile(DOCUMENT, make(CHUNK)), [`${DOCUMENT} 0`]],
  ["a document that was changed in place", (files) => files.cut(DOCUMENT, 5), [`${DOCUMENT} 0`]],
  ["a file that is gone", (files) => files.files.delete(DOCUMENT), []],
  ["an empty file", (files) => files.writeFile(`${ROOT}/new`, make(0)), [`${ROOT}/new 0`]],
];

test.each(CASES)("%s", (_, change, written) => {
  const [files, kept] = [new Memory(), new Kept()];
  files.append(JOURNAL, 2 * CHUNK + 7);
  files.writeFile(DOCUMENT, make(CHUNK + 3));
  kept.keep(files);
  files.now += 1;
  change(files);
  kept.keep(files);
  expect(kept.changes.chunks.map(({ path, chunk }) => `${path} ${chunk}`)).toEqual(written);
  expect(kept.restore()).toEqual(contents(files));
});

test("a journal that was put back is written anew, since a torn end may be cut before it grows", () => {
  const [files, kept] = [new Memory(), new Kept()];
  files.append(JOURNAL, 2 * CHUNK + 7);
  kept.keep(files);
  const again = new Memory();
  const marks = restoreFiles(again, kept.chunks);
  kept.changes = { chunks: [], ends: new Map(), marks };
  kept.keep(again);
  expect(kept.changes.chunks).toEqual([]);
  again.cut(JOURNAL, CHUNK - 3);
  again.append(JOURNAL, 2 * CHUNK);
  again.now += 1;
  kept.keep(again);
  expect(kept.restore()).toEqual(contents(again));
});

test("whatever happens, what is kept is what is there", () => {
  let random = 7;
  const draw = (below: number): number => (random = (random * 48271) % 2147483647) % below;
  const [files, kept] = [new Memory(), new Kept()];
  for (let step = 0; step < 200; step += 1) {
    files.now += draw(2);
    const path = [JOURNAL, DOCUMENT, `${ROOT}/b.journal`][draw(3)] ?? "";
    const [what, size] = [draw(6), draw(3) * CHUNK + draw(3) * 5];
    if (what === 0) files.files.delete(path);
    else if (what === 1) files.writeFile(path, make(size));
    else if (what === 2 && path !== DOCUMENT && size < files.stat(path).size) {
      kept.keep(files); // a journal is cut before anything is added to it
      files.now += 1;
      files.cut(path, size);
    } else if (path !== DOCUMENT && draw(3) > 0) files.append(path, 1 + size);
    if (draw(2) === 0) kept.keep(files);
  }
  kept.keep(files);
  expect(kept.restore()).toEqual(contents(files));
});
