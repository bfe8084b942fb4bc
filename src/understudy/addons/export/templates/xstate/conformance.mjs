// Runs machine.json on the rows of conformance.csv, and compares what it decides with what Understudy decided.
// With --trace it prints what it decided instead, for `understudy export why`.

import { readFileSync } from "node:fs";
import { createActor } from "xstate";
import { makeMachine } from "./machine.mjs";

const read = (name) => readFileSync(new URL(name, import.meta.url), "utf8");
const described = JSON.parse(read("states.json"));
const tracing = process.argv[2] === "--trace";
const name = (value) => (typeof value === "string" ? [value] : Object.entries(value).flatMap(([key, below]) => [key, ...name(below)]));

const actor = createActor(makeMachine(JSON.parse(read("machine.json"))));
actor.subscribe({ error: (error) => console.error(`machine.json: $${error.message}`) });
actor.start();
const [, ...lines] = read("conformance.csv").trim().split("\n");
const first = 2 + described.readings.length;
let ticks = 0, mismatches = 0;
if (tracing) console.log(described.trace_header);
if (tracing) actor.send({ type: "trace" });
for (const line of lines) {
  const fields = line.split(",");
  const now = Number(fields[1]);
  const readings = {};
  described.readings.forEach((reading, index) => {
    readings[reading] = fields[2 + index] === "" ? NaN : Number(fields[2 + index]);
  });
  if (fields[0] === "1") actor.send({ type: "start", now });
  actor.send({ type: "tick", now, readings });
  const { value, context, status } = actor.getSnapshot();
  const { path, flags, basic } = described.states[name(value).join(".")];
  const found = [path.join("."), flags.map((flag) => flag + 1).join("."), basic];
  const right = status === "active" && found.every((each, index) => fields[first + index] === String(each))
    && described.channels.every((channel, index) => Number(fields[first + 3 + index]) === context.commands[channel]);
  ticks += 1;
  if (!right && ++mismatches <= 5) console.error(`line $${ticks + 1} of conformance.csv is decided otherwise`);
  if (tracing) console.log([fields[1], ...context.trace].join(","));
}
if (!tracing) console.log(`$${ticks} ticks, $${mismatches} mismatches`);
process.exitCode = mismatches || !ticks ? 1 : 0;
