/** A label of a recording: its color and its name. */

import type { Review } from "../protocol";
import { plain } from "../words";
import { swatch } from "./scale";

export function Swatch({ label, review }: { label: number; review: Review }) {
  return <span class="swatch" style={{ background: swatch(label, review.labels.length) }} />;
}

/** The name of a label; the last one is of no behavior. */
export function nameLabel({ labels }: Review, label: number, none = "none of these"): string {
  return label === labels.length - 1 ? none : plain(labels[label] ?? "");
}
