/**
 * A training session in a notebook: the picture of its world, the buttons of its states, and its automaton.
 *
 * The kernel sends plain data (see view_data.py) and decides everything; this page draws it, and sends requests
 * (see widget_request.py). It needs no build step and no library.
 */

const REPORT_MS = 2000; // how often a view on the screen says so; session_driver.py has the same number
const ARROWS = { up: "↑", down: "↓", left: "←", right: "→" };
const COMMANDS = {
  " ": "pause", ".": "step", t: "toggle_mode", Enter: "confirm", u: "undo", U: "redo", r: "restart", n: "new_world",
  A: "ask", s: "save", M: "toggle_score",
};
const TALLEST_PX = 560, TALLEST_STACKED_PX = 400; // so that the buttons beside or below the picture are on the screen
const JUMP_M = 1.0; // a robot that is farther from where it was has been put there

function render({ model, el }) {
  const view = Math.random().toString(36).slice(2);
  const send = (action, more = {}) => model.send({ action, ...more });
  const parts = makeParts(send);
  const { root } = parts;
  el.append(root);

  const picture = makePicture(parts.canvas, model, root);
  const show = {
    panel: () => { showPanel(parts, model); picture.draw(); },
    lesson: () => { showLesson(parts, model, send); showPanel(parts, model); showMoment(parts, model); },
    moment: () => showMoment(parts, model),
    arena: () => picture.draw(),
    objects: () => picture.draw(),
    trail: () => {},
    robots: () => picture.move(),
  };
  for (const [name, update] of Object.entries(show)) {
    model.on(`change:${name}`, update);
    update();
  }

  root.addEventListener("keydown", (event) => pressKey(event, parts, model, send));
  root.addEventListener("click", (event) => {
    if (event.detail > 0) root.focus({ preventScroll: true }); // a click with the mouse: keys are commands again
  });
  const stopKeys = keepPlainKeys(root);
  const stopTheme = followTheme(root, picture.draw);
  const resized = new ResizeObserver(() => { arrange(parts); picture.draw(); });
  resized.observe(root);
  const stopReports = reportWhileVisible(root, () => send("show", { view }), () => send("hide", { view }));

  return () => {
    for (const [name, update] of Object.entries(show)) model.off(`change:${name}`, update);
    stopReports();
    stopKeys();
    stopTheme();
    resized.disconnect();
  };
}

// Parts

function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "onclick") element.addEventListener("click", value);
    else if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function makeButton(label, key, title, onclick) {
  const button = make("button", { type: "button", title, onclick }, make("span", { class: "label" }, label));
  if (key) button.append(make("kbd", { "aria-hidden": "true" }, key));
  return button;
}

function makeParts(send) {
  const parts = {
    title: make("h3"),
    mode: make("span", { class: "mode" }),
    path: make("span", { class: "path" }),
    count: make("span", { class: "count" }),
    time: make("span", { class: "time" }),
    canvas: make("canvas", { role: "img" }),
    where: make("figcaption"),
    status: make("p", { class: "status", role: "status" }),
    changed: make("div", { class: "changed", hidden: "" }),
    score: make("p", { class: "score", "aria-live": "polite", "aria-label": "In new worlds" }),
    question: make("div", { class: "question", role: "group", "aria-label": "Question", hidden: "" }),
    states: make("div", { class: "states", role: "group", "aria-label": "States" }),
    readings: make("dl", { class: "readings", "aria-label": "Readings" }),
    graph: make("div", { class: "graph", role: "region", "aria-label": "Automaton", tabindex: "0" }),
    rules: make("ol", { class: "rules", "aria-label": "Transitions" }),
  };
  const command = (label, key, title, action) => makeButton(label, key, title, () => send(action));
  parts.change = makeChange(() => send("undo"));
  parts.changed.append(...Object.values(parts.change));
  parts.scored = make("span");
  parts.toggleScore = make("button", { type: "button", class: "link", onclick: () => send("toggle_score") });
  parts.score.append(parts.scored, " ", parts.toggleScore);
  parts.teach = command("Teach", "t", "Each press teaches (t)", "toggle_mode");
  parts.try = command("Try", "t", "The automaton decides; a press corrects it (t)", "toggle_mode");
  parts.pause = command("Pause", "space", "Pause or resume the world (Space)", "pause");
  parts.restart = command("Restart", "r", "Restart the automaton where the robot is; records nothing (r)", "restart");
  parts.world = command("New world", "n", "Begin another world; records nothing (n)", "new_world");
  parts.undo = command("Undo", "u", "Nothing to undo", "undo");
  parts.redo = command("Redo", "U", "Nothing to redo", "redo");
  parts.ask = command("Ask when unsure", "A", "Let the robot pause and ask where it is unsure (A)", "ask");
  parts.save = command("Save", "s", "Save the automaton in the library (s)", "save");
  parts.confirm = command("Confirm", "Enter", "The present state is right: record that (Enter)", "confirm");
  const modes = make("div", { class: "modes", role: "group", "aria-label": "Mode" }, parts.teach, parts.try);
  const commands = make(
    "div", { class: "commands", role: "toolbar", "aria-label": "Session" },
    modes, parts.pause, parts.restart, parts.world, parts.undo, parts.redo, parts.ask, parts.save,
  );
  const desk = make(
    "div", { class: "desk" }, commands, parts.status, parts.changed, parts.score, parts.question, parts.states, parts.readings,
  );
  const automaton = make("div", { class: "automaton" }, parts.graph, parts.rules);
  parts.root = make(
    "div",
    { class: "understudy", tabindex: "0", role: "application" },
    make("header", {}, parts.title, parts.mode, parts.path, parts.count, parts.time),
    make("div", { class: "columns" }, make("figure", {}, parts.canvas, parts.where), desk, automaton),
  );
  return parts;
}

/** What a press changed beyond what it says: a line, and on request each decision with its conditions. */
function makeChange(undo) {
  const decisions = make("div", { hidden: "" });
  const show = makeButton("Show me", "D", "What these decisions looked like, and look like now (D)", () => {
    decisions.hidden = !decisions.hidden;
    show.setAttribute("aria-expanded", String(!decisions.hidden));
  });
  show.setAttribute("aria-expanded", "false");
  return {
    line: make("span", { role: "status" }), undo: makeButton("Undo", "u", "Take the last step back (u)", undo), show,
    decisions,
  };
}

// What the panel, the lesson and the moment show

function showPanel(parts, model) {
  const panel = model.get("panel");
  const trying = panel.mode === "testing";
  parts.root.setAttribute("aria-label", `Session: ${panel.title}`);
  parts.root.dataset.mode = trying ? "testing" : "training";
  parts.title.textContent = panel.title;
  parts.mode.textContent = panel.paused ? "paused" : trying ? "trying" : "teaching";
  parts.teach.setAttribute("aria-pressed", String(!trying));
  parts.try.setAttribute("aria-pressed", String(trying));
  parts.teach.disabled = !trying;
  parts.try.disabled = trying;
  parts.try.classList.toggle("next", panel.corrected);
  setLabel(parts.pause, panel.paused ? "Resume" : "Pause");
  parts.undo.disabled = panel.undoable === null;
  parts.undo.title = panel.undoable === null ? "Nothing to undo" : `Undo: ${panel.undoable} (u)`;
  parts.redo.disabled = panel.redoable === null;
  parts.redo.title = panel.redoable === null ? "Nothing to redo" : `Redo: ${panel.redoable} (U)`;
  parts.ask.setAttribute("aria-pressed", String(panel.asks));
  parts.save.hidden = !panel.can_save;
  parts.save.disabled = !panel.unsaved;
  parts.status.textContent = panel.status.text;
  parts.status.dataset.tone = panel.status.tone;
  showChange(parts, panel.changed);
  showScore(parts, panel.score);
  for (const button of parts.states.children) {
    button.classList.toggle("waiting", button.dataset.state === panel.waiting);
  }
  parts.count.textContent = `${panel.examples} example${panel.examples === 1 ? "" : "s"}`;
  showQuestion(parts, panel.question);
}

function showChange({ changed, change }, summary) {
  changed.hidden = summary === null;
  if (summary === null) return;
  change.line.textContent = `Changed: ${summary.line}`;
  change.decisions.replaceChildren(
    ...summary.decisions.flatMap(({ said, gone, new: now }) => [
      make("p", {}, said),
      ...gone.map((when) => make("p", { class: "gone" }, `− ${when}`)),
      ...now.map((when) => make("p", { class: "new" }, `+ ${when}`)),
    ]),
  );
}

function showScore({ score, scored, toggleScore }, { text, trend, on }) {
  score.hidden = text === "" && on;
  score.dataset.trend = trend;
  scored.textContent = text;
  toggleScore.textContent = on ? "turn off" : "turn on";
  toggleScore.title = "After each press it runs in worlds that it was not taught in, beside the one here (M)";
  toggleScore.setAttribute("aria-pressed", String(on));
}

function setLabel(button, label) {
  button.querySelector(".label").textContent = label;
}

function showQuestion(parts, question) {
  parts.question.hidden = question === null;
  for (const button of parts.states.children) {
    button.classList.toggle("likely", question !== null && question.answers.includes(button.dataset.state));
  }
  if (question !== null) parts.question.textContent = question.sentence;
}

function showLesson(parts, model, send) {
  const { states, transitions, svg } = model.get("lesson");
  parts.states.replaceChildren(
    ...states.map((state) => {
      const keys = `${ARROWS[state.arrow] ?? ""}${state.key}`;
      const runs = state.flag !== null ? `raises ${state.flag}` : state.runs === null ? "idles" : `runs ${state.runs}`;
      const button = makeButton(state.name, keys, `${runs} (${keys})`, () => send("press", { state: state.name }));
      button.dataset.state = state.name;
      return button;
    }),
    parts.confirm,
  );
  parts.rules.replaceChildren(
    ...transitions.map((each) => {
      const badge = make("span", { class: "badge", style: `color: ${each.color}` }, String(each.number));
      const way = make("b", {}, `${each.from} → ${each.to}`);
      return make("li", {}, badge, make("span", {}, way, ` ${each.when.join(", or ") || "always"}`));
    }),
  );
  parts.graph.innerHTML = svg;
  requestAnimationFrame(() => arrange(parts));
}

/** Crop the drawing to its graph, since its list of conditions stands below as text, which is never too small. */
function arrange(parts) {
  const graph = parts.graph.querySelector("[data-state]")?.parentNode;
  if (!graph || !parts.graph.clientWidth) return;
  const svg = graph.ownerSVGElement;
  const { x, y, width, height } = graph.getBBox();
  const at = graph.transform.baseVal.consolidate()?.matrix ?? { e: 0, f: 0 };
  const edge = 12;
  svg.setAttribute("viewBox", `${x + at.e - edge} ${y + at.f - edge} ${width + 2 * edge} ${height + 2 * edge}`);
  svg.setAttribute("width", width + 2 * edge);
  svg.setAttribute("height", height + 2 * edge);
  const room = parts.root.querySelector(".desk").clientWidth;
  parts.root.classList.toggle("spread", width > 1.5 * room); // too wide beside the world: below it
}

function showMoment(parts, model) {
  const { time, state, path, readings } = model.get("moment");
  parts.time.textContent = time;
  for (const button of parts.states.children) {
    const current = button.dataset.state === state;
    button.classList.toggle("current", current);
    button.setAttribute("aria-current", String(current));
  }
  for (const box of parts.graph.querySelectorAll("[data-state]")) {
    box.classList.toggle("current", box.dataset.state === state);
  }
  const rows = readings.map(([label, value]) => make("div", {}, make("dt", {}, label), make("dd", {}, value)));
  parts.readings.replaceChildren(...rows);
  parts.path.textContent = path.length > 1 ? path.join(" › ") : "";
  parts.canvas.setAttribute("aria-label", `The world at ${time}; the robot is in ${path.join(", in ")}`);
  const { scenario, seed } = model.get("arena");
  parts.where.textContent = `${scenario}, world ${seed}`;
}

// Keys

/**
 * Keep plain keys from JupyterLab, where 1 would make a heading of the cell and d d delete it; Ctrl+S still saves.
 *
 * It looks for this attribute when a key reaches the document, which is after the window.
 */
function keepPlainKeys(root) {
  const mark = (event) => {
    const plain = !(event.ctrlKey || event.metaKey || event.altKey);
    root.toggleAttribute("data-lm-suppress-shortcuts", plain);
  };
  window.addEventListener("keydown", mark, true);
  return () => window.removeEventListener("keydown", mark, true);
}

function pressKey(event, parts, model, send) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const onButton = event.target !== parts.root && event.target.closest("button") !== null;
  if (event.key === "Escape") {
    event.target.blur(); // the notebook's own keys work again
    return;
  }
  if (event.key === "Tab" || (onButton && (event.key === " " || event.key === "Enter"))) return;
  if (event.key === "D" && !parts.changed.hidden) parts.change.show.click();
  const request = findRequest(event.key, model);
  if (request === null) return;
  event.preventDefault();
  event.stopPropagation();
  if (!event.repeat) send(request.action, request);
}

function findRequest(key, model) {
  const arrow = key.startsWith("Arrow") ? key.slice(5).toLowerCase() : "";
  const state = model.get("lesson").states.find((each) => each.key === key || (arrow && each.arrow === arrow));
  if (state !== undefined) return { action: "press", state: state.name };
  return key in COMMANDS ? { action: COMMANDS[key] } : null;
}

// The picture of the world

function makePicture(canvas, model, root) {
  let before = new Float32Array(), after = new Float32Array(), since = 0, lasts = 100, pending = 0;

  /** Glide from where the robots are drawn to where they are, in the time between two ticks. */
  function move() {
    const now = performance.now();
    const drawn = poses(now);
    after = floats(model.get("robots"));
    before = drawn.length === after.length ? drawn : after;
    lasts = Math.min(Math.max(now - since, 16), 100);
    since = now;
    draw();
  }

  function poses(now) {
    const share = Math.min((now - since) / lasts, 1);
    if (share >= 1 || before.length !== after.length) return after;
    const mixed = new Float32Array(after);
    for (let at = 0; at < after.length; at += 4) {
      const dx = after[at] - before[at], dy = after[at + 1] - before[at + 1];
      if (Math.hypot(dx, dy) > JUMP_M) continue;
      const turn = Math.atan2(Math.sin(after[at + 2] - before[at + 2]), Math.cos(after[at + 2] - before[at + 2]));
      mixed[at] = before[at] + share * dx;
      mixed[at + 1] = before[at + 1] + share * dy;
      mixed[at + 2] = before[at + 2] + share * turn;
    }
    return mixed;
  }

  function draw() {
    if (!pending) pending = requestAnimationFrame(paint);
  }

  function paint(now) {
    pending = 0;
    const arena = model.get("arena");
    const room = canvas.parentElement.clientWidth;
    if (!room || !arena.width) return;
    const sharp = window.devicePixelRatio || 1;
    const tallest = room > 0.8 * root.clientWidth ? TALLEST_STACKED_PX : TALLEST_PX;
    const width = Math.min(room, Math.round((tallest * arena.width) / arena.height));
    const height = Math.round((width * arena.height) / arena.width);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    if (canvas.width !== Math.round(width * sharp)) canvas.width = Math.round(width * sharp);
    if (canvas.height !== Math.round(height * sharp)) canvas.height = Math.round(height * sharp);
    const pen = canvas.getContext("2d");
    const scale = width / arena.width;
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    const spot = (x, y) => [x * scale, height - y * scale];
    const style = getComputedStyle(root);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    const robots = poses(performance.now());
    drawGround({ pen, scale, spot, color, width, height }, arena);
    drawTrail({ pen, spot, color }, floats(model.get("trail")));
    for (const thing of model.get("objects")) drawObject({ pen, scale, spot, color }, thing);
    drawRobots({ pen, scale, spot, color }, arena, robots, model.get("moment").targets);
    if (performance.now() - since < lasts) draw();
  }

  return { move, draw };
}

function floats(data) {
  const bytes = data instanceof DataView ? data : new DataView(new ArrayBuffer(0));
  return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
}

function disc(pen, x, y, radius) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
}

function drawGround({ pen, scale, spot, color, width, height }, arena) {
  pen.fillStyle = color("ground");
  pen.fillRect(0, 0, width, height);
  const step = [1, 2, 5, 10, 20, 50].find((each) => each * scale >= 24) ?? 100;
  pen.beginPath();
  for (let x = step; x < arena.width; x += step) pen.rect(...spot(x, arena.height), 0, height);
  for (let y = step; y < arena.height; y += step) pen.rect(...spot(0, y), width, 0);
  pen.strokeStyle = color("grid");
  pen.lineWidth = 1;
  pen.stroke();
  pen.fillStyle = color("solid");
  for (const corners of arena.polygons) {
    pen.beginPath();
    for (const [x, y] of corners) pen.lineTo(...spot(x, y));
    pen.fill();
  }
  for (const [x, y, radius, paint] of arena.discs) {
    disc(pen, ...spot(x, y), radius * scale);
    pen.fillStyle = paint;
    pen.fill();
  }
  pen.beginPath();
  for (const [x0, y0, x1, y1] of arena.walls) {
    pen.moveTo(...spot(x0, y0));
    pen.lineTo(...spot(x1, y1));
  }
  pen.strokeStyle = color("ink");
  pen.lineWidth = 2.5;
  pen.lineCap = "round";
  pen.stroke();
}

function drawTrail({ pen, spot, color }, places) {
  pen.beginPath();
  for (let at = 0; at < places.length; at += 2) pen.lineTo(...spot(places[at], places[at + 1]));
  pen.strokeStyle = color("trail");
  pen.lineWidth = 1.5;
  pen.lineJoin = "round";
  pen.stroke();
}

function drawObject({ pen, scale, spot, color }, thing) {
  const [x, y] = spot(thing.x, thing.y);
  const size = Math.max(thing.size * scale, 4);
  const shape = (half) => {
    pen.beginPath();
    if (thing.square) pen.roundRect(x - half, y - half, 2 * half, 2 * half, half * 0.3);
    else pen.arc(x, y, half, 0, 2 * Math.PI);
  };
  pen.fillStyle = thing.color;
  pen.strokeStyle = thing.color;
  shape(size);
  if (thing.full < 1) {
    pen.globalAlpha = 0.25;
    pen.fill();
    pen.globalAlpha = 1;
    shape(size * thing.full);
  }
  pen.fill();
  if (thing.label) write(pen, thing.label, x + size + 5, y + 4, color("soft"));
}

function write(pen, text, x, y, color) {
  pen.font = "12px ui-sans-serif, system-ui, sans-serif";
  pen.fillStyle = color;
  const wide = pen.measureText(text).width;
  const shown = pen.canvas.clientWidth;
  pen.fillText(text, Math.max(2, Math.min(x, shown - wide - 4)), y);
}

function drawRobots({ pen, scale, spot, color }, arena, robots, targets) {
  const count = robots.length / 4;
  const mine = arena.robot;
  if (mine < count) {
    pen.setLineDash([2, 5]);
    pen.strokeStyle = color("soft");
    pen.lineWidth = 1;
    for (const place of targets ?? []) {
      pen.beginPath();
      pen.moveTo(...spot(robots[4 * mine], robots[4 * mine + 1]));
      pen.lineTo(...spot(...place));
      pen.stroke();
    }
    pen.setLineDash([]);
  }
  for (let robot = 0; robot < count; robot += 1) if (robot !== mine) drawRobot(robot);
  if (mine < count) drawRobot(mine);

  function drawRobot(robot) {
    const [px, py, heading, stored] = robots.subarray(4 * robot, 4 * robot + 4);
    const [x, y] = spot(px, py);
    const radius = Math.max(arena.radii[robot] * scale, robot === mine ? 6 : 3);
    const line = robot === mine ? color("mode") : (arena.colors[robot] ?? color("robot"));
    if (robot === mine) {
      disc(pen, x, y, radius + 8);
      pen.fillStyle = line;
      pen.globalAlpha = 0.18;
      pen.fill();
      pen.globalAlpha = 1;
    }
    disc(pen, x, y, radius);
    pen.fillStyle = color("pane");
    pen.fill();
    pen.moveTo(x, y);
    pen.lineTo(x + radius * Math.cos(heading), y - radius * Math.sin(heading));
    pen.strokeStyle = line;
    pen.lineWidth = robot === mine ? 2.5 : 1.5;
    pen.stroke();
    if (robot === mine && stored > 0) write(pen, `carries ${stored}`, x + radius + 9, y + radius + 9, color("soft"));
  }
}

// Light and dark, on the screen and not

/** Make the widget dark where it lies on a dark ground, in any notebook; `changed` is called when that changes. */
function followTheme(root, changed) {
  const apply = () => {
    const dark = isDark(root.parentElement);
    if (root.classList.contains("dark") !== dark || !root.dataset.themed) {
      root.classList.toggle("dark", dark);
      root.dataset.themed = "yes";
      changed();
    }
  };
  const observer = new MutationObserver(() => requestAnimationFrame(apply));
  for (const each of [document.documentElement, document.body]) observer.observe(each, { attributes: true });
  const preference = window.matchMedia("(prefers-color-scheme: dark)");
  preference.addEventListener("change", apply);
  requestAnimationFrame(apply);
  return () => {
    observer.disconnect();
    preference.removeEventListener("change", apply);
  };
}

function isDark(element) {
  for (let each = element; each !== null; each = each.parentElement) {
    const [red, green, blue, alpha = 1] = (getComputedStyle(each).backgroundColor.match(/[\d.]+/g) ?? []).map(Number);
    if (red !== undefined && alpha > 0.5) return 0.299 * red + 0.587 * green + 0.114 * blue < 128;
  }
  return window.matchMedia("(prefers-color-scheme: dark)").matches;
}

/** Call `shown` when the element comes onto the screen and regularly while it is there, and `hidden` when it leaves. */
function reportWhileVisible(element, shown, hidden) {
  let inside = false, told = false;
  const report = () => {
    const visible = inside && document.visibilityState === "visible";
    if (visible) shown();
    else if (told) hidden();
    told = visible;
  };
  const observer = new IntersectionObserver((entries) => {
    inside = entries.at(-1).isIntersecting;
    report();
  });
  observer.observe(element);
  document.addEventListener("visibilitychange", report);
  const timer = setInterval(report, REPORT_MS);
  return () => {
    observer.disconnect();
    document.removeEventListener("visibilitychange", report);
    clearInterval(timer);
    if (told) hidden();
  };
}

export default { render };
