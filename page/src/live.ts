/** Real robots: the page says that it is there, stops them on Escape, and lets them move while a key is held. */

import { keyboard } from "./keyboard";
import { TYPES } from "./keys";
import { listenTo } from "./listen";
import type { Studio } from "./studio";
import { makeTimer } from "./timer";

/** The place of the key that is held where robots move only while one is. */
export const HOLD = "KeyH";
const EVERY_MS = 150;

export class Live {
  holding = false;

  constructor(private readonly studio: Studio) {}

  /** Whether there are real robots. */
  get real(): boolean {
    return (this.studio.scene?.real_robots.length ?? 0) > 0;
  }

  /** Whether the world cannot be changed by hand, nor the run rewound: with real robots, or a body of one's own. */
  get fixed(): boolean {
    return this.real || !this.mapped;
  }

  /** Whether the world is shown as a map, which a body of one's own has not. */
  get mapped(): boolean {
    return (this.studio.scene?.drawing ?? "map") === "map";
  }

  /** Begin to tell the server, and to listen; what ends that. */
  begin(): () => void {
    const turn = makeTimer(() => this.tell(), EVERY_MS);
    turn(this.real);
    const stop = this.studio.news.listen(() => turn(this.real));
    const down = (event: KeyboardEvent): void => {
      if (!this.real) return;
      // In text fields, too, and besides anything else that Escape does.
      if (event.key === "Escape") {
        this.hold(false);
        if (!event.repeat) void this.studio.ask({ do: "stop" });
      }
      const typing = event.target instanceof Element && event.target.closest(`select, ${TYPES}`) !== null;
      // Beside these the system may keep to itself that the key was let go.
      if (event.ctrlKey || event.metaKey || event.altKey) this.hold(false);
      else if (keyboard.place(event) === HOLD && !typing && !event.repeat) this.hold(true);
    };
    const up = (event: KeyboardEvent): void => {
      if (keyboard.place(event) === HOLD) this.hold(false);
    };
    const away = (): void => this.hold(false);
    const ends = [
      stop,
      () => turn(false),
      listenTo(globalThis, { keydown: down, keyup: up, contextmenu: away }, { capture: true }),
      listenTo(globalThis, { blur: away }), // of the window, not of what is in it: that does not rise to the window
      listenTo(document, { visibilitychange: away }),
    ];
    return () => ends.forEach((end) => end());
  }

  /** The person holds the key or the button, or lets go. */
  hold(holding: boolean): void {
    if (holding === this.holding) return;
    this.holding = holding;
    this.tell();
    this.studio.news.tell();
  }

  private tell(): void {
    if (!this.studio.hasControl) this.holding = false; // a button that is disabled does not tell when it is let go
    if (this.real && this.studio.hasControl) void this.studio.ask({ do: "heartbeat", holding: this.holding });
  }
}
