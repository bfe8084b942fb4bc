/** A hundred new worlds over the world here: they run by themselves, and a red one can be gone to. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Button, CloseButton, ControlButton } from "./button";
import { useStudio } from "./context";
import { useNews } from "./news";
import type { WorldGrid } from "./protocol";
import { Redraw } from "./redraw";
import type { Studio } from "./studio";
import { formatCount, plain } from "./words";
import { drawGridPicture } from "./world/gridpicture";
import { palette } from "./world/palette";
import { findOutcome, findTime, layOut, type Cell } from "./worldgrid";

/** What begins it, where it can be begun. */
export function ShowGrid() {
  const studio = useStudio();
  const { worldGrid } = studio;
  useNews(worldGrid.news);
  const { session } = studio;
  if (session === null || session.presses === 0 || !studio.live.mapped || studio.live.real) return null;
  return (
    <ControlButton
      class="small show-grid"
      disabled={worldGrid.running}
      title="It runs in a hundred worlds in which it was not taught, at once"
      onClick={() => void worldGrid.run()}
    >
      {worldGrid.running ? "Running …" : "Show 100 worlds"}
    </ControlButton>
  );
}

export function GridView() {
  const studio = useStudio();
  const { worldGrid } = studio;
  useNews(worldGrid.news);
  const { grid, open } = worldGrid;
  if (!open || grid === null) return null;
  return <OpenGrid key={worldGrid.began} grid={grid} studio={studio} />;
}

function OpenGrid({ grid, studio }: { grid: WorldGrid; studio: Studio }) {
  const { worldGrid } = studio;
  const field = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [cells, setCells] = useState<readonly Cell[]>([]);
  const [, again] = useState(0);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const time = findTime(grid, still ? 1 : worldGrid.progress);
  const over = still || worldGrid.progress >= 1;
  const ended = grid.worlds.filter((each) => findOutcome(each, time) !== "running");
  const works = ended.filter((each) => each.works).length;
  const shown = grid.worlds.filter((each) => each.was_shown).length;

  useEffect(() => {
    if (field.current === null) return undefined;
    const sizes = new ResizeObserver(([entry]) => {
      if (entry !== undefined) setCells(layOut(grid.worlds.length, grid, entry.contentRect));
    });
    sizes.observe(field.current);
    field.current.parentElement?.scrollIntoView({ block: "nearest" }); // on a small screen it may be out of sight
    return () => sizes.disconnect();
  }, [grid]);

  useEffect(() => {
    const redraw = new Redraw(() => {
      const { progress } = worldGrid;
      if (canvas.current !== null && studio.scene !== null)
        drawAll(canvas.current, grid, cells, studio.scene, findTime(grid, still ? 1 : progress));
      again((count) => count + 1);
      if (!still && progress < 1) redraw.ask();
    });
    redraw.ask();
    return () => redraw.close();
  }, [grid, cells, studio, still, worldGrid]);

  return (
    <section class="grid-view" aria-label="A hundred worlds">
      <div class="flex wrap grid-head">
        <p aria-live="polite">
          <b>
            {over
              ? `${plain(grid.name)} works in ${grid.works} of ${formatCount(grid.worlds.length, "world")}`
              : `${works} of ${ended.length} so far`}
          </b>
          {over && " "}
          <span class="soft">
            {shown === 0
              ? "in which it was not taught"
              : `of which ${shown} ${shown === 1 ? "was" : "were"} shown here`}
            {over && grid.works < grid.worlds.length && ". Click a red one to see where it goes wrong"}
          </span>
        </p>
        <span class="space" />
        <ControlButton class="small" disabled={worldGrid.running} onClick={() => void worldGrid.run()}>
          {worldGrid.running ? "Running …" : "Run again"}
        </ControlButton>
        <CloseButton class="link" label="Close the worlds" onClick={() => worldGrid.close()} />
      </div>
      <div class="grid-field" ref={field}>
        <canvas ref={canvas} role="img" aria-label={`Success: ${plain(grid.success)}`} />
        {over &&
          grid.worlds.map((world, index) => {
            const cell = cells[index];
            if (world.works || cell === undefined) return null;
            return (
              <Button
                key={world.seed}
                class="grid-cell"
                style={Object.fromEntries(Object.entries(cell).map(([side, px]) => [side, `${px}px`]))}
                disabled={!studio.hasControl || worldGrid.going !== null}
                aria-label={`Go to world ${world.seed}, where it goes wrong`}
                title="Go to where it goes wrong, and press what is right"
                onClick={() => void worldGrid.visit(world.seed)}
              />
            );
          })}
      </div>
    </section>
  );
}

function drawAll(
  canvas: HTMLCanvasElement,
  grid: WorldGrid,
  cells: readonly Cell[],
  scene: NonNullable<Studio["scene"]>,
  time: number,
): void {
  const pen = canvas.getContext("2d");
  if (pen === null) return;
  const ratio = window.devicePixelRatio;
  const { clientWidth, clientHeight } = canvas;
  canvas.width = Math.round(clientWidth * ratio);
  canvas.height = Math.round(clientHeight * ratio);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  drawGridPicture({ pen, palette: palette(canvas), scene, grid, cells, time });
}
