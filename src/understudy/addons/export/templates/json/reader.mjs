// Reads the documents of a library and runs an automaton of it, as the documentation of the library format says.
// `node reader.mjs` runs it on conformance.csv; `node reader.mjs --trace` prints the trace of that instead.

import { readFileSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = dirname(fileURLToPath(import.meta.url));
const read = (...path) => readFileSync(join(folder, ...path), "utf8");
const parts = JSON.parse(read("parts.json"));
const documents = Object.create(null);
for (const file of readdirSync(join(folder, "library"))) {
  const document = JSON.parse(read("library", file));
  documents[document.automaton.name] = document;
}

const absent = (x) => x !== x;
const finite = (x) => (Number.isFinite(x) ? x : NaN); // what is infinite is absent

// A binding refers to parameters of the automaton around it, or to targets.
function substitute(binding, around) {
  const find = (name) => (Object.hasOwn(around, name) ? around[name] : name);
  return Object.fromEntries(Object.entries(binding ?? {}).map(([key, name]) => [key, find(name)]));
}

// Arguments are in the alphabetical order of the parameters in labels, in declared order in names.
function label(name, binding, order = Object.keys(binding ?? {}).sort()) {
  return order.length ? `${name}(${order.map((each) => binding[each]).join(", ")})` : name;
}

function elapsed(now, since) {
  const steps = now < 4194304 ? 1e9 : 1e6;
  return Math.floor((now - since) * steps + 0.5) / steps;
}

// An expression is a number, ["reading", NAME, PARAMETER or null], or an operation with its operands.
function evaluate(expression, binding, readings) {
  if (typeof expression === "number") return expression;
  const [operation, ...operands] = expression;
  if (operation === "reading") {
    const [name, parameter] = operands;
    return readings[parameter === null ? name : `${name}(${binding[parameter]})`];
  }
  const [a, b, c] = operands.map((each) => evaluate(each, binding, readings));
  switch (operation) {
    case "+": return a + b;
    case "-": return a - b;
    case "*": return a * b;
    case "/": return a / b;
    case "<": return Number(a < b);
    case "<=": return Number(a <= b);
    case ">": return Number(a > b);
    case ">=": return Number(a >= b);
    case "neg": return -a;
    case "abs": return Math.abs(a);
    case "sqrt": return Math.sqrt(a);
    case "minimum": return Math.min(a, b);
    case "maximum": return Math.max(a, b);
    case "where": return a ? b : c;
    case "isnan": return Number(absent(a));
    default: throw new Error(`${operation} is computed by code that could not be translated`);
  }
}

function fit(kind, x) {
  if (kind === "boolean" || kind.startsWith("categorical")) return finite(x);
  const period = kind.startsWith("toroidal(") ? Number(kind.slice(9, -1)) : 0;
  if (!period) return finite(x);
  const wrapped = x % period < 0 ? (x % period) + period : x % period;
  return wrapped >= period ? 0 : wrapped;
}

// An automaton that runs: its state, flag, counters and timers, and the child that its state runs.
class Running {
  constructor(name, binding, now) {
    const { automaton, built } = documents[name];
    Object.assign(this, { automaton, binding, index: 0, entered: now, child: null });
    Object.assign(this, { counters: Object.create(null), timers: Object.create(null) });
    this.trees = built.trees;
    this.names = automaton.states.map((state) => state.name);
    this.features = automaton.features.map((feature) => ({ ...feature, label: label(feature.name, feature.binding) }));
  }

  get state() { return this.automaton.states[this.index]; }
  get flag() { return this.state.flag ?? null; }

  value({ name, sort = "body", binding, kind }, readings, now) {
    if (sort === "flag") return Number(this.child instanceof Running && this.child.flag === name);
    if (sort === "counter") return this.counters[name] ?? 0;
    if (sort === "timer") return name in this.timers ? elapsed(now, this.timers[name]) : NaN;
    if (sort === "time in state") return elapsed(now, this.entered);
    const { reading, of, fresh, expression } = parts.features[name];
    const bound = substitute(binding, this.binding);
    if (fresh !== null && this.entered === now) return fresh;
    if (reading === null) return fit(kind, evaluate(expression, bound, readings));
    return readings[of === null ? reading : `${reading}(${bound[of]})`];
  }

  // Returns the next state's index or -1, and the index of the leaf, -1 if nothing was shown there.
  decide(nodes, readings, now) {
    let at = 0;
    for (;;) {
      const node = nodes[at];
      if (node.node === "stay") return [-1, at];
      if (node.node === "go") return [this.names.indexOf(node.to), at];
      const feature = this.features.find((each) => each.label === node.feature);
      const x = this.value(feature, readings, now);
      let next;
      if (node.node === "absent") next = absent(x) ? node.yes : node.no;
      else if (absent(x)) next = node.absent;
      else if (node.node === "below") next = x < node.cut ? node.yes : node.no;
      else if (node.node === "label") next = node.branches[labels(feature.kind)[x]];
      else if (node.from <= node.to) next = node.from <= x && x < node.to ? node.yes : node.no;
      else next = x >= node.from || x < node.to ? node.yes : node.no;
      if (next === "stay") return [-1, -1];
      at = next;
    }
  }

  // Query, switch, pulse: the basic behavior to run, as a name and its binding.
  pulse(readings, now, trace) {
    const before = this.index;
    const tree = this.flag === null ? this.trees[this.state.name] ?? this.stateless() : undefined;
    const [next, leaf] = tree ? this.decide(tree, readings, now) : [-1, -2];
    if (next !== -1 && next !== before) this.enter(next, now);
    trace.push([label(this.automaton.name, this.binding, this.automaton.parameters), before, leaf, this.index]);
    if (this.child instanceof Running) return this.child.pulse(readings, now, trace);
    return { name: this.state.behavior, binding: this.child ?? {}, since: this.entered };
  }

  stateless() { return this.automaton.stateless ? this.trees["*"] : undefined; }

  enter(next, now) {
    Object.assign(this, { index: next, entered: now, child: null });
    const { behavior } = this.state;
    if (!behavior) return;
    const bound = substitute(this.state.binding, this.binding);
    this.child = behavior in documents ? new Running(behavior, bound, now) : bound;
    for (const { action, of, name, value } of parts.behaviors[behavior]?.changes ?? []) {
      const kept = of === "counter" ? this.counters : this.timers;
      if (action === "reset") delete kept[name];
      else if (action === "increment") kept[name] = (kept[name] ?? 0) + value;
      else kept[name] = of === "counter" ? value : now;
    }
  }
}

function labels(kind) {
  return kind === "boolean" ? ["no", "yes"] : kind.slice("categorical(".length, -1).split("|");
}

function command({ name, binding, since }, readings, now) {
  if (parts.is_coordinator) return [basicOf(name, binding), Number(since === now)];
  const values = name === undefined || name === null ? {} : parts.behaviors[name].command;
  if (values === null) throw new Error(`${name} is computed by code that could not be translated`);
  return parts.channels.map(({ channel, rest }) => {
    const value = channel in values ? evaluate(values[channel], binding, readings) : rest;
    return Number.isFinite(value) ? value : rest;
  });
}

// The first is the basic behavior idle, which has no name in a document.
function basicOf(name, binding) {
  return name ? parts.basics.lastIndexOf(label(name, binding, parts.behaviors[name].parameters)) : 0;
}

const [header, ...lines] = read("conformance.csv").trim().split("\n");
const columns = header.split(",");
const first = 2 + parts.readings.length;
const tracing = process.argv[2] === "--trace";
let root, ticks = 0, mismatches = 0;
if (tracing) console.log(parts.trace_header);
for (const line of lines) {
  const fields = line.split(",");
  const now = Number(fields[1]);
  const readings = {};
  parts.readings.forEach((name, index) => {
    readings[name] = fields[2 + index] === "" ? NaN : finite(Number(fields[2 + index]));
  });
  if (fields[0] === "1") root = new Running(parts.root, parts.binding, now);
  const trace = [], path = [], flags = [];
  const basic = root.pulse(readings, now, trace);
  for (let each = root; each instanceof Running; each = each.child) {
    path.push(each.index);
    flags.push(parts.flags.indexOf(each.flag) + 1);
  }
  const found = [path.join("."), flags.join("."), basicOf(basic.name, basic.binding)];
  const right = found.every((each, index) => fields[first + index] === String(each))
    && command(basic, readings, now).every((each, index) => Number(fields[first + 3 + index]) === each);
  ticks += 1;
  if (!right && ++mismatches <= 5) console.error(`line ${ticks + 1} of conformance.csv is decided otherwise`);
  const level = ([name, ...rest]) => [parts.automata.indexOf(name), ...rest].join(".");
  if (tracing) console.log([fields[1], ...trace.map(level)].join(","));
}
if (!tracing) console.log(`${ticks} ticks, ${mismatches} mismatches`);
process.exitCode = mismatches || !ticks || columns.length < first ? 1 : 0;
