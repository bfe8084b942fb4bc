/** The keys: what each does, by its place on the keyboard, while no text field has the focus. */

import { keyboard, placeOf, readShortcut } from "./keyboard";
import { listenTo } from "./listen";
import type { Arrow, State } from "./protocol";
import type { Studio } from "./studio";

export const ARROWS: Readonly<Record<string, Arrow>> = {
  ArrowUp: "up",
  ArrowDown: "down",
  ArrowLeft: "left",
  ArrowRight: "right",
};
/** Where letters are typed. */
export const TYPES = "input:not([type=checkbox]):not([type=radio]), textarea, [contenteditable]";
const OWN_SPACE = "button, a, summary, input, [role=button], [role=tab], [tabindex='0']:not(canvas)";
const OWN_ARROWS = "[role=tablist], [role=radiogroup], input";

export function listenToKeys(studio: Studio): () => void {
  const listener = (event: KeyboardEvent): void => {
    if (act(studio, event)) event.preventDefault();
  };
  void keyboard.ask();
  return listenTo(globalThis, { keydown: listener });
}

/** Whether the key did something here. */
function act(studio: Studio, event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : document.body;
  if (event.isComposing) return false;
  const meant = keyboard.learn(event);
  if (target.closest(TYPES) !== null) return false;
  if (event.ctrlKey || event.metaKey) return !event.altKey && undoes(studio, event); // with Alt: AltGr in Windows
  if (event.altKey || target.closest("select") !== null) return false; // letters and digits choose in it
  const place = keyboard.place(event);
  if (event.shiftKey && place.startsWith("Digit") && keyboard.digit(event) === null)
    return chooses(studio, place);
  if (event.key in ARROWS && target.closest(OWN_ARROWS) !== null) return false;
  if ((event.key === " " || event.key === "Enter") && target.closest(OWN_SPACE) !== null) return false;
  const state = studio.session?.states.find((each) => leads(event, place, each));
  if (state !== undefined) {
    if (studio.session?.states.some(({ key }) => meant !== null && placeOf(key) === meant))
      return renames(studio, event);
    if (!event.repeat) void studio.press(state.name, event.timeStamp);
    return true;
  }
  return !event.repeat && commands(studio, event, place);
}

function leads(event: KeyboardEvent, place: string, state: State): boolean {
  if (event.key in ARROWS) return state.arrow === ARROWS[event.key];
  if (event.shiftKey && !place.startsWith("Digit")) return false;
  return place !== "" && place === placeOf(state.key);
}

/** Say that the keys of the buttons were not those of this keyboard: the key that was pressed is another's by its place. */
function renames(studio: Studio, { key }: KeyboardEvent): boolean {
  const text = `On this keyboard ${key.toUpperCase()} is at another place than the buttons said. They name the keys anew: press again.`;
  studio.say({ text, tone: "error" });
  return true;
}

function commands(studio: Studio, event: KeyboardEvent, place: string): boolean {
  switch (place === "" ? event.key : (event.shiftKey ? "Shift" : "") + place) {
    case "KeyT":
    case "ShiftKeyT":
      void studio.ask({ do: "toggle_mode" });
      return true;
    case " ":
      void studio.ask({ do: "pause", paused: !(studio.status?.paused ?? false) });
      return true;
    case "ShiftKeyF":
      void studio.ask({ do: "skip" });
      return true;
    case "ShiftKeyG":
      void studio.ask({ do: "next_situation" });
      return true;
    case "Period":
      void studio.ask({ do: "step" });
      return true;
    case "Enter":
      void studio.confirm(event.timeStamp);
      return true;
    default:
      return false;
  }
}

function undoes(studio: Studio, event: KeyboardEvent): boolean {
  const letter = readShortcut(event);
  if (letter === "z") void studio.ask({ do: event.shiftKey ? "redo" : "undo" });
  else if (letter === "y") void studio.ask({ do: "redo" });
  else return false;
  return true;
}

function chooses(studio: Studio, place: string): boolean {
  const agent = Number(place.slice(5)) - 1;
  if (agent < 0 || agent >= (studio.scene?.robots ?? 0)) return false;
  void studio.ask({ do: "select_agent", agent });
  return true;
}
