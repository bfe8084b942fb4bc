/** What the parameters stand for now. */

import { useStudio } from "../context";
import { plain } from "../words";

export function ParameterList() {
  const studio = useStudio();
  const { session, scene } = studio;
  if (session === null || scene === null || session.parameters.length === 0) return null;
  const choose = (parameter: string, select: HTMLSelectElement): void => {
    void studio.ask({ do: "bind_targets", targets: { ...session.targets, [parameter]: select.value } });
    select.blur();
  };
  return (
    <section>
      <h2>Parameters</h2>
      {session.parameters.map((parameter) => (
        <label class="row" key={parameter}>
          <b>{parameter}</b> <span class="soft">is</span>
          <select
            value={session.targets[parameter] ?? ""}
            disabled={!studio.hasControl}
            aria-label={`What ${parameter} stands for`}
            onChange={(event) => choose(parameter, event.currentTarget)}
          >
            {scene.targets.map((target) => (
              <option key={target} value={target}>
                {plain(target)}
              </option>
            ))}
          </select>
        </label>
      ))}
    </section>
  );
}
