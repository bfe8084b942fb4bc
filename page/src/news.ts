/** A value that changes, and its listeners. */

import { useLayoutEffect, useReducer } from "preact/hooks";
import { Redraw } from "./redraw";

export class News {
  private readonly listeners = new Set<() => void>();

  tell(): void {
    for (const listener of this.listeners) listener();
  }

  listen(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/**
 * Draw the component again whenever there is news.
 *
 * It listens before the browser does anything else: news that came between a drawing and a later effect would be missed.
 */
export function useNews(news: News): void {
  const [, again] = useReducer((count: number) => count + 1, 0);
  useLayoutEffect(() => news.listen(() => again(undefined)), [news]);
}

/** A number that changes more often cannot be read. */
const READABLE_MS = 80;

/**
 * Draw the component again when there is news, but no more often than every `ms`, and not while the page is hidden.
 *
 * It is drawn in the screen frame in which everything else is that the news changes.
 */
export function useSlowNews(news: News, ms = READABLE_MS): void {
  const [, again] = useReducer((count: number) => count + 1, 0);
  useLayoutEffect(() => listenSlowly(news, ms, () => again(undefined)), [news, ms]);
}

/** Call `draw` in the screen frame after news, but no sooner than `ms` after the last time; what ends that. */
export function listenSlowly(news: News, ms: number, draw: () => void): () => void {
  let drawn = -Infinity;
  let due: ReturnType<typeof setTimeout> | null = null;
  const redraw = new Redraw(() => {
    drawn = performance.now();
    draw();
  });
  const stop = news.listen(() => {
    const rest = drawn + ms - performance.now();
    if (rest <= 0) redraw.ask();
    else
      due ??= setTimeout(() => {
        due = null;
        redraw.ask();
      }, rest);
  });
  return () => {
    stop();
    redraw.close();
    if (due !== null) clearTimeout(due);
  };
}
