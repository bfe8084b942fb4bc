import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Live } from "../src/live";
import { News } from "../src/news";
import type { Request } from "../src/protocol";
import type { Studio } from "../src/studio";

/** What a key does in a window without anything else. */
class Field extends EventTarget {
  constructor(private readonly tag: string) {
    super();
  }
  closest(selector: string): Field | null {
    return selector.split(/,\s*/).some((each) => each.split(":")[0] === this.tag) ? this : null;
  }
}

const asked: Request[] = [];
let hasControl = true;
let real: string[];
let news: News;
let live: Live;
let end: () => void;
let page: EventTarget;

beforeEach(() => {
  vi.useFakeTimers();
  asked.length = 0;
  hasControl = true;
  real = ["rover"];
  news = new News();
  page = new EventTarget();
  vi.stubGlobal("Element", Field);
  vi.stubGlobal("document", new EventTarget());
  vi.stubGlobal("addEventListener", page.addEventListener.bind(page));
  vi.stubGlobal("removeEventListener", page.removeEventListener.bind(page));
  live = new Live({
    get scene() {
      return { real_robots: real };
    },
    get hasControl() {
      return hasControl;
    },
    ask: (request: Request) => {
      asked.push(request);
      return Promise.resolve({ re: 1 });
    },
    news,
  } as unknown as Studio);
  end = live.begin();
});

afterEach(() => {
  end();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

function key(type: "keydown" | "keyup", name: string, more: object = {}): void {
  const event = new Event(type);
  Object.defineProperty(event, "target", { value: new Field("body") });
  page.dispatchEvent(Object.assign(event, { key: name, ...more }));
}

test("an element that loses the focus does not let go", () => {
  const captured: string[] = [];
  vi.stubGlobal("addEventListener", (type: string, _: unknown, options?: AddEventListenerOptions) => {
    if (options?.capture === true) captured.push(type);
  });
  live.begin()();
  expect(captured).toContain("keydown");
  expect(captured).not.toContain("blur"); // which does not rise to the window, but is captured there on its way down
});

test("it moves while the key is held, and the studio is told all the while", () => {
  key("keydown", "h");
  vi.advanceTimersByTime(300);
  key("keyup", "h");
  expect(asked.map((each) => "holding" in each && each.holding)).toEqual([true, true, true, false]);
});

test.each([
  ["Dvorak", "d", "KeyH", true],
  ["Caps Lock", "H", "KeyH", true],
  ["Dvorak, its own H", "h", "KeyJ", false],
])("the key that is held is known by its place: %s", (_, name, code, holds) => {
  key("keydown", name, { code });
  expect(live.holding).toBe(holds);
  key("keyup", name.toUpperCase(), { code });
  expect(live.holding).toBe(false);
});

const LETS_GO: [string, () => void][] = [
  ["another window", () => page.dispatchEvent(new Event("blur"))],
  ["another tab", () => document.dispatchEvent(new Event("visibilitychange"))],
  ["the menu of the right button, which takes the keys", () => page.dispatchEvent(new Event("contextmenu"))],
  ["a key beside which some systems tell of no other", () => key("keydown", "Meta", { metaKey: true })],
  ["the emergency stop", () => key("keydown", "Escape")],
  ["no longer directing", () => ((hasControl = false), vi.advanceTimersByTime(150))],
];

test.each(LETS_GO)("%s lets go, and a key that repeats holds it no more", (_, happens) => {
  key("keydown", "h");
  happens();
  key("keydown", "h", { repeat: true });
  expect(live.holding).toBe(false);
});

test.each(["input", "textarea", "select"])("who types in a field (%s) holds nothing", (tag) => {
  const event = new Event("keydown");
  Object.defineProperty(event, "target", { value: new Field(tag) });
  page.dispatchEvent(Object.assign(event, { key: "h" }));
  expect(live.holding).toBe(false);
});

test("Escape stops, wherever one types", () => {
  const event = new Event("keydown");
  Object.defineProperty(event, "target", { value: new Field("input") });
  page.dispatchEvent(Object.assign(event, { key: "Escape" }));
  expect(asked).toContainEqual({ do: "stop" });
});

test("the studio is told nothing, and no timer runs, while all robots are simulated", () => {
  real = [];
  news.tell();
  expect(vi.getTimerCount()).toBe(0);
  vi.advanceTimersByTime(300);
  expect(asked).toEqual([]);
  real = ["rover"];
  news.tell();
  vi.advanceTimersByTime(300);
  expect(asked).toEqual([
    { do: "heartbeat", holding: false },
    { do: "heartbeat", holding: false },
  ]);
});
