/** What the robots do meanwhile that are not trained. */

import { formatCall, bindAll } from "../calls";
import { useStudio } from "../context";
import { plain } from "../words";

export function Others() {
  const studio = useStudio();
  const { scene, session, status } = studio;
  if (scene === null || session === null || status === null || scene.robots < 2) return null;
  const trained = status.library.trained.filter(({ complete }) => complete);
  const offered = [...trained, ...scene.behaviors].flatMap((part) => bindAll(part, scene.targets));
  const now = session.others === null ? "" : formatCall(session.others);
  const choose = (select: HTMLSelectElement): void => {
    const { behavior, targets } = offered.find((each) => formatCall(each) === select.value) ?? {
      behavior: null,
      targets: {},
    };
    void studio.ask({ do: "set_other_agents", behavior, targets });
    select.value = now;
    select.blur();
  };
  return (
    <label class="row">
      <span class="soft">the others</span>
      <select
        value={now}
        disabled={!studio.hasControl}
        aria-label="What the others do meanwhile"
        onChange={(event) => choose(event.currentTarget)}
      >
        <option value="">{studio.team === null ? "idle" : "decide for themselves"}</option>
        {now !== "" && !offered.some((each) => formatCall(each) === now) && (
          <option value={now}>{plain(now)}</option>
        )}
        {offered.map((each) => (
          <option key={formatCall(each)} value={formatCall(each)}>
            {plain(formatCall(each))}
          </option>
        ))}
      </select>
    </label>
  );
}
