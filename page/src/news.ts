/** Something that changes, and those who want to know. */

import { useLayoutEffect, useReducer } from "preact/hooks";

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

/** Draw the component again when there is news, but no more often than every `ms`. */
export function useSlowNews(news: News, ms: number): void {
  const [, again] = useReducer((count: number) => count + 1, 0);
  useLayoutEffect(() => {
    let due: ReturnType<typeof setTimeout> | null = null;
    const stop = news.listen(() => {
      due ??= setTimeout(() => {
        due = null;
        again(undefined);
      }, ms);
    });
    return () => {
      stop();
      if (due !== null) clearTimeout(due);
    };
  }, [news, ms]);
}
