import { expect, test } from "vitest";

const SHEETS = import.meta.glob("../src/style/*.css", { query: "?raw", import: "default", eager: true });

test("no animation runs for ever: each of its steps draws the page", () => {
  expect(
    Object.values(SHEETS).filter((sheet) => String(sheet).includes("animation:")).length,
  ).toBeGreaterThan(2);
  const endless = Object.entries(SHEETS).filter(([, sheet]) => /\binfinite\b/.test(String(sheet)));
  expect(endless.map(([name]) => name)).toEqual([]);
});
