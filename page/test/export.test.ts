import { expect, test } from "vitest";
import { exportQuery, fileName, needsRobot, offersSingle, targetName } from "../src/export";

test("targets have names, and those this page does not know are shown as they are", () => {
  expect(targetName("c99")).toBe("C code");
  expect(targetName("prolog")).toBe("prolog");
});

test("the query has every parameter, and single precision only where it is offered", () => {
  const wanted = { name: "go to", to: "c99", targets: { A: "station", B: "ball" }, single: true };
  expect(exportQuery(wanted)).toEqual([
    ["name", "go to"],
    ["to", "c99"],
    ["bind", "A=station"],
    ["bind", "B=ball"],
    ["single", "1"],
  ]);
  expect(exportQuery({ ...wanted, to: "python", targets: {} })).toEqual([
    ["name", "go to"],
    ["to", "python"],
  ]);
  expect([offersSingle("c99"), offersSingle("ros2"), needsRobot("ros2"), needsRobot("c99")]).toEqual([
    true,
    false,
    true,
    false,
  ]);
});

test("a download has the name that the server gives it, without folders", () => {
  expect(fileName('attachment; filename="goto-c99.zip"', "export.zip")).toBe("goto-c99.zip");
  expect(fileName('attachment; filename="../evil.zip"', "export.zip")).toBe("export.zip");
  expect(fileName(null, "export.zip")).toBe("export.zip");
});
