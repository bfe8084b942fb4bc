import { expect, test } from "vitest";
import { exportQuery, fileName, needsRobot, targetName } from "../src/export";

test("targets have names, and those this page does not know are shown as they are", () => {
  expect(targetName("c99")).toBe("C code");
  expect(targetName("prolog")).toBe("prolog");
});

test("the query has every parameter, and single precision where it is asked for", () => {
  const wanted = { name: "go to", to: "c99", targets: { A: "station", B: "ball" }, single: true };
  expect(exportQuery(wanted)).toEqual([
    ["name", "go to"],
    ["to", "c99"],
    ["bind", "A=station"],
    ["bind", "B=ball"],
    ["single", "1"],
  ]);
  expect(exportQuery({ ...wanted, to: "python", targets: {}, single: false })).toEqual([
    ["name", "go to"],
    ["to", "python"],
  ]);
  expect([needsRobot("ros2"), needsRobot("c99")]).toEqual([true, false]);
});

test("a download has the name that the server gives it, without folders", () => {
  expect(fileName('attachment; filename="goto-c99.zip"', "export.zip")).toBe("goto-c99.zip");
  expect(fileName('attachment; filename="../evil.zip"', "export.zip")).toBe("export.zip");
  expect(fileName(null, "export.zip")).toBe("export.zip");
});
