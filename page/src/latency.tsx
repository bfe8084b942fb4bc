/** How long the last press took: from the key until it was in the journal and the page knew. */

import { useStudio } from "./context";

export function Latency() {
  const { latency } = useStudio();
  if (latency === null) return null;
  const { whole, server } = latency;
  const inside = server === null ? "" : `; ${server.toFixed(1)} ms of it in the studio`;
  return (
    <span class="tiny number latency" title={`From the key until the press was in the journal${inside}`}>
      Saved in {whole.toFixed(whole < 10 ? 1 : 0)} ms
    </span>
  );
}
