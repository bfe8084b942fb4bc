/** The right column: a form while one is open, else the tabs Automaton, Lesson, Coach, Library. */

import { useEffect, useRef } from "preact/hooks";
import { Button } from "./button";
import { usePanel, useStudio } from "./context";
import { AutomatonTab } from "./pane/automaton";
import { ChoiceForm } from "./pane/choice";
import { CoachTab } from "./pane/coach";
import { DoubtCard } from "./pane/doubt";
import { LessonTab } from "./pane/lesson";
import { LibraryTab } from "./pane/library";
import { SaveWarning } from "./pane/savewarning";
import { ScoreLine } from "./pane/score";
import { TABS, type Panel, type Tab } from "./panel";
import { isSmall } from "./words";

const NAMES: Readonly<Record<Tab, string>> = {
  automaton: "Automaton",
  lesson: "Lesson",
  coach: "Coach",
  library: "Library",
};

export function Pane() {
  const panel = usePanel();
  const studio = useStudio();
  const unsure = studio.session?.queries.marks.length ?? 0;
  const counts: Partial<Record<Tab, number>> = {
    ...(unsure === 0 ? {} : { coach: unsure }),
    ...(studio.session === null ? {} : { lesson: studio.session.examples.length }),
    ...(studio.status === null ? {} : { library: studio.status.library.trained.length }),
  };
  useShownOnPhones(panel.form !== null);
  return (
    <section class="pane" aria-label="Automaton, lesson, coach and library">
      <div class="tabs" role="tablist" onKeyDown={(event) => turnPage(panel, event)}>
        {TABS.map((tab) => (
          <Button
            key={tab}
            role="tab"
            id={`tab-${tab}`}
            aria-selected={panel.tab === tab && panel.form === null}
            aria-controls="tab-panel"
            tabIndex={panel.tab === tab ? 0 : -1}
            onClick={() => panel.open(tab)}
          >
            {NAMES[tab]}
            {counts[tab] !== undefined && <span class="soft"> {counts[tab]}</span>}
          </Button>
        ))}
      </div>
      <ScoreLine />
      <DoubtCard />
      <SaveWarning />
      <div class="tab" id="tab-panel" role="tabpanel" aria-labelledby={`tab-${panel.tab}`} tabIndex={-1}>
        {panel.form !== null ? (
          <ChoiceForm form={panel.form} key={panel.form} />
        ) : panel.tab === "automaton" ? (
          <AutomatonTab />
        ) : panel.tab === "lesson" ? (
          <LessonTab />
        ) : panel.tab === "coach" ? (
          <CoachTab />
        ) : (
          <LibraryTab />
        )}
      </div>
    </section>
  );
}

/** Where the page scrolls as a whole, a form that opens is scrolled to, and the world once it is closed. */
function useShownOnPhones(open: boolean): void {
  const before = useRef(open);
  useEffect(() => {
    if (open === before.current) return;
    before.current = open;
    if (!isSmall()) return;
    document.querySelector(open ? ".pane" : ".screen")?.scrollIntoView({ block: "start" });
  }, [open]);
}

function turnPage(panel: Panel, event: KeyboardEvent): void {
  const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
  if (step === 0) return;
  const next = TABS[(TABS.indexOf(panel.tab) + step + TABS.length) % TABS.length];
  if (next === undefined) return;
  panel.open(next);
  document.getElementById(`tab-${next}`)?.focus();
}
