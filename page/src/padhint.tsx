/** What the buttons of a gamepad do, while one is connected. */

import { useEffect, useMemo } from "preact/hooks";
import { useStudio } from "./context";
import { Pad } from "./gamepad";
import { useNews } from "./news";
import { plain } from "./words";

export function PadHint() {
  const studio = useStudio();
  const pad = useMemo(() => new Pad(studio), [studio]);
  useEffect(() => pad.listen(), [pad]);
  useNews(pad.news);
  if (!pad.connected || studio.session === null) return null;
  const flag = studio.session.states.find((state) => state.flag);
  const hints = [
    ["✚", "direct"],
    ["A", "confirm"],
    ...(flag === undefined ? [] : [["X", plain(flag.name)]]),
    ["Y", studio.session.mode === "testing" ? "teach" : "try"],
    ["B", "undo"],
    ["Start", "pause"],
  ];
  return (
    <p class="tiny pad-hint">
      gamepad{" "}
      {hints.map(([key, does]) => (
        <span key={key}>
          <kbd>{key}</kbd> {does}{" "}
        </span>
      ))}
    </p>
  );
}
