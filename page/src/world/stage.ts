/** The canvas: draws when something that it shows has changed, and eases the view to where it is wanted. */

import type { News } from "../news";
import type { Scene } from "../protocol";
import { Redraw } from "../redraw";
import type { Studio } from "../studio";
import { drawBody } from "./body";
import { interpolateView, fitView, panView, type Margins, type Size, type View, zoomView } from "./geometry";
import { drawGround } from "./ground";
import { drawHandle, type Handle } from "./handle";
import { drawOverlays } from "./overlays";
import { palette, type Palette } from "./palette";
import type { Motion } from "./motion";
import { OVERLAYS, type PictureSession, type Mark, type Overlay, type Picture } from "./picture";
import { drawRobots } from "./robots";
import { drawThings } from "./things";

/** Room for the tools above, and for what is said below. */
const MARGINS = { top: 46, bottom: 64, sides: 24 };
const EASE = 0.22;

/** Whose world is drawn. */
export interface WorldSource {
  readonly news: News;
  /** Tells of each frame. */
  readonly framed: News;
  readonly motion: Motion;
  readonly scene: Scene | null;
  readonly session: PictureSession | null;
  readonly sort: string | null;
  readonly image: ImageBitmap | null;
  readonly hasControl: boolean;
  readonly live: { readonly fixed: boolean };
}

/** What is drawn on the ground, and what that depends on beside the world. */
export interface Layer {
  draw(picture: Picture): void;
  list(): readonly unknown[];
}

const OVERLAY_LAYER: Layer = { draw: drawOverlays, list: () => [] };

export class Stage<S extends WorldSource = Studio> {
  readonly overlays = new Set<Overlay>(OVERLAYS.filter((each) => each !== "camera"));
  marked: Mark | null = null;
  dragged: (Mark & { x: number; y: number }) | null = null;
  /** What turns the chosen robot, and whether a person holds it. */
  handle: Handle | null = null;
  turning = false;
  screen: Size = { width: 1, height: 1 };
  view: View = { x: 0, y: 0, scale: 1 };
  private wanted: View = this.view;
  private fits = true;
  /** What was visible in the last drawing. */
  private drawn: readonly unknown[] = [];
  private readonly redraw = new Redraw(() => this.show());
  private colors: Palette;
  private readonly pen: CanvasRenderingContext2D;
  private readonly ends: (() => void)[] = [];

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly studio: S,
    private readonly margins: Margins = MARGINS,
    private readonly below: Layer = OVERLAY_LAYER,
  ) {
    this.pen = canvas.getContext("2d") as CanvasRenderingContext2D;
    this.colors = palette(canvas);
    const sizes = new ResizeObserver(() => this.resize());
    sizes.observe(canvas);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const recolor = (): void => {
      this.colors = palette(canvas);
      this.draw();
    };
    dark.addEventListener("change", recolor);
    this.ends.push(
      () => sizes.disconnect(),
      () => dark.removeEventListener("change", recolor),
      studio.framed.listen(() => this.look()),
      studio.news.listen(() => this.look()),
      () => this.redraw.close(),
    );
    this.resize();
  }

  close(): void {
    for (const end of this.ends) end();
  }

  /** Draw with the next frame of the screen. */
  draw(): void {
    this.redraw.ask();
  }

  /** Draw if anything that is visible has changed since it was drawn. */
  look(): void {
    if (this.fits) this.fit();
    if (this.visible.some((each, index) => each !== this.drawn[index])) this.draw();
  }

  fit(): void {
    const { scene } = this.studio;
    if (scene === null) return;
    this.want(fitView(scene, this.screen, this.margins));
    this.fits = true;
  }

  /** Nearer or farther, around a pixel; around the middle where none is named. */
  zoom(factor: number, px = this.screen.width / 2, py = this.screen.height / 2): void {
    this.want(zoomView(this.wanted, this.screen, factor, px, py));
    this.fits = false;
  }

  pan(dx: number, dy: number): void {
    const { scene } = this.studio;
    if (scene === null) return;
    const { x, y } = this.wanted;
    this.want(panView(this.wanted, scene, dx, dy));
    this.view = { ...this.view, x: this.view.x + this.wanted.x - x, y: this.view.y + this.wanted.y - y };
    this.fits = false;
  }

  turn(overlay: Overlay): void {
    if (!this.overlays.delete(overlay)) this.overlays.add(overlay);
    this.draw();
  }

  /** What the picture is drawn of. */
  private get visible(): readonly unknown[] {
    const { scene, session, motion, sort, image, hasControl, live } = this.studio;
    return [
      scene,
      scene?.drawing === "map" && motion.changes,
      image,
      sort,
      hasControl,
      live.fixed,
      session?.mode,
      session?.features.map(({ label }) => label).join("\n"),
      session?.activities.join("\n"),
      ...this.below.list(),
    ];
  }

  private want(view: View): void {
    const { x, y, scale } = this.wanted;
    if (view.x === x && view.y === y && view.scale === scale) return;
    this.wanted = view;
    this.draw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    const fine = devicePixelRatio || 1;
    const [wide, high] = [Math.round(width * fine), Math.round(height * fine)];
    const { canvas, screen } = this;
    if (wide === canvas.width && high === canvas.height && width === screen.width) return;
    this.canvas.width = wide;
    this.canvas.height = high;
    this.screen = { width, height };
    if (this.fits && this.studio.scene !== null) {
      this.view = this.wanted = fitView(this.studio.scene, this.screen, this.margins);
    }
    if (document.hidden) this.draw();
    else this.show(); // at once, as another size clears the canvas
  }

  private show(): void {
    const { scene, session, motion } = this.studio;
    this.drawn = this.visible;
    const fine = devicePixelRatio || 1;
    this.pen.setTransform(fine, 0, 0, fine, 0, 0);
    if (scene === null) return;
    if (this.view.scale === 1) this.view = this.wanted;
    this.view = isNear(this.view, this.wanted) ? this.wanted : interpolateView(this.view, this.wanted, EASE);
    const picture: Picture = {
      pen: this.pen,
      screen: this.screen,
      view: this.view,
      scene,
      session,
      led: this.studio.sort !== null,
      motion,
      palette: this.colors,
      overlays: this.overlays,
      marked: this.marked,
      dragged: this.dragged,
    };
    if (scene.drawing === "map") {
      drawGround(picture);
      this.below.draw(picture);
      drawThings(picture);
      drawRobots(picture);
    } else drawBody(picture, this.studio.image);
    const turns = this.studio.hasControl && !this.studio.live.fixed;
    this.handle = turns ? drawHandle(picture, this.turning ? this.handle : null) : null;
    if (this.view !== this.wanted) this.draw();
  }
}

function isNear(view: View, wanted: View): boolean {
  const apart = Math.hypot(view.x - wanted.x, view.y - wanted.y) * wanted.scale;
  return apart < 0.3 && Math.abs(view.scale / wanted.scale - 1) < 0.002;
}
