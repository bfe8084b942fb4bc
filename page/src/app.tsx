/** The one screen: header, left column, world, right column. */

import { useEffect, useMemo } from "preact/hooks";
import { Bars } from "./bars";
import { QuestionCard } from "./question";
import { CurrentApp, useStudio } from "./context";
import { StateButtons } from "./statebuttons";
import { Guide } from "./guide";
import { Header } from "./header";
import { listenToKeys } from "./keys";
import type { Panel } from "./panel";
import { Pane } from "./pane";
import { Robots } from "./robots";
import { Side } from "./side";
import type { Studio } from "./studio";
import { TeamView } from "./team";
import { Timeline } from "./timeline";
import type { Tour } from "./tour";
import { WorldView } from "./world/canvas";

const BUTTONS = "button, [role=button]";

export function App({ studio, panel, tour }: { studio: Studio; panel: Panel; tour: Tour }) {
  const around = useMemo(() => ({ studio, panel, tour }), [studio, panel, tour]);
  useEffect(() => listenToKeys(studio), [studio]);
  useEffect(() => studio.live.begin(), [studio]);
  return (
    <CurrentApp.Provider value={around}>
      <div class="screen" onClick={letKeysGo}>
        <Header />
        <div class="bars">
          <Bars />
          <Robots />
        </div>
        <MainView />
      </div>
    </CurrentApp.Provider>
  );
}

/** The running team, or the training of one of its agents; without a team, always the training. */
function MainView() {
  const studio = useStudio();
  if (studio.team !== null && studio.view === "team") return <TeamView />;
  return (
    <>
      <Side />
      <main class="center">
        <WorldView />
        <Guide />
        <QuestionCard />
        <StateButtons />
        <Timeline />
      </main>
      <Pane />
    </>
  );
}

/** A button that was clicked gives the focus back, so that Space and Enter go on meaning what they mean. */
function letKeysGo(event: MouseEvent): void {
  const button = event.target instanceof Element ? event.target.closest(BUTTONS) : null;
  if (event.detail > 0 && (button instanceof HTMLElement || button instanceof SVGElement)) button.blur();
}
