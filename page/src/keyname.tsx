/** The name of a key, as on the reader's keyboard. */

import { keyboard, placeOf } from "./keyboard";
import { useNews } from "./news";
import type { Arrow } from "./protocol";

const ARROWS: Readonly<Record<Arrow, string>> = { up: "↑", down: "↓", left: "←", right: "→" };

/** The key of a command. */
export function KeyName({ place, shift = false }: { place: string; shift?: boolean }) {
  useNews(keyboard.news);
  const name = keyboard.name(place).toLocaleUpperCase();
  return name === "" ? null : <kbd>{(shift ? "⇧" : "") + name}</kbd>;
}

/** The name of a state's key; a component that shows it listens to the keyboard's news. */
export function nameStateKey({ key, arrow }: { key: string; arrow: Arrow | null }): string {
  return arrow === null ? keyboard.name(placeOf(key)) : ARROWS[arrow];
}
