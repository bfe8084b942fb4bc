/** How values, times and keys are written. */

import type { Feature } from "./protocol";

export const ABSENT = "–";
const DIGITS: Readonly<Record<string, number>> = { m: 2, s: 1, px: 0 };

export function isAngle(feature: Feature): boolean {
  return feature.kind === "toroidal" && (feature.unit === "rad" || feature.unit === "°");
}

/** An angle in whole degrees, left of ahead above 0: -179 to 180. */
export function toDegrees(radians: number): number {
  const turn = Math.round((radians * 180) / Math.PI);
  return ((((turn + 179) % 360) + 360) % 360) - 179;
}

/** A value with its unit: 3.42 m, −31°, yes; a dash where it is absent. */
export function formatValue(feature: Feature, number: number): string {
  if (Number.isNaN(number)) return ABSENT;
  if (feature.kind === "categorical") return nameOf(feature, number);
  if (isAngle(feature)) return useMinusSign(`${toDegrees(number)}°`);
  const digits = DIGITS[feature.unit] ?? (Number.isInteger(number) ? 0 : 2);
  return useMinusSign(number.toFixed(digits) + (feature.unit === "" ? "" : ` ${feature.unit}`));
}

export function useMinusSign(text: string): string {
  return text.replace("-", "−");
}

/** Minutes and seconds: 0:48.3. */
export function formatTime(seconds: number | null): string {
  if (seconds === null) return ABSENT;
  const tenths = Math.round(seconds * 10);
  const whole = Math.floor(tenths / 10) % 60;
  return `${Math.floor(tenths / 600)}:${String(whole).padStart(2, "0")}.${tenths % 10}`;
}

/** A moment as a date and a time of day: Nov 21, 10:15. */
export function formatMoment(moment: string | null): string {
  if (moment === null) return "";
  const form = { month: "short", day: "numeric", hour: "2-digit", minute: "2-digit" } as const;
  return new Date(moment).toLocaleString("en", { ...form, hour12: false });
}

/** 1 example, 2 examples. */
export function formatCount(count: number, what: string): string {
  return `${count} ${what}${count === 1 ? "" : "s"}`;
}

/** A call, or a name of several words, unless it stands in quotes or is part of a path. */
const IDENTIFIER =
  /(?<![\w/\\.'-])(?:([A-Za-z]\w*)\(([^()=]+)\)|([A-Za-z]\w*_\w*[A-Za-z0-9]))(?![\w/\\]|[.-]\w)/g;
const SPELLED: Readonly<Record<string, string>> = { rotate: "turn" };

/**
 * Names of the code as people read them, at any place in a text: nearest_food is "nearest food", distance_to(A)
 * "distance to A", rotate_left "turn left". Files, code and messages of the studio keep the names themselves.
 */
export function plain(text: string): string {
  return text.replace(IDENTIFIER, (_, name: string | undefined, bound = "", words = "") => {
    if (name === undefined) return spellName(words as string);
    const targets = (bound as string).split(",").map((target) => spellName(target.trim()));
    return / ?to$/.test(spellName(name))
      ? `${spellName(name)} ${targets.join(", ")}`
      : `${spellName(name)} (${targets.join(", ")})`;
  });
}

function spellName(name: string): string {
  const [first = "", ...rest] = name.split("_").filter((word) => word !== "");
  return [rest.length > 0 ? (SPELLED[first] ?? first) : first, ...rest].join(" ");
}

/** Whether the screen is small, or touched: nothing is in small print then (as in style/touch.css). */
export function isSmall(): boolean {
  return matchMedia("(max-width: 1000px), (max-height: 500px), (pointer: coarse)").matches;
}

/** Whether keys are worth telling of: a screen that is only touched seldom has a keyboard (as in style/touch.css). */
export function hasKeys(): boolean {
  return !matchMedia("(hover: none), (pointer: coarse)").matches;
}

export function className(...names: (string | false | null | undefined)[]): string {
  return names.filter(Boolean).join(" ");
}

function nameOf(feature: Feature, number: number): string {
  const labels = feature.labels ?? ["no", "yes"];
  return labels[number] ?? String(number);
}
