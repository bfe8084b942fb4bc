import { expect, test } from "vitest";
import { Panel } from "../src/panel";

test("what changed is shown in the tab Automaton, with its edge, until it is closed", () => {
  const panel = new Panel();
  panel.open("lesson");
  panel.showChanges("forward done");
  expect([panel.tab, panel.edge, panel.showsChanges]).toEqual(["automaton", "forward done", true]);
  panel.hideChanges();
  expect([panel.tab, panel.edge, panel.showsChanges]).toEqual(["automaton", null, false]);
});
