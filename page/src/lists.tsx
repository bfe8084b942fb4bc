/** Parts of lists: the sign of a row, the beginning of a long list, and how much of a list is done. */

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { Button } from "./button";

interface SignProps {
  /** What it stands for, in a word; `title` says more. */
  means: string;
  title?: string;
  tone?: string;
  children: ComponentChildren;
}

export function Sign({ means, title = means, tone, children }: SignProps) {
  return (
    <span class={tone} role="img" aria-label={means} title={title}>
      {children}
    </span>
  );
}

/** The first of a list, and a button to stand under them that shows the others, called by their number. */
export function useFirst<T>(
  list: readonly T[],
  first: number,
  name: (hidden: number) => string,
): [shown: readonly T[], more: ComponentChildren] {
  const [all, setAll] = useState(false);
  const hidden = all ? 0 : Math.max(0, list.length - first);
  const more = hidden > 0 && (
    <p class="earlier">
      <Button class="link" onClick={() => setAll(true)}>
        {name(hidden)}
      </Button>
    </p>
  );
  return [hidden > 0 ? list.slice(0, first) : list, more];
}

interface ProgressProps {
  label: string;
  finished: number;
  total: number;
  children?: ComponentChildren;
}

export function Progress({ label, finished, total, children }: ProgressProps) {
  return (
    <p class="test-progress">
      <progress aria-label={label} value={finished} max={total} />
      {children !== undefined && <span class="tiny">{children}</span>}
    </p>
  );
}
