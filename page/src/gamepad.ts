/** A gamepad: what each of its buttons does. The browser tells of one once a button of it was pressed. */

import { listenTo } from "./listen";
import { News } from "./news";
import type { Arrow } from "./protocol";
import type { Studio } from "./studio";

/** What is held down, or leaned to, at one moment; numbered as the standard layout is. */
export interface PadInput {
  buttons: ReadonlySet<number>;
  way: Arrow | null;
}

export type PadAction = Arrow | "confirm" | "pause" | "toggle_mode" | "undo" | "stop";

const ACTS: Readonly<Record<number, PadAction>> = {
  0: "confirm",
  1: "undo",
  2: "stop",
  3: "toggle_mode",
  9: "pause",
};
/** The directional pad. */
export const PADS: Readonly<Record<number, Arrow>> = { 12: "up", 13: "down", 14: "left", 15: "right" };
/** How far the stick is to lean before it counts, and back before it counts again. */
const LEANS = 0.6;
const RESTS = 0.4;
const NOTHING: PadInput = { buttons: new Set(), way: null };

export function listPressed(buttons: Gamepad["buttons"]): number[] {
  return buttons.flatMap(({ pressed }, index) => (pressed ? [index] : []));
}

/** What is held now; a stick that leans already may lean a little less. */
export function readInput(pad: Pick<Gamepad, "axes" | "buttons">, before: PadInput): PadInput {
  const pressed = listPressed(pad.buttons);
  const [x = 0, y = 0] = pad.axes;
  const cross = pressed.map((index) => PADS[index]).find((way) => way !== undefined);
  return { buttons: new Set(pressed), way: cross ?? readArrow(x, y, before.way) };
}

/** What to do, now that this is held: each press counts once. */
export function listActions(before: PadInput, now: PadInput): PadAction[] {
  const begun = [...now.buttons].filter((index) => !before.buttons.has(index));
  const actions = begun.map((index) => ACTS[index]).filter((act) => act !== undefined);
  return now.way !== null && now.way !== before.way ? [now.way, ...actions] : actions;
}

function readArrow(x: number, y: number, before: Arrow | null): Arrow | null {
  if (Math.hypot(x, y) < (before === null ? LEANS : RESTS)) return null;
  if (Math.abs(x) > Math.abs(y)) return x > 0 ? "right" : "left";
  return y > 0 ? "down" : "up";
}

/** The first gamepad that is connected, looked at once for each picture the browser draws. */
export class Pad {
  readonly news = new News();
  connected = false;
  private before: PadInput = NOTHING;
  private timer = 0;

  constructor(private readonly studio: Studio) {}

  listen(): () => void {
    const look = (): void => {
      this.timer = requestAnimationFrame(look);
      this.look();
    };
    const come = (): void => {
      if (this.timer === 0) look();
    };
    const stop = listenTo(globalThis, { gamepadconnected: come });
    if (navigator.getGamepads?.().some((pad) => pad !== null)) come();
    return () => {
      stop();
      this.rest();
    };
  }

  private look(): void {
    const pad = navigator.getGamepads().find((each) => each !== null);
    if (this.connected !== (pad !== undefined)) {
      this.connected = pad !== undefined;
      this.news.tell();
    }
    if (pad === undefined) return this.rest();
    const now = readInput(pad, this.before);
    const actions = listActions(this.before, now);
    this.before = now;
    for (const act of actions) this.act(act);
  }

  private rest(): void {
    cancelAnimationFrame(this.timer);
    this.timer = 0;
    this.before = NOTHING;
  }

  private act(act: PadAction): void {
    const { studio } = this;
    if (studio.session === null || !studio.hasControl) return;
    if (act === "confirm") void studio.confirm(performance.now());
    else if (act === "pause") void studio.ask({ do: "pause", paused: !(studio.status?.paused ?? false) });
    else if (act === "toggle_mode" || act === "undo") void studio.ask({ do: act });
    else {
      const state = studio.session.states.find(({ arrow, flag }) => (act === "stop" ? flag : arrow === act));
      if (state !== undefined) void studio.press(state.name, performance.now());
    }
  }
}
