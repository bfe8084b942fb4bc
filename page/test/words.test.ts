import { expect, test } from "vitest";
import { splitNames, callVariants } from "../src/calls";
import { formatTime, toDegrees, plain, formatValue } from "../src/words";
import names from "./plain_names.json"; // what Python reads too, in tests/model/test_plain_names.py

test.each([
  [{ label: "distance_to(A)", unit: "m", kind: "continuous" }, 3.4159, "3.42 m"],
  [{ label: "angle_to(A)", unit: "rad", kind: "toroidal" }, 6.0737, "−12°"],
  [{ label: "at_station", unit: "", kind: "categorical", labels: ["no", "yes"] }, 1, "yes"],
  [{ label: "food_stored", unit: "", kind: "continuous" }, 4, "4"],
  [{ label: "distance_to(A)", unit: "m", kind: "continuous" }, NaN, "–"],
] as const)("%o at %d is %s", (feature, number, said) => {
  expect(formatValue(feature, number)).toBe(said);
});

test("angles are said from -179 to 180", () => {
  expect([Math.PI, -Math.PI, 0.5, -0.5, 7].map(toDegrees)).toEqual([180, 180, 29, -29, 41]);
});

test("time is minutes and seconds", () => {
  expect([0, 48.26, 59.96, 601].map(formatTime)).toEqual(["0:00.0", "0:48.3", "1:00.0", "10:01.0"]);
});

test("parameters are bound in every way", () => {
  expect(callVariants({ name: "goto", parameters: ["A"] }, ["A", "station"])).toEqual([
    "goto(A)",
    "goto(station)",
  ]);
  expect(callVariants({ name: "forward", parameters: [] }, ["A"])).toEqual(["forward"]);
  expect(callVariants({ name: "between", parameters: ["A", "B"] }, ["x", "y"])).toHaveLength(4);
});

test("names are listed once, with commas or spaces", () => {
  expect(splitNames(" done, failed done,,")).toEqual(["done", "failed"]);
});

test.each(names)("%s is read as %s", (text, read) => {
  expect(plain(text as string)).toBe(read);
});
