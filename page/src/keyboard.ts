/** The keyboard: which place on it a key has, whatever is printed there, and what is printed there. */

import { News } from "./news";

/** What of a key's event says where it is and what it types. */
export type Key = Pick<KeyboardEvent, "key" | "code" | "shiftKey"> &
  Partial<Pick<KeyboardEvent, "getModifierState">>;

/** The places of three rows, from the left, and what common keyboards type there, as in the first layout. */
const ROWS = [
  ..."QWERTYUIOP".split("").map((letter) => `Key${letter}`),
  "BracketLeft",
  "BracketRight",
  ..."ASDFGHJKL".split("").map((letter) => `Key${letter}`),
  "Semicolon",
  "Quote",
  ..."ZXCVBNM".split("").map((letter) => `Key${letter}`),
  "Comma",
  "Period",
  "Slash",
];
const LAYOUTS = [
  "qwertyuiop[]asdfghjkl;'zxcvbnm,./",
  "azertyuiop^$qsdfghjklmùwxcvbn,;:!",
  "qwertzuiopü+asdfghjklöäyxcvbnm,.-",
  "',.pyfgcrl/=aoeuidhtns-;qjkxbmwvz",
  "qwfpgjluy;[]arstdhneio'zxcvbkm,./",
];
const PLACE = /^(Key[A-Z]|Digit[0-9]|Period)$/;
const DIGIT = /^[0-9]$/;

/** The keys by their places, and their names as far as the browser tells or key events have shown them. */
export class Keyboard {
  readonly news = new News();
  private readonly names = new Map<string, string>();
  private layout: string | undefined = LAYOUTS[0];
  /** Whether digits are typed with Shift, as in France and Czechia. */
  shiftsDigits = false;

  /** Ask the browser what the keys type; where it has no such list, key events show it. */
  async ask(): Promise<void> {
    const { keyboard } = (globalThis.navigator ?? {}) as {
      keyboard?: { getLayoutMap?: () => Promise<ReadonlyMap<string, string>> };
    };
    const map = await keyboard?.getLayoutMap?.().catch(() => undefined);
    if (map === undefined || map.size === 0) return;
    this.names.clear();
    for (const [place, name] of map) this.names.set(place, name.toLocaleLowerCase());
    this.shiftsDigits = !DIGIT.test(map.get("Digit1") ?? "1");
    this.guessLayout();
  }

  /** What is printed on the key at a place, in small letters; empty where it cannot be known. */
  name(place: string): string {
    const label = this.names.get(place);
    // Where digits are typed with Shift, they are printed on the same keys.
    if (place.startsWith("Digit")) return label !== undefined && DIGIT.test(label) ? label : place.slice(5);
    if (label !== undefined) return label;
    const guess = this.layout?.[ROWS.indexOf(place)] ?? (LAYOUTS[0] as string)[ROWS.indexOf(place)] ?? "";
    return [...this.names.values()].includes(guess) ? "" : guess;
  }

  /**
   * Learn from a key what is printed on it.
   *
   * Where its name was thought to be that of another place until now, that place: who pressed it meant the other one.
   */
  learn(event: Key): string | null {
    const typed = event.key.toLocaleLowerCase();
    const place = event.code ?? "";
    if (typed.length !== 1 || isAltGraph(event)) return null;
    if (place.startsWith("Digit")) {
      if (!isCapsLocked(event)) this.shiftsDigits = DIGIT.test(typed) === event.shiftKey;
      if (!event.shiftKey) this.names.set(place, typed);
      return null;
    }
    if (!ROWS.includes(place) || (event.shiftKey && typed === event.key) || this.name(place) === typed)
      return null;
    const meant = ROWS.find((each) => this.name(each) === typed) ?? null;
    if (this.names.has(place)) {
      this.names.clear(); // another layout was chosen meanwhile
      void this.ask();
    }
    this.names.set(place, typed);
    this.guessLayout();
    return meant;
  }

  /** The place of a key, as Understudy names it: that of the same digit or sign where it is on the numeric keypad. */
  place(event: Key): string {
    const { code = "", key } = event;
    if (PLACE.test(code)) return isAltGraph(event) ? "" : code;
    if (key.length !== 1) return ""; // arrows and the like; also those of the numeric keypad
    if (/^Numpad[0-9]$/.test(code)) return `Digit${code.slice(6)}`;
    if (code === "NumpadDecimal") return "Period";
    return code === "" || code === "Unidentified" ? placeOf(key) : ""; // some keyboards on screens have no places
  }

  /** The digit of a key, with Shift only where that types it; null for any other key. */
  digit(event: Key): number | null {
    const place = this.place(event);
    if (!place.startsWith("Digit")) return null;
    const types = isCapsLocked(event) ? this.shiftsDigits : DIGIT.test(event.key);
    return event.shiftKey && !types ? null : Number(place.slice(5));
  }

  private guessLayout(): void {
    const fits = (layout: string): boolean =>
      ROWS.every((place, index) => (this.names.get(place) ?? layout[index]) === layout[index]);
    this.layout = LAYOUTS.find(fits);
    this.news.tell();
  }
}

export const keyboard = new Keyboard();

/** The place of a letter, a digit or a full stop on a US keyboard. */
export function placeOf(key: string): string {
  if (/^[a-z]$/i.test(key)) return `Key${key.toUpperCase()}`;
  if (DIGIT.test(key)) return `Digit${key}`;
  return key === "." ? "Period" : "";
}

/** The letter of a shortcut such as Ctrl Z: what the key types, and where that is no Latin letter, its place's. */
export function readShortcut({ key, code = "" }: Key): string {
  if (/^[a-z]$/i.test(key)) return key.toLowerCase();
  return code.startsWith("Key") ? code.slice(3).toLowerCase() : "";
}

function isCapsLocked(event: Key): boolean {
  return event.getModifierState?.("CapsLock") ?? false;
}

function isAltGraph(event: Key): boolean {
  return event.getModifierState?.("AltGraph") ?? false;
}
