/** The studio and the panel, for every component. */

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import { useNews } from "./news";
import type { Panel } from "./panel";
import type { Studio } from "./studio";
import type { Tour } from "./tour";

interface Around {
  studio: Studio;
  panel: Panel;
  tour: Tour;
}

export const AroundContext = createContext<Around | null>(null);

function around(): Around {
  const found = useContext(AroundContext);
  if (found === null) throw new Error("a component is outside the app");
  return found;
}

/** The studio; draws the component again when it has news. */
export function useStudio(): Studio {
  const { studio } = around();
  useNews(studio.news);
  return studio;
}

/** The studio without listening to it. */
export function useQuietStudio(): Studio {
  return around().studio;
}

/** The tour; draws the component again when it goes on. */
export function useTour(): Tour {
  const { tour } = around();
  useNews(tour.news);
  return tour;
}

export function usePanel(): Panel {
  const { panel } = around();
  useNews(panel.news);
  return panel;
}
