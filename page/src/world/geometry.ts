/** Small geometry of the picture: the way from meters to pixels. */

/** What part of the world is shown: `x`, `y` (m) in the middle, `scale` in pixels for a meter. North is up. */
export interface View {
  x: number;
  y: number;
  scale: number;
}

export interface Size {
  width: number;
  height: number;
}

/** Pixels kept free at the edges of the screen. */
export interface Margins {
  top: number;
  bottom: number;
  sides: number;
}

/** All of the world, as large as it fits between the margins. */
export function fitView(world: Size, screen: Size, margins: Margins): View {
  const { top, bottom, sides } = margins;
  const wide = (screen.width - 2 * sides) / world.width;
  const high = (screen.height - top - bottom) / world.height;
  const scale = Math.max(Math.min(wide, high), 0.01);
  return { x: world.width / 2, y: world.height / 2 + (top - bottom) / 2 / scale, scale };
}

export function toScreen(view: View, screen: Size, x: number, y: number): [number, number] {
  return [screen.width / 2 + (x - view.x) * view.scale, screen.height / 2 - (y - view.y) * view.scale];
}

export function toWorld(view: View, screen: Size, px: number, py: number): [number, number] {
  return [view.x + (px - screen.width / 2) / view.scale, view.y - (py - screen.height / 2) / view.scale];
}

/** Nearer or farther, so that what is under a pixel stays there. */
export function zoomView(view: View, screen: Size, factor: number, px: number, py: number): View {
  const [x, y] = toWorld(view, screen, px, py);
  const scale = Math.min(Math.max(view.scale * factor, 0.5), 2000);
  return {
    x: x - (px - screen.width / 2) / scale,
    y: y + (py - screen.height / 2) / scale,
    scale,
  };
}

/** Moved by pixels, but never so far that the middle of the screen leaves the world. */
export function panView(view: View, world: Size, dx: number, dy: number): View {
  const within = (at: number, length: number): number => Math.min(Math.max(at, 0), length);
  const { x, y, scale } = view;
  return { x: within(x - dx / scale, world.width), y: within(y + dy / scale, world.height), scale };
}

/** A step of `share` from one view to another; zooming goes by factors. */
export function interpolateView(from: View, to: View, share: number): View {
  return {
    x: from.x + (to.x - from.x) * share,
    y: from.y + (to.y - from.y) * share,
    scale: from.scale * (to.scale / from.scale) ** share,
  };
}
