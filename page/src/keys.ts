/** The keys: what each does while no text field has the focus. */

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
  return listenTo(globalThis, { keydown: listener });
}

/** Whether the key did something here. */
function act(studio: Studio, event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : document.body;
  if (event.isComposing || target.closest(TYPES) !== null) return false;
  if (event.ctrlKey || event.metaKey) return undoes(studio, event);
  if (event.altKey || target.closest("select") !== null) return false; // letters and digits choose in it
  if (event.shiftKey && event.code.startsWith("Digit")) return chooses(studio, event);
  if (event.key in ARROWS && target.closest(OWN_ARROWS) !== null) return false;
  if ((event.key === " " || event.key === "Enter") && target.closest(OWN_SPACE) !== null) return false;
  const state = studio.session?.states.find((each) => leads(event, each));
  if (state !== undefined) {
    if (!event.repeat) void studio.press(state.name, event.timeStamp);
    return true;
  }
  return !event.repeat && commands(studio, event);
}

function leads(event: KeyboardEvent, state: State): boolean {
  if (event.key in ARROWS) return state.arrow === ARROWS[event.key];
  return event.key === state.key && state.key !== "";
}

function commands(studio: Studio, event: KeyboardEvent): boolean {
  switch (event.key) {
    case "t":
    case "T":
      void studio.ask({ do: "toggle_mode" });
      return true;
    case " ":
      void studio.ask({ do: "pause", paused: !(studio.status?.paused ?? false) });
      return true;
    case "F":
      void studio.ask({ do: "skip" });
      return true;
    case "G":
      void studio.ask({ do: "next_situation" });
      return true;
    case ".":
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
  const key = event.key.toLowerCase();
  if (key === "z") void studio.ask({ do: event.shiftKey ? "redo" : "undo" });
  else if (key === "y") void studio.ask({ do: "redo" });
  else return false;
  return true;
}

function chooses(studio: Studio, event: KeyboardEvent): boolean {
  const agent = Number(event.code.slice(5)) - 1;
  if (agent < 0 || agent >= (studio.scene?.robots ?? 0)) return false;
  void studio.ask({ do: "select_agent", agent });
  return true;
}
