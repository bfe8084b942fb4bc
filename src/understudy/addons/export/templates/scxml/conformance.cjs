// Runs $file on the rows of conformance.csv, and compares what it decides with what Understudy decided.
// With --trace it prints what it decided instead, for `understudy export why`.

"use strict";
const { readFileSync } = require("node:fs");
const { join } = require("node:path");
const scxml = require("@scion-scxml/scxml");

const DATA = 3; // where a snapshot has the data model
const read = (name) => readFileSync(join(__dirname, name), "utf8");
const described = JSON.parse(read("states.json"));
const tracing = process.argv[2] === "--trace";

function check(chart) {
  const [, ...lines] = read("conformance.csv").trim().split("\n");
  const first = 2 + described.readings.length;
  let ticks = 0, mismatches = 0;
  if (tracing) chart.gen({ name: "trace" });
  for (const line of lines) {
    const fields = line.split(",");
    const now = Number(fields[1]);
    const readings = {};
    described.readings.forEach((name, index) => {
      readings[name] = fields[2 + index] === "" ? NaN : Number(fields[2 + index]);
    });
    if (fields[0] === "1") chart.gen({ name: "start", data: { now } });
    const [state] = chart.gen({ name: "tick", data: { now, readings } });
    const { commands, trace } = chart.getSnapshot()[DATA];
    const { path, flags, basic } = described.states[state] ?? { path: [], flags: [], basic: -1 };
    const found = [path.join("."), flags.map((flag) => flag + 1).join("."), basic];
    const right = found.every((each, index) => fields[first + index] === String(each))
      && described.channels.every((name, index) => Number(fields[first + 3 + index]) === commands[name]);
    ticks += 1;
    if (!right && ++mismatches <= 5) console.error(`line $${ticks + 1} of conformance.csv is decided otherwise`);
    if (tracing) console.log([fields[1], ...trace].join(","));
  }
  return [ticks, mismatches];
}

function run(error, model) {
  if (error) throw error;
  model.prepare((problem, prepared) => {
    if (problem) throw problem;
    const chart = new scxml.core.Statechart(prepared);
    chart.on("onError", ({ data }) => console.error(`$file: $${data.reason}`));
    chart.start();
    if (tracing) console.log(described.trace_header);
    const [ticks, mismatches] = check(chart);
    if (!tracing) console.log(`$${ticks} ticks, $${mismatches} mismatches`);
    process.exitCode = mismatches || !ticks ? 1 : 0;
  });
}

scxml.documentStringToModel(join(__dirname, "$file"), read("$file"), run);
