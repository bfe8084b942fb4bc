/** What the robots do meanwhile that are not trained. */

import { formatCall, bindAll } from "../calls";
import { useStudio } from "../context";
import { ControlSelect } from "../fields";

export function Others() {
  const studio = useStudio();
  const { scene, session, status } = studio;
  if (scene === null || session === null || status === null || scene.robots < 2) return null;
  const trained = status.library.trained.filter(({ complete }) => complete);
  const offered = [...trained, ...scene.behaviors].flatMap((part) => bindAll(part, scene.targets));
  const now = session.others === null ? "" : formatCall(session.others);
  const calls = offered.map(formatCall);
  const choose = (call: string): void => {
    const { behavior, targets } = offered[calls.indexOf(call)] ?? { behavior: null, targets: {} };
    void studio.ask({ do: "set_other_agents", behavior, targets });
  };
  return (
    <label class="row">
      <span class="soft">the others</span>
      <ControlSelect
        value={now}
        among={[
          ["", studio.team === null ? "idle" : "decide for themselves"],
          ...(now === "" || calls.includes(now) ? [] : [now]),
          ...calls,
        ]}
        aria-label="What the others do meanwhile"
        change={choose}
      />
    </label>
  );
}
