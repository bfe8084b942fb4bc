/** The world with its tools. */

import { useEffect, useRef, useState } from "preact/hooks";
import { useStudio } from "../context";
import { GridView } from "../gridview";
import type { Scene } from "../protocol";
import { Latency } from "../latency";
import { PadHint } from "../padhint";
import { Toast } from "../toast";
import { Welcome } from "../welcome";
import { listenToPointer, type Click } from "./pointer";
import type { Mark } from "./picture";
import { Stage } from "./stage";
import { Chosen as ChosenThing, removal, Tools, type Tool } from "./tools";

export function WorldView() {
  const studio = useStudio();
  const canvas = useRef<HTMLCanvasElement>(null);
  const [stage, setStage] = useState<Stage | null>(null);
  const [tool, setTool] = useState<Tool | null>(null);
  const [marked, setMarked] = useState<Mark | null>(null);
  const click = useRef<(chosen: Click) => void>(() => undefined);

  useEffect(() => {
    if (canvas.current === null) return undefined;
    const newStage = new Stage(canvas.current, studio);
    const stop = listenToPointer(newStage, (chosen) => click.current(chosen));
    setStage(newStage);
    return () => {
      stop();
      newStage.close();
    };
  }, [studio]);

  const selectMark = (mark: Mark | null): void => {
    setMarked(mark);
    if (stage !== null) stage.marked = mark;
    stage?.draw();
  };
  click.current = ({ mark, x, y }) => {
    if (tool !== null) {
      if (tool.what === "obstacle") void studio.ask({ do: "add_obstacle", x, y, radius: 0.4 });
      else void studio.ask({ do: "add_object", kind: tool.kind, x, y });
      setTool(null);
    } else selectMark(mark);
  };

  return (
    <div class={tool === null ? "world" : "world placing"}>
      <canvas
        ref={canvas}
        tabIndex={0}
        role="img"
        aria-label={describeScene(studio.scene)}
        onKeyDown={(event) => {
          if (event.key === "+" || event.key === "=") stage?.zoom(1.25);
          else if (event.key === "-") stage?.zoom(0.8);
          else if (event.key === "Delete" && marked !== null && marked.what !== "robot") {
            void studio.ask(removal(marked));
            selectMark(null);
          } else if (event.key === "Escape") {
            setTool(null);
            selectMark(null);
          }
        }}
      />
      {stage !== null && <Tools stage={stage} tool={tool} choose={setTool} />}
      {marked !== null && <ChosenThing mark={marked} close={() => selectMark(null)} />}
      <Welcome />
      {studio.status?.paused === true && studio.session !== null && (
        <div class="tools paused">
          Paused.
          <span class="keys">
            <kbd>␣</kbd> resumes
          </span>
        </div>
      )}
      <Latency />
      <PadHint />
      <GridView />
      <Toast />
    </div>
  );
}

function describeScene(scene: Scene | null): string {
  if (scene === null) return "The world";
  const { scenario, robots, drawing } = scene;
  if (drawing === "none") return `The world ${scenario} draws no picture.`;
  if (drawing === "pictures") return `The world ${scenario} as it draws itself. Turn the wheel to zoom.`;
  return `The world ${scenario} with ${robots} ${robots === 1 ? "robot" : "robots"}. Drag to pan, turn the wheel to zoom.`;
}
