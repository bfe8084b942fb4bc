import { expect, test } from "vitest";
import { listActions, readInput, type PadAction, type PadInput } from "../src/gamepad";

const NOTHING: PadInput = { buttons: new Set(), way: null };

function pad(pressed: number[], axes: number[] = [0, 0]): Pick<Gamepad, "axes" | "buttons"> {
  const buttons = Array.from({ length: 17 }, (_, index) => {
    const down = pressed.includes(index);
    return { pressed: down, touched: down, value: down ? 1 : 0 };
  });
  return { axes, buttons };
}

// what is pressed, where the stick is, and what that does, one after the other
const PLAY: [number[], number[], PadAction[]][] = [
  [[], [0.1, -0.1], []], // a stick is never quite at rest
  [[12], [0, 0], ["up"]],
  [[12], [0, 0], []], // held, it counts once
  [[14], [0, 0], ["left"]],
  [[], [0, 0], []],
  [[], [0.5, 0], []],
  [[], [0.9, 0.2], ["right"]],
  [[], [0.5, 0.2], []], // still leaning
  [[], [0.2, 0], []],
  [[], [0, 0.9], ["down"]],
  [[0], [0, 0.9], ["confirm"]],
  [[0, 9], [0, 0], ["pause"]],
  [[3], [0, 0], ["toggle_mode"]],
  [[1], [0, 0], ["undo"]],
  [[2], [0, 0], ["stop"]],
  [[4, 16], [0, 0], []], // the others do nothing
];

test("each press of the pad counts once", () => {
  let before = NOTHING;
  for (const [pressed, axes, done] of PLAY) {
    const now = readInput(pad(pressed, axes), before);
    expect(listActions(before, now), `${pressed} ${axes}`).toEqual(done);
    before = now;
  }
});
