import { expect, test } from "vitest";
import { squadTree } from "../src/squads";

const swarm = { name: "swarm", doc: "", squads: [[0, 1, 2, 3, 4, 5]] };
const platoon = {
  name: "platoon",
  doc: "",
  squads: [
    [0, 1, 2, 3],
    [4, 5],
  ],
};
const squad = { name: "squad", doc: "", squads: [[0, 1], [2, 3], [4]] };

test("each squad stands below the one that it is part of", () => {
  const [top, ...others] = squadTree([swarm, platoon, squad]);
  expect(others).toEqual([]);
  expect(top?.name).toBe("swarm");
  expect(top?.below.map(({ name }) => name)).toEqual(["platoon 1", "platoon 2"]);
  expect(top?.below.map(({ below }) => below.map(({ name }) => name))).toEqual([
    ["squad 1", "squad 2"],
    ["squad 3"],
  ]);
});

test("squads of several sorts that nothing is above stand side by side", () => {
  const sorts = [
    { name: "red", doc: "", squads: [[0, 1]] },
    { name: "blue", doc: "", squads: [[2], [3]] },
  ];
  expect(squadTree(sorts).map(({ name, number }) => [name, number])).toEqual([
    ["red", 0],
    ["blue 1", 0],
    ["blue 2", 1],
  ]);
});
