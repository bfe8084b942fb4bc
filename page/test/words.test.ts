import { expect, test } from "vitest";
import { listed, ways } from "../src/calls";
import { clock, degrees, plain, value } from "../src/words";

test.each([
  [{ label: "distance_to(A)", unit: "m", kind: "continuous" }, 3.4159, "3.42 m"],
  [{ label: "angle_to(A)", unit: "rad", kind: "toroidal" }, 6.0737, "−12°"],
  [{ label: "at_station", unit: "", kind: "categorical", labels: ["no", "yes"] }, 1, "yes"],
  [{ label: "food_stored", unit: "", kind: "continuous" }, 4, "4"],
  [{ label: "distance_to(A)", unit: "m", kind: "continuous" }, NaN, "–"],
] as const)("%o at %d is %s", (feature, number, said) => {
  expect(value(feature, number)).toBe(said);
});

test("angles are said from -179 to 180", () => {
  expect([Math.PI, -Math.PI, 0.5, -0.5, 7].map(degrees)).toEqual([180, 180, 29, -29, 41]);
});

test("time is minutes and seconds", () => {
  expect([0, 48.26, 59.96, 601].map(clock)).toEqual(["0:00.0", "0:48.3", "1:00.0", "10:01.0"]);
});

test("parameters are bound in every way", () => {
  expect(ways({ name: "goto", parameters: ["A"] }, ["A", "station"])).toEqual(["goto(A)", "goto(station)"]);
  expect(ways({ name: "forward", parameters: [] }, ["A"])).toEqual(["forward"]);
  expect(ways({ name: "between", parameters: ["A", "B"] }, ["x", "y"])).toHaveLength(4);
});

test("names are listed once, with commas or spaces", () => {
  expect(listed(" done, failed done,,")).toEqual(["done", "failed"]);
});

test.each([
  ["rotate_left", "turn left"],
  ["rotate", "rotate"], // a name of one word is a word
  ["nearest_food", "nearest food"],
  ["distance_to(A)", "distance to A"],
  ["angle_to(nearest_food)", "angle to nearest food"],
  ["goto(station)", "goto station"],
  ["blob_x(ball)", "blob x (ball)"],
  ["between(left_post, right_post)", "between (left post, right post)"],
  ["forward → rotate_left, angle_to(A) = 31°.", "forward → turn left, angle to A = 31°."],
  ["when distance_to(A) is below 3 m", "when distance to A is below 3 m"],
  [
    "'no_name' is not in /home/my_lessons/bring_home.json",
    "'no_name' is not in /home/my_lessons/bring_home.json",
  ],
  ["examples (stay) of world(s)", "examples (stay) of world (s)"],
  ["2_000", "2_000"],
])("%s is read as %s", (text, read) => {
  expect(plain(text)).toBe(read);
});
