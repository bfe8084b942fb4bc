import { expect, test } from "vitest";
import { STEPS, Tour, chooseDirection, type Moment } from "../src/tour";

function store(): Pick<Storage, "getItem" | "setItem"> {
  const kept = new Map<string, string>();
  return { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => void kept.set(key, value) };
}

const FIRST: Moment = {
  isTaught: false,
  state: "start",
  stopped: false,
  presses: 0,
  seed: 0,
  distance: 5,
  angle: 60,
  works: null,
};

// what changes, and how many steps are done then
const WAY: [Partial<Moment>, number][] = [
  [{}, 0],
  [{ isTaught: true }, 1],
  [{ angle: 3 }, 1], // it looks there by chance: nothing was pressed
  [{ presses: 1, angle: 40 }, 1],
  [{ angle: 19 }, 2],
  [{ stopped: true }, 2], // far away
  [{ distance: 0.3 }, 3],
  [{ presses: 2 }, 3], // still the same world
  [{ seed: 1, stopped: false }, 3],
  [{ stopped: true }, 4],
  [{ seed: 2, stopped: false }, 4],
  [{ presses: 3 }, 4], // a correction
  [{ stopped: true }, 4], // and not by itself
  [{ seed: 3, stopped: false }, 4],
  [{ stopped: true, distance: 3 }, 4], // it stopped too early
  [{ stopped: false, presses: 2 }, 4], // a press was undone
  [{ stopped: true, distance: 0.3 }, 5],
  [{ seed: 4 }, 5], // it was not seen in a hundred worlds yet
  [{ works: 97 }, 6],
];

test("each step is done by what the person does", () => {
  const tour = new Tour(store());
  tour.begin(true);
  let moment = FIRST;
  for (const [change, done] of WAY) {
    moment = { ...moment, ...change };
    tour.see(moment);
    expect(tour.step, JSON.stringify(change)).toBe(done);
  }
  expect(tour.done).toBe(true);
  expect(STEPS).toHaveLength(6);
});

test("a robot that decides by itself is helped after half a second", () => {
  const tour = new Tour(store());
  const seen: [boolean, number, boolean][] = [
    [true, 10.0, false],
    [true, 10.4, false],
    [true, 10.5, true],
    [true, 12.0, true],
    [false, 12.1, false],
    [false, 12.6, false], // it does what it should, for as long
    [true, 12.7, false],
    [true, 0.0, false], // another world
    [true, 0.4, false],
    [true, 0.5, true],
  ];
  for (const [wrong, time, helps] of seen) expect(tour.needsHelp(wrong, time), `at ${time}`).toBe(helps);
});

test("a robot that turns to and fro needs help, whenever it turns away", () => {
  const tour = new Tour(store());
  const seen: [boolean, number, boolean][] = [
    [true, 0, false],
    [false, 0.2, false],
    [true, 0.4, false],
    [false, 0.6, false], // turned away for half a second, but now it does the right thing
    [true, 0.8, true],
    [false, 1, false],
    [false, 1.5, false], // and it goes on with that
    [true, 1.7, false],
    [true, 0.1, false], // in another world
    [true, 0.6, true],
  ];
  for (const [wrong, time, helps] of seen) expect(tour.needsHelp(wrong, time), `at ${time}`).toBe(helps);
});

test("it can be left and taken up again, on a page loaded anew, too", () => {
  const kept = store();
  const tour = new Tour(kept);
  tour.begin(true);
  tour.see({ ...FIRST, isTaught: true });
  tour.leave();
  tour.see({ ...FIRST, isTaught: true, stopped: true });
  const again = new Tour(kept);
  expect([again.step, again.active, again.left]).toEqual([1, false, true]);
  again.begin(false);
  expect([again.step, again.left]).toEqual([1, false]);
});

test.each([
  [5, 60, null, "left"],
  [5, -60, null, "right"],
  [5, 30, "left", "left"], // turning goes on until it is ahead
  [5, 15, "left", "up"], // a late press is in time
  [5, 30, "up", "up"], // driving does not stop for a little
  [5, -45, "left", "right"], // it turned past it
  [5, -120, "left", "left"], // the long way round is a way
  [0.2, 60, "up", "done"],
  [NaN, NaN, "up", null],
] as const)("%s m, %s degrees, while %s: %s", (distance, angle, now, wished) => {
  expect(chooseDirection({ ...FIRST, distance, angle }, now)).toBe(wished);
});

test("after six worlds the tour goes on, though the robot needed a press in each", () => {
  const tour = new Tour(store());
  tour.begin(true);
  let moment: Moment = { ...FIRST, isTaught: true };
  const see = (change: Partial<Moment>): number => {
    moment = { ...moment, ...change };
    tour.see(moment);
    return tour.step;
  };
  see({});
  see({ presses: 1, angle: 0 });
  expect(see({ stopped: true, distance: 0.2 })).toBe(3);
  const steps = [1, 2, 3, 4, 5].map((seed) => {
    see({ seed, stopped: false });
    see({ presses: moment.presses + 1 });
    return see({ stopped: true });
  });
  expect(steps).toEqual([4, 4, 4, 4, 5]);
});
