"use strict";
// State: inputs of the form by path, rigid contact of the pair (and of one to compare with), the last elastic position.
const $ = id => document.getElementById(id);
const state = { inputs: {}, lateral: 0, yaw: 0, free: false, rigid: null, other: null, elastic: null, sweep: [],
  number: 0, frames: [], readings: {} };
const WAIT_MS = 120;  // standing still before a position is computed

async function ask(name, body) {
  const response = await fetch(name, { method: "POST", body: JSON.stringify(body) });
  const answer = await response.json().catch(() => ({ error: "the server has stopped" }));
  if (!response.ok) throw Object.assign(new Error(answer.error), { status: response.status });
  return answer;
}

// ---- inputs -------------------------------------------------------------------------------------------------------
const PATHS = { wheel: "wheelset.wheel", rail: "track.rail" }, LATERAL = "position.lateral_mm", YAW = "position.yaw_mrad";
const READ_OPTIONS = ["mirror", "unit", "tape_mm"];  // by which the case reads a dropped file too
// what the page has elsewhere, and a place in a table of friction, which is no profile to drop
const OUTSIDE = [...Object.values(PATHS).flatMap(path => [path, ...READ_OPTIONS.map(name => `${path}.${name}`)]), LATERAL, YAW,
  "rolling.friction.distance_m"];

function inputsNow(changes = {}) {
  const inputs = { ...state.inputs, [PATHS.wheel]: $("wheel").value, [PATHS.rail]: $("rail").value, ...changes };
  if (state.yaw) inputs[YAW] = String(state.yaw);
  if (!state.free && !(LATERAL in changes)) inputs[LATERAL] = String(state.lateral);
  return inputs;
}

// a group for each table, and in it one for each table inside; names are those of the input in its group
function makeForm(form) {
  for (const [caption, rows] of form.groups) {
    const shown = rows.filter(row => !OUTSIDE.includes(row[4])), groups = new Map();
    const groupOf = (name, words, above) => {
      const group = element("details"), grid = element("div");
      group.append(element("summary", words), grid);
      group.open = caption === "Load and curve";
      grid.className = "grid";
      groups.set(name, grid);
      above.append(group);
    };
    if (shown.length) groupOf("", caption, $("form"));
    for (const row of shown) {
      const [, table, inner] = row[4].split(".");
      if (inner && !groups.has(table)) groupOf(table, table, groups.get("").parentNode);
    }
    for (const row of shown) {
      const [, ...names] = row[0].split("."), inside = groups.has(names[0]);
      groups.get(inside ? names[0] : "").append(field(row, inside && names.length > 1 ? names.slice(1) : names));
    }
  }
}

function field([path, initial, allowed, meaning], names) {
  const label = element("label", names.join(".")), words = allowed.split(" or ");
  const choice = words.length > 1 && words.every(word => /^[a-z][\w.-]*$/i.test(word));
  const input = element(choice ? "select" : "input");
  if (choice) for (const word of new Set([initial, ...words])) input.add(new Option(word, word === initial ? "" : word));
  else input.placeholder = initial;
  input.id = `input-${path}`;
  label.title = `${meaning}; ${allowed}`;
  label.append(input);
  input.addEventListener("change", () => {
    if (input.value.trim()) state.inputs[path] = input.value; else delete state.inputs[path];
    input.classList.toggle("changed", Boolean(input.value.trim()));
    loadGeometry();
  });
  return label;
}

function fillProfiles(form) {
  for (const [id, kind, none] of [["wheel", "wheel"], ["rail", "rail"], ["other-wheel", "wheel", "no other wheel"],
    ["other-rail", "rail", "no other rail"]]) {
    const select = $(id), before = select.value;
    select.replaceChildren();
    if (none) select.add(new Option(none, ""));
    for (const name of [...form.profiles[kind], ...(form.own || {})[kind] || []]) select.add(new Option(name, name));
    if ([...select.options].some(option => option.value === before)) select.value = before;
  }
}

// ---- files --------------------------------------------------------------------------------------------------------
const own = { wheel: [], rail: [] };

async function readFile(name, content, options = {}) {
  const query = new URLSearchParams({ name, options: JSON.stringify(options) });
  $("file-error").hidden = true;
  try {
    const response = await fetch(`profile?${query}`, { method: "POST", body: content });
    const answer = await response.json();
    if (!response.ok) throw new Error(answer.error);
    if (!own[answer.kind].includes(answer.name)) own[answer.kind].push(answer.name);
    fillProfiles({ ...state.form, own });
    $(answer.kind).value = answer.name;
    readWith(answer.kind, options);
    showReading(answer, options);
    await loadGeometry();
  } catch (error) {
    $("file-error").textContent = error.message;
    $("file-error").hidden = false;
  }
}

function readWith(kind, options) {
  for (const option of READ_OPTIONS) {
    const path = `${PATHS[kind]}.${option}`;
    if (option in options) state.inputs[path] = String(options[option]); else delete state.inputs[path];
  }
}

function showReading(answer, options) {
  const { kind } = answer, block = $(`read-${kind}`), of = name => block.querySelector(name);
  if (!block.firstChild) {
    block.append($("reading").content.cloneNode(true));
    of("button").addEventListener("click", () => readAgain(kind));
    of(".of-wheels").hidden = kind !== "wheel";
  }
  state.readings[kind] = answer;
  block.hidden = false;
  for (const name of READ_OPTIONS) of(`.${name}`).value = options[name] ?? "";
  of(".words").textContent =
    `${answer.name}: ${kind}, ${answer.format}, ${answer.measured.length} points. ${answer.notices.join(" ")}`;
  drawReadings();
}

function drawReadings() {
  for (const [kind, { measured, surface }] of Object.entries(state.readings)) {
    const { context, width, height } = fresh($(`read-${kind}`).querySelector("canvas")), all = measured.concat(surface);
    const [x0, x1] = span(all.map(p => p[0])), [y0, y1] = span(all.map(p => p[1]));
    const scale = Math.min((width - 20) / (x1 - x0 || 1), (height - 20) / (y1 - y0 || 1));
    const at = p => [width / 2 + scale * (p[0] - (x0 + x1) / 2), height / 2 - scale * (p[1] - (y0 + y1) / 2)];
    line(context, surface.map(at), colour("--focus"), 2);
    context.fillStyle = colour("--other");
    for (const p of measured.map(at)) context.fillRect(p[0] - 1, p[1] - 1, 2, 2);
  }
}

function readAgain(kind) {
  const given = name => $(`read-${kind}`).querySelector(`.${name}`).value.trim(), options = {};
  if (given("mirror")) options.mirror = given("mirror") === "true";
  if (given("unit")) options.unit = given("unit");
  if (given("tape_mm")) options.tape_mm = Number(given("tape_mm").replace(",", "."));
  return readFile(state.readings[kind].name, new Blob([]), options);
}

// another profile is read anew, without the options of the one before
function chosen(kind) {
  const name = $(kind).value;
  if (own[kind].includes(name)) return readFile(name, new Blob([]));
  readWith(kind, {});
  $(`read-${kind}`).hidden = true;
  return loadGeometry();
}

async function dropped(list) {
  for (const file of list) await readFile(file.name, file);
}

// ---- rigid contact ------------------------------------------------------------------------------------------------
let asked = 0, loading = null;
// One request after the other: what changed meanwhile, as a yaw that is being dragged, is asked for once, at the end.
function loadGeometry() {
  asked += 1;
  stale();
  clearTimeout(timer);
  return loading ??= geometries().finally(() => { loading = null; });
}

async function geometries() {
  for (let answered = 0; answered !== asked;) {
    answered = asked;
    try {
      const inputs = inputsNow();
      delete inputs[LATERAL];
      const rigid = await ask("geometry", inputs);
      const changed = Object.keys(PATHS).filter(kind => $(`other-${kind}`).value);
      const other = changed.length ? await ask("geometry", comparedWith(inputs, changed)) : null;
      Object.assign(state, { rigid, other, sweep: [] });
      const low = rigid.lateral[0], high = rigid.lateral.at(-1);
      Object.assign($("lateral"), { min: low, max: high });
      state.lateral = Math.min(Math.max(state.lateral, low), high);
      $("pair").textContent = `Wheel: ${rigid.sides.right.titles.wheel}. Rail: ${rigid.sides.right.titles.rail}.`;
      showError("");
      if (answered === asked) moved(); else requestAnimationFrame(drawRigid);
    } catch (error) {
      if (answered === asked) failed(error);
    }
  }
}

// the same inputs with the other profiles, without the options of the files in their place
function comparedWith(inputs, kinds) {
  const second = { ...inputs };
  for (const kind of kinds) {
    for (const path of Object.keys(second)) if (path.startsWith(`${PATHS[kind]}.`)) delete second[path];
    second[PATHS[kind]] = $(`other-${kind}`).value;
  }
  return second;
}

// linear interpolation of a table over the lateral position
function interpolated(table, values, lateral) {
  const x = table.lateral, step = x[1] - x[0];
  const place = Math.min(Math.max((lateral - x[0]) / step, 0), x.length - 1.000001), i = Math.floor(place), t = place - i;
  const a = values[i], b = values[i + 1];
  return Array.isArray(a) ? a.map((v, k) => v + t * (b[k] - v)) : a + t * (b - a);
}

function positionAt(table, lateral) {
  const of = values => interpolated(table, values, lateral);
  return { lateral, vertical: of(table.vertical), roll: of(table.roll), difference: of(table.difference),
    left: { point: of(table.sides.left.points), angle: of(table.sides.left.angles), radius: of(table.sides.left.radii) },
    right: { point: of(table.sides.right.points), angle: of(table.sides.right.angles),
      radius: of(table.sides.right.radii) } };
}

function showSliders() {
  $("lateral").value = state.lateral;
  $("yaw").value = state.yaw;
  $("lateral-text").textContent = inUnit(state.lateral, "mm", 2);
  $("yaw-text").textContent = `${fixed(state.yaw, 1)} mrad`;
}

let timer = 0;
function moved() {
  showSliders();
  requestAnimationFrame(drawRigid);
  stale();
  clearTimeout(timer);
  timer = setTimeout(loadPosition, WAIT_MS);
}

// ---- elastic position -----------------------------------------------------------------------------------------------
function stale() {
  state.number += 1;
  status("busy", "computing …");
  for (const id of ["facts", "patches", "tables"]) $(id).classList.add("stale");
}

let positionAnswer = Promise.resolve(); // the position that is being computed

async function loadPosition() {
  if (!state.rigid) return;
  if (lasting) return status("busy", "waiting until the report or the curves are done");
  const number = ++state.number;
  try {
    positionAnswer = ask("position", inputsNow());
    const elastic = await positionAnswer;
    if (number !== state.number) return;
    state.elastic = elastic;
    if (state.free) state.lateral = elastic.lateral_mm;
    showSliders();
    showElastic();
    await showCommand();
  } catch (error) {
    if (number === state.number && error.status !== 409) failed(error);
  }
}

function failed(error) {
  showError(error.message);
  status("failed", "no result");
}

// above the forces, and at the inputs, where it is seen while one writes
function showError(message) {
  for (const id of ["error", "input-error"]) Object.assign($(id), { textContent: message, hidden: !message });
}

function status(kind, words) {
  $("state").className = `status ${kind}`;
  $("state").textContent = words;
}

function showElastic() {
  const { elastic } = state;
  showError("");
  status(!elastic.converged ? "failed" : elastic.warnings.length ? "warned" : "good",
    `${elastic.converged ? "converged" : "not converged"}, ${elastic.message}`);
  $("warnings").replaceChildren(...elastic.warnings.map(words => element("li", words)));
  $("facts").replaceChildren(...elastic.facts.map(([value, name]) => fact(name, value)));
  const shown = element("table"), head = element("tr");
  head.append(...elastic.table.header.map(words => element("th", words)));
  shown.append(head);
  for (const [name, ...cells] of elastic.table.rows) {
    const row = element("tr");
    row.append(element("th", name), ...cells.map(cell => element("td", cell)));
    shown.append(row);
  }
  $("tables").replaceChildren(shown);
  for (const id of ["facts", "patches", "tables"]) $(id).classList.remove("stale");
  drawRigid();
  drawPatches();
}

async function showCommand() {
  try { $("command").textContent = (await ask("saved", inputsNow())).command; } catch (error) { failed(error); }
}

// ---- drawing --------------------------------------------------------------------------------------------------------
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const span = values => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
function element(kind, text = "") { const made = document.createElement(kind); made.textContent = text; return made; }
function fact(name, value) { const made = element("div"); made.append(element("dt", name), element("dd", value)); return made; }

function fresh(canvas) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio))
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height };
}

function line(context, points, stroke, width = 1, fill = null, dash = []) {
  context.beginPath();
  points.forEach((p, i) => i ? context.lineTo(p[0], p[1]) : context.moveTo(p[0], p[1]));
  if (fill) { context.closePath(); context.fillStyle = fill; context.fill(); }
  context.setLineDash(dash);
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

const HALF_VIEW_MM = 55;
let drag = null, scaleOfView = 1;

function drawRigid() {
  if (!state.rigid) return;
  const begun = performance.now(), { context, width, height } = fresh($("view"));
  const now = positionAt(state.rigid, state.lateral);
  const steel = colour("--steel"), steel2 = colour("--steel2"), ink = colour("--ink");
  ["left", "right"].forEach((side, k) => {
    const sign = k ? 1 : -1, middle = [k ? 0.75 * width : 0.25 * width, height / 2];
    const scale = scaleOfView = Math.min(width / 2, 1.25 * height) / (2 * HALF_VIEW_MM);
    const table = state.rigid.sides[side], top = table.rail.reduce((a, p) => p[1] > a[1] ? p : a);
    const at = p => [middle[0] + scale * (p[0] - top[0] + sign * 8), middle[1] - scale * (p[1] + 5)];
    context.save();
    context.beginPath();
    context.rect(k ? width / 2 + 1 : 0, 0, width / 2 - 1, height);
    context.clip();
    const placed = (points, pose, table_) => points.map(([x, y]) => {
      const c = Math.cos(pose.roll), s = Math.sin(pose.roll), h = y - table_.axle_height;
      return [c * x - s * h + pose.lateral, s * x + c * h + table_.axle_height + pose.vertical];
    });
    line(context, table.rail.map(at), ink, 1, steel2);
    line(context, placed(table.wheel, now, state.rigid).map(at), ink, 1, steel);
    if (state.other) {
      const pose = positionAt(state.other, Math.min(Math.max(state.lateral, state.other.lateral[0]),
        state.other.lateral.at(-1))), second = state.other.sides[side];
      for (const points of [second.rail, placed(second.wheel, pose, state.other)])
        line(context, points.map(at), colour("--other"), 1.5, null, [5, 4]);
    }
    const [x, y] = at(now[side].point), normal = sign * now[side].angle * Math.PI / 180;
    context.fillStyle = colour("--pressure");
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fill();
    line(context, [[x, y], [x + 45 * -Math.sin(normal), y - 45 * Math.cos(normal)]], colour("--pressure"), 2);
    context.fillStyle = colour("--soft");
    context.fillText(`${side} wheel on ${side} rail`, k ? width / 2 + 10 : 10, width < 600 ? 18 : height - 8);
    context.restore();
  });
  const numbers = [["rolling radius difference", inUnit(now.difference, "mm", 3)],
    ["contact angle, left", inUnit(now.left.angle, "°", 2)], ["contact angle, right", inUnit(now.right.angle, "°", 2)],
    ["rolling radius, left", inUnit(now.left.radius, "mm", 3)],
    ["rolling radius, right", inUnit(now.right.radius, "mm", 3)],
    ["roll", inUnit(1e3 * now.roll, "mrad", 3)], [`equivalent conicity at ${Number((3 / unitOf("mm")[1]).toPrecision(3))} ${unitOf("mm")[0]}`, conicity(state.rigid)]];
  $("rigid").replaceChildren(...numbers.map(([name, value]) => fact(name, value)));
  drawCurves();
  state.frames.push(performance.now() - begun);
}

// without the sign of a zero that round-off gives
function fixed(value, digits) {
  return (Number(value.toFixed(digits)) + 0).toFixed(digits);
}

// numbers are metric until they are shown; the larger units of the US have one decimal more
const unitOf = unit => state.form.units[unit] ?? [unit, 1];
function inUnit(value, unit, digits) {
  const [name, metric] = unitOf(unit);
  return `${fixed(value / metric, digits + (metric > 1 ? 1 : 0))} ${name}`;
}

function conicity(table) {
  const at = table.conicity[0].indexOf(3);
  return at < 0 ? "–" : table.conicity[1][at].toFixed(3);
}

function drawPatches() {
  const { context, width, height } = fresh($("patches")), sides = state.elastic.patches;
  const names = Object.keys(sides), select = $("shown");
  if (!names.length) return;
  const fields = Object.keys(sides[names[0]].stresses);
  if (select.length === 1) select.append(...fields.map(name => new Option(name, name)));
  const field = select.value, valuesOf = side => field ? sides[side].stresses[field] : sides[side].pressures;
  const highest = Math.max(...names.flatMap(valuesOf)) || 1;
  const extent = polygons => [0, 1].map(axis => span(polygons.flat().map(point => point[axis])));
  const boxes = names.map(side => extent(sides[side].polygons)), captions = names.map(side => sides[side].patches.length + 1);
  const above = 6 + 15 * Math.max(...captions), room = height - above - 50;
  const scale = Math.min(...boxes.map(([[a, b], [c, d]]) => Math.min((width / 2 - 30) / (b - a), room / (d - c))));
  names.forEach((side, k) => {
    const { polygons, outline, tractions, patches } = sides[side], [[a, b], [c, d]] = boxes[k];
    const left = side === "left" ? 0 : width / 2, ratio = context.getTransform().a;
    const whole = v => Math.round(ratio * v) / ratio;  // whole pixels: no seams between cells
    const at = ([x, y]) => [left + width / 4 + scale * (x - (a + b) / 2), above + room / 2 - scale * (y - (c + d) / 2)];
    polygons.forEach((corners, i) => {
      context.beginPath();
      corners.map(at).forEach(([x, y]) => context.lineTo(whole(x), whole(y)));
      context.fillStyle = `rgb(${heat(valuesOf(side)[i] / highest)})`;
      context.fill();
    });
    if (tractions && !field) drawTractions(context, polygons.map(corners => at(middle(corners))), tractions);
    context.beginPath();
    for (const ends of outline) ends.map(at).forEach(([x, y], i) => i ? context.lineTo(whole(x), whole(y)) : context.moveTo(whole(x), whole(y)));
    Object.assign(context, { strokeStyle: colour("--ink"), lineWidth: 1, lineCap: "square" });
    context.stroke();
    context.fillStyle = colour("--soft");
    context.fillText(`${side} rail`, left + 8, 14);
    patches.forEach(([region, cells], i) => {
      const [[x0, x1], [y0, y1]] = extent(cells.map(cell => polygons[cell]));
      context.fillText(`${region}: ${inUnit(x1 - x0, "mm", 1)} × ${inUnit(y1 - y0, "mm", 1)}`, left + 8, 29 + 15 * i, width / 2 - 12);
    });
  });
  context.fillStyle = colour("--soft");
  context.fillText(`${field || "pressure"}, maximum ${inUnit(highest, "MPa", 0)}`, 8, height - 22);
  context.fillText("from above, ahead is up"
    + (!field && names.some(side => sides[side].tractions) ? "; lines: tractions on the wheel" : ""), 8, height - 6);
}

const middle = corners => [0, 1].map(axis => corners.reduce((sum, point) => sum + point[axis], 0) / corners.length);

// an arrow in each square of the picture, at the cell that is closest to the middle of the square
const SQUARE = 18;
function drawTractions(context, centres, tractions) {
  const most = Math.max(...tractions.map(t => Math.hypot(t[0], t[1]))) || 1, squares = new Map();
  centres.forEach(([x, y], i) => {
    const square = [x, y].map(v => Math.floor(v / SQUARE)), key = String(square);
    const off = Math.hypot(x / SQUARE - square[0] - 0.5, y / SQUARE - square[1] - 0.5);
    if (!(off >= squares.get(key)?.off)) squares.set(key, { off, i });
  });
  for (const { i } of squares.values()) {
    const [x, y] = centres[i], [tx, ty] = tractions[i].map(t => 16 / most * t);
    if (Math.hypot(tx, ty) < 1) continue;
    line(context, [[x, y], [x + tx, y - ty]], "white", 3);
    line(context, [[x, y], [x + tx, y - ty]], "#1a1d21", 1.2);
  }
}

function heat(t) {  // from pale yellow over red to dark violet
  const stops = [[252, 243, 191], [251, 176, 90], [226, 75, 67], [140, 30, 110], [45, 10, 70]];
  const place = Math.min(t, 0.9999) * (stops.length - 1), i = Math.floor(place), f = place - i;
  return stops[i].map((v, k) => Math.round(v + f * (stops[i + 1][k] - v)));
}

const CURVES = [
  ["Rolling radius difference", "mm", table => [table.lateral, table.difference], true],
  ["Contact angle, right", "°", table => [table.lateral, table.sides.right.angles], true],
  ["Contact position on the right rail", "mm", table => [table.lateral, table.sides.right.points.map(p => p[0])], true],
  ["Equivalent conicity versus amplitude", "", table => table.conicity, false],
  ["Maximum pressure", "MPa", () => [state.sweep.map(p => p.lateral_mm), state.sweep.map(p => p.max_pressure_MPa)], true],
  ["T-gamma", "N", () => [state.sweep.map(p => p.lateral_mm), state.sweep.map(p => p.t_gamma_N)], true],
];

function drawCurves() {
  const holder = $("curves");
  while (holder.children.length < CURVES.length) {
    const canvas = element("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", CURVES[holder.children.length][0]);
    holder.append(canvas);
  }
  const [length, mm] = unitOf("mm");
  CURVES.forEach(([name, unit, data, overLateral], number) => {
    const [shown, metric] = unitOf(unit), title = `${name}, ${shown || length}`;
    const [xs, ys] = data(state.rigid), given = ys.filter(v => v !== null);
    const canvas = holder.children[number];
    canvas.hidden = !given.length;
    if (!given.length) return;
    const second = state.other && number < 4 ? data(state.other) : null;
    const { context, width, height } = fresh(canvas);
    const [x0, x1] = overLateral ? [state.rigid.lateral[0], state.rigid.lateral.at(-1)] : span(xs);
    let [y0, y1] = span(second ? given.concat(second[1]) : given);
    if (y1 - y0 < 1e-9) [y0, y1] = [y0 - 1, y1 + 1];
    const at = (x, y) => [48 + (width - 58) * (x - x0) / (x1 - x0), height - 22 - (height - 48) * (y - y0) / (y1 - y0)];
    context.fillStyle = colour("--soft");
    context.fillText(title, 8, 15);
    for (const [value, text] of [[y0, y0], [y1, y1]]) context.fillText(Number((text / metric).toPrecision(3)), 2, at(x0, value)[1] + 4);
    for (const value of [x0, x1]) context.fillText((value / mm).toFixed(mm > 1 ? 2 : 1), at(value, y0)[0] - (value === x1 ? 24 : 4), height - 6);
    if (overLateral) line(context, [at(state.lateral, y0), at(state.lateral, y1)], colour("--line"), 1);
    if (second) line(context, second[0].map((x, i) => at(x, second[1][i])), colour("--other"), 1.5, null, [5, 4]);
    const points = xs.map((x, i) => ys[i] === null ? null : at(x, ys[i])).filter(Boolean);
    line(context, points, colour("--focus"), 1.8);
    if (number > 3) { context.fillStyle = colour("--focus"); for (const p of points) context.fillRect(p[0] - 2, p[1] - 2, 4, 4); }
  });
}

// ---- positions one after the other ---------------------------------------------------------------------------------
// Work that lasts: its button stops it, other such work too; positions wait for its end.
let lasting = null;
async function runAlone(button, progress, work) {
  const stops = lasting?.button === button, caption = button.textContent, current = stops ? null : { button };
  const stopped = lasting && ask("cancel", {});
  lasting = current;
  await stopped;
  if (!stops) {
    button.textContent = "Stop";
    try {
      await work(words => { progress.textContent = words; return lasting === current; });
    } catch (error) {
      if (error.status !== 409) failed(error);
    }
    button.textContent = caption;
    if (lasting !== current) return; // who stopped it asks for the position: asked here, it could be stopped as well
    lasting = null;
  }
  if ($("facts").classList.contains("stale")) loadPosition();
}

async function sweep(goesOn) {
  const begun = asked, points = state.sweep = [], n = 25;
  const reach = Math.min(-state.rigid.lateral[0], state.rigid.lateral.at(-1), 6);
  for (let k = 0; k < n && begun === asked; k += 1) {
    const lateral = Number((-reach + 2 * reach * k / (n - 1)).toFixed(3));
    if (!goesOn(`${inUnit(lateral, "mm", 2)}, ${k} of ${n}`)) break;
    $("progress").hidden = false;
    $("progress").value = k / n;
    try {
      const found = await ask("position", inputsNow({ [LATERAL]: String(lateral) }));
      if (found.converged) points.push(found);
    } catch (error) { if (error.status === 409) break; }
    drawCurves();
  }
  $("progress").hidden = true;
  goesOn(`${points.length} of ${n} positions computed`);
}

async function report(goesOn) {
  goesOn("making the report …");
  await positionAnswer.catch(() => null); // requests at once may arrive in any order, and the later one stops the earlier one
  try {
    download("report.html", (await ask("report", inputsNow())).html, "text/html");
    goesOn("");
  } catch (error) {
    goesOn(error.status === 409 ? "stopped" : "");
    throw error;
  }
}

// ---- what can be run again ------------------------------------------------------------------------------------------
function download(name, text, kind = "text/plain") {
  const link = element("a");
  link.href = URL.createObjectURL(new Blob([text], { type: kind }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

async function take(work) {
  try { await work(); } catch (error) { failed(error); }
}

// ---- start ----------------------------------------------------------------------------------------------------------
function listen() {
  $("lateral").addEventListener("input", () => { state.lateral = Number($("lateral").value); $("free").checked = state.free = false; moved(); });
  $("yaw").addEventListener("input", () => turn(Number($("yaw").value)));
  $("shown").addEventListener("change", redraw);
  $("free").addEventListener("change", () => { state.free = $("free").checked; moved(); });
  for (const kind of ["wheel", "rail"]) $(kind).addEventListener("change", () => chosen(kind));
  for (const id of ["other-wheel", "other-rail"]) $(id).addEventListener("change", loadGeometry);
  const view = $("view");
  view.addEventListener("pointerdown", event => { drag = [event.clientX, state.lateral]; view.setPointerCapture(event.pointerId); });
  view.addEventListener("pointermove", event => {
    if (!drag) return;
    $("free").checked = state.free = false;
    shift(drag[1] + (event.clientX - drag[0]) / scaleOfView);
  });
  for (const name of ["pointerup", "pointercancel"]) view.addEventListener(name, () => { drag = null; });
  view.addEventListener("keydown", event => {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!steps) return;
    event.preventDefault();
    if (steps[0]) shift(state.lateral + (event.shiftKey ? 1 : 0.1) * steps[0]);
    else turn(state.yaw + (event.shiftKey ? 1 : 0.1) * steps[1]);
  });
  const drop = $("drop");
  drop.addEventListener("dragover", event => { event.preventDefault(); drop.classList.add("over"); });
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", event => { event.preventDefault(); drop.classList.remove("over"); dropped(event.dataTransfer.files); });
  drop.addEventListener("click", () => $("files").click());
  $("files").addEventListener("change", () => dropped($("files").files));
  $("form").addEventListener("submit", event => event.preventDefault());
  $("sweep").addEventListener("click", () => runAlone($("sweep"), $("progress-text"), sweep));
  $("report").addEventListener("click", () => runAlone($("report"), $("report-text"), report));
  $("save").addEventListener("click", () => take(async () => download("wheelset.toml", (await ask("saved", inputsNow())).case)));
  $("campaign").addEventListener("click", () => take(async () => download("campaign.toml", (await ask("saved", inputsNow())).campaign)));
  $("copy").addEventListener("click", () => take(async () => {
    await showCommand();
    await navigator.clipboard.writeText($("command").textContent).catch(() => getSelection().selectAllChildren($("command")));
  }));
  $("theme").addEventListener("click", () => {
    const dark = document.documentElement.dataset.theme ? document.documentElement.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "light" : "dark";
    redraw();
  });
  addEventListener("resize", redraw);
}

function shift(lateral) {
  const { rigid } = state;
  if (!rigid) return;
  state.lateral = Math.min(Math.max(Math.round(100 * lateral) / 100, rigid.lateral[0]), rigid.lateral.at(-1));
  $("free").checked = state.free = false;
  moved();
}

function turn(yaw) {
  state.yaw = Math.min(Math.max(Math.round(10 * yaw) / 10, Number($("yaw").min)), Number($("yaw").max));
  showSliders();
  loadGeometry();
}

function redraw() { drawRigid(); if (state.elastic) drawPatches(); drawReadings(); }

async function start() {
  state.form = await ask("form", {});
  fillProfiles(state.form);
  makeForm(state.form);
  $("wheel").value = "S1002";
  $("rail").value = "60E1";
  listen();
  for (const name of state.form.files) await readFile(name, new Blob([]));
  await loadGeometry();
}
const started = start().catch(failed);
