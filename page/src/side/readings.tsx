/** The features now: each value with its unit, and its last values as a line. */

import { ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { useSlowNews } from "../news";
import { Spark } from "../spark";
import { plain, formatValue } from "../words";

export function Readings() {
  const studio = useStudio();
  const panel = usePanel();
  useSlowNews(studio.framed);
  const { session, history, motion } = studio;
  if (session === null) return null;
  const values = motion.last?.features;
  return (
    <section>
      <h2>Features now</h2>
      {session.features.length === 0 && (
        <p class="tiny">None is chosen: it cannot tell one moment from another. Choose some below.</p>
      )}
      {session.features.map((feature, index) => (
        <div class="reading" key={feature.label} data-feature={feature.label}>
          <span class="cut" title={plain(feature.label)}>
            {plain(feature.label)}
          </span>
          <b class="number">{formatValue(feature, values?.[index] ?? NaN)}</b>
          <Spark feature={feature} values={history.valuesOf(index)} />
        </div>
      ))}
      <ControlButton class="row soft" onClick={() => panel.choose("choose")}>
        + choose features
      </ControlButton>
    </section>
  );
}
