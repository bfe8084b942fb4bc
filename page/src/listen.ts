/** Listening to what the browser tells of. */

type Events = HTMLElementEventMap & WindowEventMap & DocumentEventMap;
type Handlers = { [K in keyof Events]?: (event: Events[K]) => void };

/** Listen to events of an element, the document or the window; what ends that. */
export function listenTo(
  target: Pick<EventTarget, "addEventListener" | "removeEventListener">,
  handlers: Handlers,
  options?: AddEventListenerOptions,
): () => void {
  const pairs = Object.entries(handlers) as [string, (event: Event) => void][];
  for (const [name, act] of pairs) target.addEventListener(name, act, options);
  return () => pairs.forEach(([name, act]) => target.removeEventListener(name, act, options));
}
