/** The colors of the picture: those of the page, and calmer ones for the colors that scenarios name. */

/** The variables of the style sheet that the picture uses. */
const NAMES = [
  "ground",
  "grid",
  "wall",
  "solid",
  "ink",
  "soft",
  "pane",
  "robot",
  "train",
  "test",
  "accent",
  "food",
  "danger",
] as const;

export type Palette = Record<(typeof NAMES)[number], string>;

const PAINTS: Readonly<Record<string, string>> = {
  black: "#4a525c",
  blue: "#3a6fd8",
  brown: "#8a5a3c",
  cyan: "#2ba3b8",
  gray: "#8a94a0",
  green: "#5a9a34",
  grey: "#8a94a0",
  magenta: "#c2407f",
  orange: "#e08a2b",
  pink: "#e38bb0",
  purple: "#8f4aa3",
  red: "#cf4446",
  violet: "#8f4aa3",
  white: "#e9ecef",
  yellow: "#d9ac14",
};

export function palette(of: Element): Palette {
  const style = getComputedStyle(of);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`)])) as Palette;
}

/** How a scenario's color is drawn; `otherwise` where it names none. */
export function paint(color: string | null, otherwise: string): string {
  if (color === null || color === "") return otherwise;
  return PAINTS[color.toLowerCase()] ?? (/^#[0-9a-f]{6}$/i.test(color) ? color : otherwise);
}
