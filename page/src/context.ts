/** The studio and the panel, for every component. */

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import { useNews } from "./news";
import type { Panel } from "./panel";
import type { Studio } from "./studio";
import type { Tour } from "./tour";

interface AppContext {
  studio: Studio;
  panel: Panel;
  tour: Tour;
}

export const CurrentApp = createContext<AppContext | null>(null);

function useApp(): AppContext {
  const app = useContext(CurrentApp);
  if (app === null) throw new Error("a component is outside the app");
  return app;
}

/** The studio; draws the component again when it has news. */
export function useStudio(): Studio {
  const { studio } = useApp();
  useNews(studio.news);
  return studio;
}

/** The studio without listening to it. */
export function useQuietStudio(): Studio {
  return useApp().studio;
}

/** The tour; draws the component again when it goes on. */
export function useTour(): Tour {
  const { tour } = useApp();
  useNews(tour.news);
  return tour;
}

export function usePanel(): Panel {
  const { panel } = useApp();
  useNews(panel.news);
  return panel;
}
