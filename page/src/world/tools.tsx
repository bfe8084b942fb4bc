/** Tools on the world: what is overlaid, nearer and farther, adding things, and what was clicked. */

import { useState } from "preact/hooks";
import { Button, CloseButton, ControlButton } from "../button";
import { useStudio } from "../context";
import { ControlSelect } from "../fields";
import type { Request } from "../protocol";
import { className, plain } from "../words";
import { OVERLAYS, type Mark, type Overlay } from "./picture";
import type { Stage } from "./stage";

export type Tool = { what: "obstacle" } | { what: "thing"; kind: string };

interface ToolsProps {
  stage: Stage;
  tool: Tool | null;
  choose: (tool: Tool | null) => void;
}

export function Tools({ stage, tool, choose }: ToolsProps) {
  const { scene, session, hasControl, live } = useStudio();
  const [, again] = useState(0);
  if (scene === null) return null;
  const type = scene.robot_type[session?.agent ?? 0] ?? 0;
  const has: Record<Overlay, boolean> = {
    targets: session !== null,
    distances: session !== null && (scene.sonars[type]?.length ?? 0) > 0,
    camera: session !== null && (scene.cameras[type]?.length ?? 0) > 0,
    trail: session !== null,
    names: true,
  };
  return (
    <>
      <div class="tools overlays" role="toolbar" aria-label="Overlays">
        {OVERLAYS.filter((each) => live.mapped && has[each]).map((each) => (
          <Button
            key={each}
            aria-pressed={stage.overlays.has(each)}
            onClick={() => {
              stage.turn(each);
              again((count) => count + 1);
            }}
          >
            {each}
          </Button>
        ))}
      </div>
      {scene.drawing !== "none" && (
        <div class="tools zoom" role="toolbar" aria-label="View">
          <Button aria-label="Nearer" onClick={() => stage.zoom(1.4)}>
            +
          </Button>
          <Button aria-label="Farther" onClick={() => stage.zoom(1 / 1.4)}>
            −
          </Button>
          <Button aria-label="All of it" title="All of it" onClick={() => stage.fit()}>
            ⤢
          </Button>
        </div>
      )}
      {hasControl && !live.fixed && (
        <ControlSelect
          class="tools add"
          aria-label="Add to the world"
          value={tool === null ? "" : tool.what === "obstacle" ? "obstacle" : `thing ${tool.kind}`}
          among={[
            ["", tool === null ? "+ add" : "not now"],
            "obstacle",
            ...scene.classes
              .filter(({ offered }) => offered)
              .map(({ name }) => [`thing ${name}`, plain(name)] as const),
          ]}
          change={(chosen) => {
            const [what, kind] = chosen.split(/ (.*)/s);
            if (what === "obstacle") choose({ what });
            else choose(kind === undefined ? null : { what: "thing", kind });
          }}
        />
      )}
      {tool !== null && <p class="tools placing-hint">Click to place it. Esc cancels.</p>}
    </>
  );
}

/** What takes an object or an obstacle away. */
export function removal({ what, of }: Mark): Request {
  return what === "obstacle" ? { do: "remove_obstacle", index: of } : { do: "remove_object", slot: of };
}

export function Chosen({ mark, close }: { mark: Mark; close: () => void }) {
  const studio = useStudio();
  const { scene, motion, session } = studio;
  const frame = motion.last;
  if (scene === null || frame === null) return null;
  const act = (request: Parameters<typeof studio.ask>[0]): void => {
    void studio.ask(request);
    close();
  };
  const at = mark.what === "thing" ? frame.things.slot.indexOf(mark.of) : -1;
  const kind = scene.classes[frame.things.kind[at] ?? -1];
  if (mark.what === "thing" && kind === undefined) return null;
  const trained = (session?.agent ?? frame.agent) === mark.of;
  return (
    <div class={className("tools", "chosen")} role="group" aria-label="What was clicked">
      {mark.what === "robot" ? (
        <>
          <b>robot {mark.of + 1}</b>
          <span class="soft">
            {trained && session !== null ? "is being trained; " : ""}drag it to move it, and its handle to
            turn it
          </span>
          {!trained && (
            <ControlButton onClick={() => act({ do: "select_agent", agent: mark.of })}>
              Train this one
            </ControlButton>
          )}
        </>
      ) : (
        <>
          <b>{mark.what === "obstacle" ? "obstacle" : plain(kind?.name ?? "")}</b>
          {kind?.food === true && (
            <span class="soft">
              {frame.things.amount[at]} of {frame.things.atFirst[at]}
            </span>
          )}
          <ControlButton onClick={() => act(removal(mark))}>Remove</ControlButton>
        </>
      )}
      <CloseButton label="Close" onClick={close} />
    </div>
  );
}
