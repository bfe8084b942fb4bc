import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { keyboard, Keyboard, placeOf, readShortcut } from "../src/keyboard";
import { nameStateKey } from "../src/keyname";
import { listenToKeys } from "../src/keys";
import type { State } from "../src/protocol";
import type { Studio } from "../src/studio";

const log: string[] = [];
let listener: (event: object) => void;

function makeState(key: string, arrow: State["arrow"] = null): State {
  return { name: `state ${key}`, key, arrow } as State;
}

beforeEach(() => {
  log.length = 0;
  vi.stubGlobal("Element", class {});
  vi.stubGlobal("document", { body: { closest: () => null } });
  vi.stubGlobal("addEventListener", (_: string, each: typeof listener) => (listener = each));
  vi.stubGlobal("removeEventListener", () => undefined);
  Object.assign(keyboard, new Keyboard());
  listenToKeys({
    session: { states: [..."0123abefmvxz"].map((key) => makeState(key, key === "1" ? "up" : null)) },
    scene: { robots: 4 },
    status: { paused: false },
    press: (name: string) => log.push(name),
    ask: ({ do: what, agent }: { do: string; agent?: number }) =>
      log.push(agent === undefined ? what : `${what} ${agent}`),
    confirm: () => log.push("confirm"),
    say: () => log.push("keys are named anew"),
  } as unknown as Studio);
});

afterEach(() => vi.unstubAllGlobals());

/** A key as browsers tell of it: "Shift+3 Digit3" types 3, at the place of Digit3. */
function send(keys: string): void {
  const [typed = "", code = ""] = keys.split(" ");
  const held = typed.split("+").slice(0, -1);
  const key = typed.split("+").at(-1) ?? "";
  listener({
    key: key === "Space" ? " " : key,
    code,
    shiftKey: held.includes("Shift"),
    ctrlKey: held.includes("Ctrl"),
    altKey: held.includes("Alt"),
    metaKey: false,
    isComposing: false,
    repeat: false,
    target: null,
    timeStamp: 0,
    getModifierState: (name: string) => held.includes(name),
    preventDefault: () => undefined,
  });
}

const PRESSES: [string, string, string][] = [
  ["QWERTY", "3 Digit3", "state 3"],
  ["QWERTY, a letter", "a KeyA", "state a"],
  ["QWERTY, the robot with this number", "Shift+# Digit3", "select_agent 2"],
  ["Caps Lock, a letter", "CapsLock+A KeyA", "state a"],
  ["Caps Lock, not the command with Shift", "CapsLock+F KeyF", "state f"],
  ["Caps Lock and Shift, the command with Shift", "CapsLock+Shift+f KeyF", "skip"],
  ["Shift, the command", "Shift+F KeyF", "skip"],
  ["Shift, no command", "Shift+A KeyA", ""],
  ["Caps Lock, a mode", "CapsLock+T KeyT", "toggle_mode"],
  ["Caps Lock, undo", "CapsLock+Ctrl+Z KeyZ", "undo"],
  ["AZERTY, without Shift", '" Digit3', "state 3"],
  ["AZERTY, with Shift", "Shift+3 Digit3", "state 3"],
  ["AZERTY in Windows, Caps Lock", "CapsLock+3 Digit3", "state 3"],
  ["AZERTY, where QWERTY has A", "q KeyA", "state a"],
  ["AZERTY, where QWERTY has M", ", KeyM", "state m"],
  ["AZERTY, undo by its letter", "Ctrl+z KeyW", "undo"],
  ["AZERTY, not undo", "Ctrl+w KeyZ", ""],
  ["AZERTY, a step", ": Period", "step"],
  ["QWERTZ, where QWERTY has Z", "y KeyZ", "state z"],
  ["QWERTZ, redo by its letter", "Ctrl+y KeyZ", "redo"],
  ["Dvorak, where QWERTY has F", "u KeyF", "state f"],
  ["Dvorak, a mode", "y KeyT", "toggle_mode"],
  ["Czech, a digit", "š Digit3", "state 3"],
  ["Russian, undo", "Ctrl+я KeyZ", "undo"],
  ["Russian, a letter", "ф KeyA", "state a"],
  ["numeric keypad", "3 Numpad3", "state 3"],
  ["numeric keypad, a step in German", ", NumpadDecimal", "step"],
  ["numeric keypad without Num Lock", "ArrowUp Numpad8", "state 1"],
  ["numeric keypad without Num Lock, not a digit", "PageDown Numpad3", ""],
  ["numeric keypad, its Enter", "Enter NumpadEnter", "confirm"],
  ["a keyboard on a screen, without places", "a ", "state a"],
  ["AltGr in Linux", "AltGraph+æ KeyA", ""],
  ["AltGr in Windows", "Ctrl+Alt+ż KeyZ", ""],
  ["a dead key", "Dead BracketLeft", ""],
  ["space", "Space Space", "pause"],
];

test.each(PRESSES)("%s: %s", (_, keys, does) => {
  send(keys);
  expect(log.join("; ")).toBe(does);
});

test("Caps Lock with Shift on AZERTY chooses no robot, as without it", () => {
  send('" Digit3');
  send('CapsLock+Shift+" Digit3');
  expect(log).toEqual(["state 3", "state 3"]);
});

test("who pressed the key of another state, as its button named it, is told, and nothing is pressed", () => {
  send("x KeyB"); // Dvorak, and the button of the state x said X
  expect(log).toEqual(["keys are named anew"]);
  expect(nameStateKey(makeState("b"))).toBe("x");
  send("x KeyB");
  expect(log).toEqual(["keys are named anew", "state b"]);
});

// the browser's map of a keyboard, or keys that were typed; then what is printed where US keyboards have these
const NAMES: [string, Record<string, string> | string[], Record<string, string>][] = [
  ["nothing known", [], { KeyA: "a", Digit3: "3", Period: "." }],
  [
    "AZERTY",
    { KeyA: "q", KeyQ: "a", KeyM: ",", Digit3: '"', Digit1: "&" },
    { KeyA: "q", KeyM: ",", Digit3: "3" },
  ],
  ["AZERTY from one key", ["a KeyQ"], { KeyA: "q", KeyZ: "w", Period: ":", Digit3: "3" }],
  ["QWERTZ from one key", ["y KeyZ"], { KeyY: "z", KeyZ: "y", KeyA: "a" }],
  ["Dvorak from one key", ["o KeyS"], { KeyT: "y", KeyH: "d", KeyA: "a" }],
  ["a letter typed with Shift", ["Shift+Q KeyA"], { KeyA: "q" }],
  ["a letter typed with Caps Lock", ["CapsLock+Q KeyA"], { KeyA: "q" }],
  ["a layout of one's own", ["x KeyA", "a KeyB"], { KeyA: "x", KeyB: "a", KeyX: "" }],
  ["another layout meanwhile", ["q KeyA", "a KeyA", "z KeyY"], { KeyA: "a", KeyZ: "y" }],
  ["Greek", { KeyA: "α", Digit1: "1" }, { KeyA: "α" }],
];

test.each(NAMES)("names: %s", async (_, source, names) => {
  if (Array.isArray(source)) source.forEach(send);
  else {
    const getLayoutMap = () => Promise.resolve(new Map(Object.entries(source)));
    vi.stubGlobal("navigator", { keyboard: { getLayoutMap } });
    await keyboard.ask();
  }
  for (const [place, name] of Object.entries(names))
    expect([place, keyboard.name(place)]).toEqual([place, name]);
});

test("a browser that refuses to tell leaves US names", async () => {
  vi.stubGlobal("navigator", { keyboard: { getLayoutMap: () => Promise.reject(new Error("not allowed")) } });
  await keyboard.ask();
  expect(keyboard.name("KeyA")).toBe("a");
});

test("arrows are named before other keys, and a state without a key has no name", () => {
  expect(nameStateKey(makeState("1", "up"))).toBe("↑");
  expect(nameStateKey(makeState(""))).toBe("");
});

test("every key that the server assigns has a place of its own", () => {
  const keys = [..."0123456789abefgijkmovxz"];
  expect(new Set(keys.map(placeOf)).size).toBe(keys.length);
  expect(readShortcut({ key: "Z", code: "KeyW", shiftKey: true })).toBe("z");
});
