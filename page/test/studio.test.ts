import { beforeAll, expect, test, vi } from "vitest";
import type { SessionNews } from "../src/protocol";
import type { Studio } from "../src/studio";

let made: Studio;

beforeAll(async () => {
  vi.stubGlobal("sessionStorage", { getItem: () => null, setItem: () => undefined });
  made = new (await import("../src/studio")).Studio();
});

function news(change: object): SessionNews {
  const message = { text: "World 3, restarted", tone: "" };
  const run = { number: 1, from_s: 0 };
  return {
    is: "session",
    session: null,
    message,
    message_number: 1,
    run,
    has_control: true,
    ...change,
  } as SessionNews;
}

/** A frame without robots, objects or features. */
function frame(): ArrayBuffer {
  const buffer = new ArrayBuffer(24 + 2 + 4);
  new DataView(buffer).setUint8(0, 1);
  return buffer;
}

test("an error goes with the next message, also where it says the same as the last", () => {
  made.receive(news({}));
  made.say({ text: "The seed abc is none", tone: "error" });
  made.receive(news({}));
  expect(made.notice.tone).toBe("error"); // nothing was said meanwhile
  made.receive(news({ message_number: 2 }));
  expect(made.notice).toEqual({ text: "World 3, restarted", tone: "" });
});

test("what is known of the world before does not count for the next", () => {
  made.receive(news({}));
  made.receiveFrame(frame());
  expect(made.current).toBe(true);
  made.receive(news({ run: { number: 2, from_s: 0 } }));
  expect(made.current).toBe(false);
  made.receiveFrame(frame());
  expect(made.current).toBe(true);
});
