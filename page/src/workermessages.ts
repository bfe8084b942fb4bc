/** What the page and the worker in which its studio runs say to each other, beside the messages of the studio. */

/** The first message of the page: where the parts are, and the world at the first time. */
export interface Begin {
  parts: string;
  world: string;
}

/** A request for a file, or with one. */
export interface FileRequest {
  file: number;
  path: string;
  sends: boolean;
  query: readonly (readonly [string, string])[];
  content: ArrayBuffer;
}

export interface FileReply {
  file: number;
  status: number;
  headers: Readonly<Record<string, string>>;
  content: ArrayBuffer;
}

/** A message of the studio is text; its requests for files are objects. */
export type ToWorker = Begin | FileRequest | string;

/** Messages of the studio are text, and frames in binary; beside them, how far the start is, or why there is none. */
export type FromWorker =
  | string
  | ArrayBuffer
  | FileReply
  | { stage: string }
  | { ready: true }
  | { reload: true }
  | { failed: string };
