/** The bar of real robots: what each is up to, arming, holding, and the emergency stop. */

import { useState } from "preact/hooks";
import { Button, ControlButton } from "./button";
import { Confirm } from "./confirm";
import { useStudio } from "./context";
import { KeyName } from "./keyname";
import { HOLD } from "./live";
import type { RobotStatus } from "./protocol";
import { className } from "./words";

export function Robots() {
  const studio = useStudio();
  const [asks, setAsks] = useState(false);
  const robots = studio.status?.robots ?? [];
  if (robots.length === 0) return null;
  const all = robots.every(({ armed }) => armed);
  const { holding } = studio.live;
  const team = studio.team !== null;
  const armed = robots.filter((robot) => robot.armed).length;
  return (
    <div class={className("flex", "bar", "robots", all && "armed")} role="group" aria-label="Real robots">
      <div class="each" role="status">
        {team && (
          <span>
            {armed} of {robots.length} robots are armed
          </span>
        )}
        {!team &&
          robots.map((robot) => (
            <span key={robot.name} title={robot.stopped}>
              <span class={className("light", robot.armed && (robot.stopped === "" ? "moves" : "waits"))} />
              <b>{robot.name}</b> <span class="soft">{state(robot)}</span>
            </span>
          ))}
      </div>
      <span class="space" />
      {studio.scene?.needs_held_key === true && (
        <ControlButton
          class={className("hold", holding && "on")}
          aria-pressed={holding}
          title="It moves only while you hold this, or the key"
          onPointerDown={(event) => studio.live.hold(event.button === 0)}
          onPointerUp={() => studio.live.hold(false)}
          onPointerLeave={() => studio.live.hold(false)}
          onPointerCancel={() => studio.live.hold(false)}
        >
          Hold to move <KeyName place={HOLD} />
        </ControlButton>
      )}
      {asks ? (
        <Confirm
          label="Arm all"
          disabled={!studio.hasControl}
          onConfirm={() => void studio.ask({ do: "arm" })}
          onClose={() => setAsks(false)}
        >
          <span>All robots will move.</span>
        </Confirm>
      ) : (
        <ControlButton
          disabled={all}
          title={team ? "Arm all robots" : "Arm the robot"}
          onClick={() => (team ? setAsks(true) : void studio.ask({ do: "arm" }))}
        >
          {all ? "Armed" : team ? "Arm all…" : "Arm"}
        </ControlButton>
      )}
      <Button
        class="stop"
        aria-keyshortcuts="Escape"
        title="Stop at once"
        onClick={() => void studio.ask({ do: "stop" })}
      >
        ■ STOP{team && " all"} <kbd aria-hidden="true">Esc</kbd>
      </Button>
    </div>
  );
}

function state({ armed, stopped }: RobotStatus): string {
  if (!armed) return stopped === "" || stopped === "not armed" ? "not armed" : `not armed: ${stopped}`;
  return stopped === "" ? "armed" : `stands: ${stopped}`;
}
