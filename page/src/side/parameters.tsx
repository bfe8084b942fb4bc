/** What the parameters stand for now. */

import { useStudio } from "../context";
import { ControlSelect } from "../fields";

export function ParameterList() {
  const studio = useStudio();
  const { session, scene } = studio;
  if (session === null || scene === null || session.parameters.length === 0) return null;
  const choose = (parameter: string, target: string): void =>
    void studio.ask({ do: "bind_targets", targets: { ...session.targets, [parameter]: target } });
  return (
    <section>
      <h2>Parameters</h2>
      {session.parameters.map((parameter) => (
        <label class="row" key={parameter}>
          <b>{parameter}</b> <span class="soft">is</span>
          <ControlSelect
            value={session.targets[parameter] ?? ""}
            among={scene.targets}
            aria-label={`What ${parameter} stands for`}
            change={(target) => choose(parameter, target)}
          />
        </label>
      ))}
    </section>
  );
}
