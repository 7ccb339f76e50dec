"use strict";
// State: inputs of the form by path, rigid contact of the pair (and of one to compare with), the last elastic position,
// and one that is kept to compare with.
const $ = id => document.getElementById(id);
const state = { inputs: {}, lateral: 0, yaw: 0, free: false, rigid: null, other: null, elastic: null, kept: null, sweep: [],
  number: 0, frames: [], readings: {}, units: null, zoom: 1 };
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
  const inputs = { units: state.units, ...state.inputs, [PATHS.wheel]: $("wheel").value, [PATHS.rail]: $("rail").value,
    ...changes };
  if (state.yaw) inputs[YAW] = String(state.yaw);
  if (!state.free && !(LATERAL in changes)) inputs[LATERAL] = String(state.lateral);
  return inputs;
}

// a group for each table, and in it one for each table inside; names are those of the input in its group
function makeForm(form) {
  const open = [...$("form").children].filter(group => group.open).map(group => group.firstChild.textContent);
  $("form").replaceChildren();
  for (const [caption, rows] of form.groups) {
    const shown = rows.filter(row => !OUTSIDE.includes(row[4])), groups = new Map();
    const groupOf = (name, words, above) => {
      const group = element("details"), grid = element("div");
      group.append(element("summary", words), grid);
      group.open = open.length ? open.includes(words) : caption === "Load and curve";
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

// "axle_load_kN" as "axle load, kN"
const UNITS = /_(mm_per_s|mrad_per_s|m_per_s|kN_per_mm|kip_per_in|kNm_per_rad|kNm_per_mrad|W_per_m_K|J_per_kg_K|kg_m3|km_h|mph|mm|m|in|ft|kN|kip|MPa|ksi|t|C|deg|mrad|rad|kNm|[a-z]+_per_[a-z_]+)$/;
function inWords(names) {
  const unit = names.at(-1).match(UNITS), words = names.map(name => name.replace(UNITS, "").replaceAll("_", " ")).join(", ");
  return unit ? `${words}, ${unit[1].replace("km_h", "km/h").replace("kg_m3", "kg/m³").replaceAll("_per_", "/").replaceAll("_", " ")}` : words;
}

function field([path, initial, allowed, meaning], names) {
  const label = element("label", inWords(names)), words = allowed.split(" or ");
  const choice = words.length > 1 && words.every(word => /^[a-z][\w.-]*$/i.test(word));
  const input = element(choice ? "select" : "input");
  if (choice) for (const word of new Set([initial, ...words])) input.add(new Option(word, word === initial ? "" : word));
  else input.placeholder = initial;
  input.id = `input-${path}`;
  label.title = `${meaning}; ${allowed} (${path})`;
  label.append(input);
  showInput(input, state.inputs[path]);
  input.addEventListener("change", () => {
    if (input.value.trim()) state.inputs[path] = input.value; else delete state.inputs[path];
    showInput(input, input.value.trim());
    loadGeometry();
  });
  return label;
}

function showInput(input, value = "") {
  input.value = value;
  input.classList.toggle("changed", Boolean(value));
}

// inputs by the names and numbers of other units: each row has its metric path, and the metric value of its unit
function converted(inputs, before, after) {
  const rows = form => new Map(form.groups.flatMap(([, of]) => of).map(row => [row[4], row]));
  const old = rows(before), now = rows(after), result = {};
  for (const [path, text] of Object.entries(inputs)) {
    const from = [...old.values()].find(row => row[0] === path), to = from && now.get(from[4]);
    if (!to || from[0] === to[0]) { result[path] = text; continue; }
    result[to[0]] = text.replace(/-?\d+(\.\d*)?(e[-+]?\d+)?/gi, number => Number((number * from[5] / to[5]).toPrecision(7)));
  }
  return result;
}

async function showUnits(units) {
  const before = state.form, form = await ask("form", units ? { units } : {});
  if (before) state.inputs = converted(state.inputs, before, form);
  form.initial = before?.initial;
  state.form = form;
  state.units = form.system;
  $("units").value = form.system;
  fillProfiles({ ...form, own });
  makeForm(form);
}

// ---- the address, undo and redo, presets ---------------------------------------------------------------------------
const CHOSEN = ["wheel", "rail", "other-wheel", "other-rail"];
const past = [];
let present = -1;

// all that decides what is shown: a reload, or the address opened elsewhere, gives the same page
function written() {
  const all = new URLSearchParams();
  for (const id of CHOSEN) if ($(id).value) all.set(id, $(id).value);
  if (state.form && state.units !== state.form.initial) all.set("units", state.units);
  if (state.free) all.set("free", "1"); else if (state.lateral) all.set("lateral", state.lateral);
  if (state.yaw) all.set("yaw", state.yaw);
  for (const [path, value] of Object.entries(state.inputs)) all.set(path, value);
  return String(all);
}

function remember() {
  const text = written();
  if (text !== past[present]) {
    past.splice(present + 1);
    past.push(text);
    present = past.length - 1;
  }
  history.replaceState(null, "", `#${text}`);
  $("undo").disabled = present <= 0;
  $("redo").disabled = present >= past.length - 1;
}

async function restore(text) {
  const all = new URLSearchParams(text), units = all.get("units") || state.form.initial;
  state.inputs = {};
  if (units !== state.units) await showUnits(units);
  for (const id of CHOSEN) if (all.has(id) || id.startsWith("other")) $(id).value = all.get(id) || "";
  for (const id of ["wheel", "rail"]) if (!$(id).value) $(id).selectedIndex = 0;
  state.free = $("free").checked = all.has("free");
  state.lateral = Number(all.get("lateral")) || 0;
  state.yaw = Number(all.get("yaw")) || 0;
  for (const [path, value] of all) if (path.includes(".")) state.inputs[path] = value;
  makeForm(state.form);
  showSliders();
  await loadGeometry();
}

function step(by) {
  if (!past[present + by]) return;
  present += by;
  restore(past[present]);
}

// by metric names
const PRESETS = {
  "tangent track": {},
  "curve of 500 m": { "load.curve.radius_m": "500", "load.curve.speed_km_h": "80", "load.curve.superelevation_mm": "60", free: 1 },
  "curve with friction": { "load.curve.radius_m": "500", "load.curve.speed_km_h": "80", "load.curve.superelevation_mm": "60",
    "rolling.friction": "0.3", "rolling.theory": "fastsim", free: 1 },
  "metro, curve of 200 m": { "load.axle_load_kN": "120", "load.curve.radius_m": "200", "load.curve.speed_km_h": "40",
    "load.curve.superelevation_mm": "60", "wheelset.radius_mm": "420", free: 1 },
  "heavy haul": { wheel: "heavy-haul", rail: "136RE", "load.axle_load_kN": "320", free: 1 },
};

function preset(name) {
  const { free, wheel = "S1002", rail = "60E1", ...inputs } = PRESETS[name];
  const metric = { groups: state.form.groups.map(([caption, rows]) => [caption, rows.map(row => [row[4], ...row.slice(1, 5), 1])]) };
  const all = new URLSearchParams({ wheel, rail, units: state.units, ...converted(inputs, metric, state.form) });
  if (free) all.set("free", "1");
  return restore(String(all));
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
      nameSweep();
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
let since = 0;
function stale() {
  if (!state.stale) since = performance.now();
  state.number += 1;
  state.stale = true;
  status("busy", "computing …");
  for (const id of ["facts", "patches", "tables"]) $(id).classList.add("stale");
}

// whoever waits for longer than half a second sees that it goes on
setInterval(() => {
  const seconds = (performance.now() - since) / 1000;
  if (state.stale && !lasting && $("state").className === "status busy" && seconds > 0.5)
    $("state").textContent = `computing … ${seconds.toFixed(0)} s`;
}, 500);

let positionAnswer = Promise.resolve(); // the position that is being computed

async function loadPosition() {
  if (!state.rigid) return;
  remember();
  if (lasting) return status("busy", "waiting until the report or the curves are done");
  const number = ++state.number;
  try {
    positionAnswer = ask("position", inputsNow());
    const elastic = await positionAnswer;
    if (number !== state.number) return;
    state.elastic = elastic;
    state.stale = false;
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
  $("tables").replaceChildren(resultsTable(elastic.table, state.kept?.elastic.table));
  $("keep").disabled = false;
  for (const id of ["facts", "patches", "tables"]) $(id).classList.remove("stale");
  drawRigid();
  drawPatches();
}

// results, and in small letters by how much each number differs from those that are kept
function resultsTable({ header, rows }, kept) {
  const shown = element("table"), head = element("tr");
  head.append(...header.map(words => element("th", words)));
  shown.append(head);
  const before = new Map((kept?.rows || []).map(([name, ...cells]) => [name, cells]));
  for (const [name, ...cells] of rows) {
    const row = element("tr");
    row.append(element("th", name), ...cells.map((text, i) => {
      const cell = element("td", text), other = before.get(name)?.[kept.header.indexOf(header[i + 1]) - 1];
      if (other !== undefined) cell.append(difference(text, other));
      return cell;
    }));
    shown.append(row);
  }
  return shown;
}

function difference(text, other) {
  const by = Number(text) - Number(other), digits = (text.split(".")[1] || "").length;
  const words = !text && !other ? "" : Number.isNaN(by) ? (text === other ? "" : other) : `${by < 0 ? "" : "+"}${fixed(by, digits)}`;
  return Object.assign(element("small", words), { title: `kept: ${other}` });
}

function keep() {
  state.kept = state.kept ? null : { elastic: state.elastic, rigid: state.rigid, lateral: state.lateral };
  $("keep").textContent = state.kept ? "Forget what is kept" : "Keep to compare with";
  $("kept").textContent = state.kept
    ? `kept: ${$("wheel").value} on ${$("rail").value}, lateral position ${inUnit(state.lateral, "mm", 2)}; differences in small letters, its patches dashed` : "";
  showElastic();
}

async function showCommand() {
  try { $("command").textContent = (await ask("saved", inputsNow())).command; } catch (error) { failed(error); }
}

// ---- drawing --------------------------------------------------------------------------------------------------------
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const span = values => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
const middle = corners => [0, 1].map(axis => corners.reduce((sum, point) => sum + point[axis], 0) / corners.length);
function element(kind, text = "") { const made = document.createElement(kind); made.textContent = text; return made; }
function fact(name, value) { const made = element("div"); made.append(element("dt", name), element("dd", value)); return made; }

let vector = null; // a drawing as SVG, in place of the screen
function fresh(canvas) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (vector) return { context: vector = new SvgContext(width, height), width, height };
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio))
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height };
}

// What the pictures use of a canvas, written as SVG.
class SvgContext {
  constructor(width, height) { Object.assign(this, { width, height, parts: [], path: "", dash: [], clips: 0, open: 0, lineWidth: 1 }); }
  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${x.toFixed(2)} ${y.toFixed(2)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`; }
  closePath() { this.path += "Z"; }
  arc(x, y, r) { this.path += `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`; }
  rect(x, y, w, h) { this.path += `M${x} ${y}h${w}v${h}h${-w}Z`; }
  fill() { this.parts.push(`<path d="${this.path}" fill="${this.fillStyle}"/>`); }
  stroke() {
    this.parts.push(`<path d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-dasharray="${this.dash.join(" ")}"/>`);
  }
  fillRect(x, y, w, h) { this.parts.push(`<rect x="${x}" y="${y}" width="${w}" height="${h}" fill="${this.fillStyle}"/>`); }
  fillText(text, x, y) {
    const words = String(text).replace(/[&<>]/g, letter => `&#${letter.charCodeAt(0)};`);
    this.parts.push(`<text x="${x}" y="${y}" fill="${this.fillStyle}" text-anchor="${{ center: "middle", right: "end" }[this.textAlign] || "start"}">${words}</text>`);
  }
  setLineDash(dash) { this.dash = dash; }
  clip() {
    this.clips += 1;
    this.open += 1;
    this.parts.push(`<clipPath id="c${this.clips}"><path d="${this.path}"/></clipPath><g clip-path="url(#c${this.clips})">`);
  }
  save() { this.before = this.open; }
  restore() { for (; this.open > this.before; this.open -= 1) this.parts.push("</g>"); }
  getTransform() { return { a: 100 }; } // cells meet at whole hundredths
  get text() {
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}" font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="${colour("--page")}"/>${this.parts.join("\n")}</svg>\n`;
  }
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

function words(context, text, x, y, align = "left", ink = "--soft") {
  Object.assign(context, { textAlign: align, fillStyle: colour(ink) });
  context.fillText(text, x, y);
  context.textAlign = "left";
}

// 1, 2 or 5 times a power of ten, at most a length
function round(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * [5, 2, 1].find(factor => factor * power <= most);
}

// a bar with its length, its right end at a place; the scale is in pixels per mm
function scaleBar(context, scale, right, y) {
  const [unit, mm] = unitOf("mm"), length = round(90 / (scale * mm)), pixels = length * mm * scale;
  line(context, [[right - pixels, y - 4], [right - pixels, y], [right, y], [right, y - 4]], colour("--ink"), 1.5);
  words(context, `${length} ${unit}`, right - pixels / 2, y - 5, "center", "--ink");
}

const HALF_VIEW_MM = 55;
let drag = null, scaleOfView = 1;
const places = { view: [], patches: [], curves: [] }; // what is at the pointer, by the last drawing

function drawRigid() {
  if (!state.rigid) return;
  const begun = performance.now(), now = drawView();
  const numbers = [["rolling radius difference", inUnit(now.difference, "mm", 3)],
    ["contact angle, left", inUnit(now.left.angle, "°", 2)], ["contact angle, right", inUnit(now.right.angle, "°", 2)],
    ["rolling radius, left", inUnit(now.left.radius, "mm", 3)],
    ["rolling radius, right", inUnit(now.right.radius, "mm", 3)],
    ["roll", inUnit(1e3 * now.roll, "mrad", 3)], [`equivalent conicity at ${Number((3 / unitOf("mm")[1]).toPrecision(3))} ${unitOf("mm")[0]}`, conicity(state.rigid)]];
  $("rigid").replaceChildren(...numbers.map(([name, value]) => fact(name, value)));
  drawCurves();
  state.frames.push(performance.now() - begun);
}

// One wheelset: as it was computed, with its contact forces; while it moves in rigid contact, dashed, and it says so.
function drawView() {
  const { context, width, height } = fresh($("view")), now = positionAt(state.rigid, state.lateral);
  const steel = colour("--steel"), steel2 = colour("--steel2"), ink = colour("--ink"), contacts = state.stale ? null : state.elastic?.contacts;
  places.view = [];
  ["left", "right"].forEach((side, k) => {
    const sign = k ? 1 : -1, centre = [k ? 0.75 * width : 0.25 * width, height / 2];
    const scale = scaleOfView = state.zoom * Math.min(width / 2, 1.25 * height) / (2 * HALF_VIEW_MM);
    const table = state.rigid.sides[side], top = table.rail.reduce((a, p) => p[1] > a[1] ? p : a);
    // the picture closes in on where it touches
    const forces = contacts?.filter(one => one[0] === side) || [], touched = forces[0]?.[1] || now[side].point, part = 1 / state.zoom;
    const focus = [part * (top[0] - sign * 8) + (1 - part) * touched[0], -5 * part + (1 - part) * touched[1]];
    const at = p => [centre[0] + scale * (p[0] - focus[0]), centre[1] - scale * (p[1] - focus[1])];
    const box = [k ? width / 2 + 1 : 0, 0, width / 2 - 1, height];
    places.view.push({ side, box, back: (x, y) => [focus[0] + (x - centre[0]) / scale, focus[1] - (y - centre[1]) / scale] });
    context.save();
    context.beginPath();
    context.rect(...box);
    context.clip();
    const placed = (points, pose, table_) => points.map(([x, y]) => {
      const c = Math.cos(pose.roll), s = Math.sin(pose.roll), h = y - table_.axle_height;
      return [c * x - s * h + pose.lateral, s * x + c * h + table_.axle_height + pose.vertical];
    });
    line(context, table.rail.map(at), ink, 1, steel2);
    line(context, placed(table.wheel, now, state.rigid).map(at), ink, 1, steel, contacts ? [] : [5, 3]);
    if (state.other) {
      const pose = positionAt(state.other, Math.min(Math.max(state.lateral, state.other.lateral[0]),
        state.other.lateral.at(-1))), second = state.other.sides[side];
      for (const points of [second.rail, placed(second.wheel, pose, state.other)])
        line(context, points.map(at), colour("--other"), 1.5, null, [5, 4]);
    }
    const most = Math.max(...(contacts || []).map(one => one[3]));
    if (contacts) for (const [, point, angle, force] of forces) arrow(at(point), sign * angle, 20 + 35 * force / most, inUnit(force, "N", 0, 1e3));
    else arrow(at(now[side].point), sign * now[side].angle, 45, "");
    function arrow([x, y], angle, length, text) {
      const normal = angle * Math.PI / 180, end = [x - length * Math.sin(normal), y - length * Math.cos(normal)];
      for (const [stroke, thick] of [[colour("--page"), 5], [colour("--pressure"), 2]]) line(context, [[x, y], end], stroke, thick);
      context.fillStyle = colour("--pressure");
      context.beginPath();
      context.arc(x, y, 5, 0, 2 * Math.PI);
      context.fill();
      words(context, text, end[0], end[1] - 6, "center", "--ink");
    }
    words(context, `${side} wheel on ${side} rail`, k ? width / 2 + 10 : 10, width < 600 ? 18 : height - 8);
    context.restore();
  });
  scaleBar(context, scaleOfView, width - 12, height - 10);
  $("drawn").textContent = contacts ? "computed: contact points and normal forces on the wheels, bodies without their deflections"
    : "rigid contact, without load";
  return now;
}

// without the sign of a zero that round-off gives
function fixed(value, digits) {
  return (Number(value.toFixed(digits)) + 0).toFixed(digits);
}

// numbers are metric until they are shown; the larger units of the US have one decimal more
const unitOf = unit => state.form.units[unit] ?? [unit, 1];
function inUnit(value, unit, digits, larger = 1) {
  const [name, metric] = unitOf(unit);
  if (larger === 1e3) return metric > 1 ? `${fixed(value / metric, 1)} ${name}` : `${fixed(value / larger, 1)} k${name}`;
  return `${fixed(value / metric, digits + (metric > 1 ? 1 : 0))} ${name}`;
}

function conicity(table) {
  const at = table.conicity[0].indexOf(3);
  return at < 0 ? "–" : table.conicity[1][at].toFixed(3);
}

function drawPatches() {
  const { context, width, height } = fresh($("patches")), sides = state.elastic.patches;
  const names = Object.keys(sides), select = $("shown"), before = state.kept?.elastic.patches || {};
  places.patches = [];
  if (!names.length) return;
  const fields = Object.keys(sides[names[0]].stresses);
  if (select.length === 1) select.append(...fields.map(name => new Option(name, name)));
  const field = select.value, valuesOf = side => field ? sides[side].stresses[field] : sides[side].pressures;
  const highest = Math.max(...names.flatMap(valuesOf)) || 1;
  const extent = polygons => [0, 1].map(axis => span(polygons.flat().map(point => point[axis])));
  const boxes = names.map(side => extent([...sides[side].polygons, ...(before[side]?.outline || [])]));
  const captions = names.map(side => sides[side].patches.length + 1);
  const above = 6 + 15 * Math.max(...captions), room = height - above - 62;
  const scale = Math.min(...boxes.map(([[a, b], [c, d]]) => Math.min((width / 2 - 30) / (b - a), room / (d - c))));
  names.forEach((side, k) => {
    const { polygons, outline, tractions, patches } = sides[side], [[a, b], [c, d]] = boxes[k];
    const left = side === "left" ? 0 : width / 2, ratio = context.getTransform().a;
    const whole = v => Math.round(ratio * v) / ratio;  // whole pixels: no seams between cells
    const at = ([x, y]) => [left + width / 4 + scale * (x - (a + b) / 2), above + room / 2 - scale * (y - (c + d) / 2)];
    places.patches.push({ side, polygons, values: valuesOf(side), patches, box: [left, above - 4, width / 2, room + 8],
      back: (x, y) => [(x - left - width / 4) / scale + (a + b) / 2, (c + d) / 2 - (y - above - room / 2) / scale] });
    polygons.forEach((corners, i) => {
      context.beginPath();
      corners.map(at).forEach(([x, y]) => context.lineTo(whole(x), whole(y)));
      context.fillStyle = `rgb(${heat(valuesOf(side)[i] / highest)})`;
      context.fill();
    });
    if (tractions && !field) drawTractions(context, polygons.map(corners => at(middle(corners))), tractions);
    const border = (ends, stroke, dash = []) => {
      context.beginPath();
      for (const pair of ends) pair.map(at).forEach(([x, y], i) => i ? context.lineTo(whole(x), whole(y)) : context.moveTo(whole(x), whole(y)));
      Object.assign(context, { strokeStyle: stroke, lineWidth: 1, lineCap: "square" });
      context.setLineDash(dash);
      context.stroke();
      context.setLineDash([]);
    };
    border(outline, colour("--ink"));
    if (before[side]) border(before[side].outline, colour("--other"), [5, 4]);
    words(context, `${side} rail`, left + 8, 14);
    patches.forEach(([region, cells], i) => {
      const [[x0, x1], [y0, y1]] = extent(cells.map(cell => polygons[cell]));
      words(context, `${region}: ${inUnit(x1 - x0, "mm", 1)} × ${inUnit(y1 - y0, "mm", 1)}`, left + 8, 29 + 15 * i);
    });
  });
  // the colours and their values
  const bar = Math.min(220, width / 2 - 20), [unit, metric] = unitOf("MPa"), digits = metric > 1 ? 1 : 0;
  for (let i = 0; i < bar; i += 1) {
    context.fillStyle = `rgb(${heat(i / bar)})`;
    context.fillRect(8 + i, height - 34, 1.5, 9);
  }
  for (const part of [0, 0.5, 1])
    words(context, fixed(part * highest / metric, digits), 8 + part * bar, height - 38, ["left", "center", "right"][2 * part]);
  words(context, `${field || "pressure"}, ${unit}`, 8, height - 13);
  scaleBar(context, scale, width - 12, height - 26);
  words(context, "from above, ahead is up" + (!field && names.some(side => sides[side].tractions) ? "; arrows: tractions on the wheel" : ""),
    width - 12, height - 8, "right");
}

// an arrow in each square of the picture, at the cell that is closest to the middle of the square
const SQUARE = 18;
function drawTractions(context, centres, tractions) {
  const most = Math.max(...tractions.map(t => Math.hypot(t[0], t[1]))) || 1, squares = new Map();
  centres.forEach(([x, y], i) => {
    const square = [x, y].map(v => Math.floor(v / SQUARE)), key = String(square);
    const off = Math.hypot(x / SQUARE - square[0] - 0.5, y / SQUARE - square[1] - 0.5);
    if (!(off >= squares.get(key)?.off)) squares.set(key, { off, i });
  });
  const shown = [];
  for (const { i } of squares.values()) {
    const [x, y] = centres[i], [tx, ty] = tractions[i].map(t => 16 / most * t), length = Math.hypot(tx, ty);
    if (length < 1) continue;
    const end = [x + tx, y - ty], head = Math.min(5, 0.5 * length) / length;
    const barb = turned => [end[0] - head * (tx + turned * ty), end[1] + head * (ty - turned * tx)];
    shown.push([[x, y], end, barb(0.6), end, barb(-0.6)]);
  }
  for (const [stroke, width] of [["white", 3.5], ["#1a1d21", 1.3]]) for (const points of shown) line(context, points, stroke, width);
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
const TREAD_DEG = 20; // a steeper contact is at the flange root, or on the flange

// lateral positions around the middle in which both wheels touch with the tread
function treadRange(table) {
  const steep = table.lateral.map((_, i) => Math.max(...["left", "right"].map(side => Math.abs(table.sides[side].angles[i]))) > TREAD_DEG);
  const low = table.lateral.filter((x, i) => x < 0 && steep[i]).at(-1) ?? table.lateral[0];
  const high = table.lateral.find((x, i) => x > 0 && steep[i]) ?? table.lateral.at(-1);
  return low < high ? [low, high] : [table.lateral[0], table.lateral.at(-1)];
}

function drawCurves() {
  const holder = $("curves");
  while (holder.children.length < CURVES.length) {
    const canvas = element("canvas"), number = holder.children.length;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", CURVES[number][0]);
    canvas.addEventListener("pointermove", event => readCurve(event, number));
    canvas.addEventListener("pointerleave", () => tip());
    holder.append(canvas);
  }
  CURVES.forEach((_, number) => drawCurve(number));
}

function drawCurve(number) {
  const [name, unit, data, overLateral] = CURVES[number], canvas = $("curves").children[number], [length, mm] = unitOf("mm");
  const [shown, metric] = unitOf(unit), [allX, allY] = data(state.rigid), whole = overLateral && !$("flange").checked;
  const range = overLateral ? whole ? treadRange(state.rigid) : [state.rigid.lateral[0], state.rigid.lateral.at(-1)] : span(allX);
  const within = (xs, ys) => xs.map((x, i) => [x / mm, ys[i] === null ? null : ys[i] / metric]).filter(([x, y]) => y !== null && x * mm >= range[0] && x * mm <= range[1]);
  const points = within(allX, allY);
  places.curves[number] = null;
  canvas.hidden = !points.length;
  if (!points.length) return;
  const second = state.other && number < 4 ? within(...data(state.other)) : [];
  const { context, width, height } = fresh(canvas), [x0, x1] = range.map(x => x / mm);
  let [y0, y1] = span(points.concat(second).map(p => p[1]));
  if (y1 - y0 < 1e-9) [y0, y1] = [y0 - 1, y1 + 1];
  const at = ([x, y]) => [56 + (width - 68) * (x - x0) / (x1 - x0), height - 24 - (height - 52) * (y - y0) / (y1 - y0)];
  words(context, `${name}, ${shown || length}`.replace(/, $/, ""), 8, 15);
  for (const [axis, low, high] of [[0, x0, x1], [1, y0, y1]]) {
    const distance = round((high - low) / 3), digits = Math.max(0, -Math.floor(Math.log10(distance) + 1e-9));
    for (let k = Math.ceil(low / distance - 1e-9); k * distance <= high + 1e-9 * distance; k += 1) {
      const value = k * distance, ends = axis ? [[x0, value], [x1, value]] : [[value, y0], [value, y1]];
      line(context, ends.map(at), colour("--line"), 1);
      const [x, y] = at(ends[0]);
      if (axis) words(context, fixed(value, digits), x - 5, y + 4, "right"); else words(context, fixed(value, digits), x, height - 8, "center");
    }
  }
  if (overLateral && state.lateral >= range[0] && state.lateral <= range[1])
    line(context, [y0, y1].map(y => at([state.lateral / mm, y])), colour("--pressure"), 1);
  // a contact that leaps to the flange leaves a gap in the line
  const draw = (of, stroke, thick, dash) => {
    let part = [];
    of.forEach((p, i) => {
      if (i && number < 3 && Math.abs(p[1] - of[i - 1][1]) > 0.1 * (y1 - y0)) { line(context, part, stroke, thick, null, dash); part = []; }
      part.push(at(p));
    });
    if (part.length) line(context, part, stroke, thick, null, dash);
  };
  if (second.length) draw(second, colour("--other"), 1.5, [5, 4]);
  draw(points, colour("--focus"), 1.8, []);
  if (number > 3) for (const p of points.map(at)) { context.fillStyle = colour("--focus"); context.fillRect(p[0] - 2, p[1] - 2, 4, 4); }
  places.curves[number] = { points, at, texts: [[`${overLateral ? "lateral position" : "amplitude"}`, length], [name, shown || ""]] };
}

// ---- values at the pointer ------------------------------------------------------------------------------------------
function tip(event, text) {
  const shown = $("tip");
  shown.hidden = !text;
  if (!text) return;
  shown.textContent = text;
  shown.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - shown.offsetWidth - 8))}px`;
  shown.style.top = `${event.clientY + 16}px`;
}

const inBox = (x, y, [left, top, width, height]) => x >= left && x <= left + width && y >= top && y <= top + height;

function readView(event) {
  const place = places.view.find(one => inBox(event.offsetX, event.offsetY, one.box));
  if (!place || drag) return tip();
  const [x, y] = place.back(event.offsetX, event.offsetY);
  tip(event, `${place.side}: ${inUnit(x, "mm", 2)} to the right of the track's middle, ${inUnit(y, "mm", 2)} above the rails`);
}

function readPatches(event) {
  const place = places.patches.find(one => inBox(event.offsetX, event.offsetY, one.box));
  if (!place) return tip();
  const [x, y] = place.back(event.offsetX, event.offsetY);
  const cell = place.polygons.findIndex(corners => span(corners.map(p => p[0])).every((v, i) => i ? x <= v : x >= v)
    && span(corners.map(p => p[1])).every((v, i) => i ? y <= v : y >= v));
  if (cell < 0) return tip();
  const region = place.patches.find(([, cells]) => cells.includes(cell))?.[0] || "";
  tip(event, `${place.side} ${region}: ${inUnit(place.values[cell], "MPa", 1)} at ${inUnit(x, "mm", 2)} across, ${inUnit(y, "mm", 2)} ahead`);
}

function readCurve(event, number) {
  const place = places.curves[number];
  if (!place) return tip();
  const [x, y] = place.points.reduce((a, p) => Math.abs(place.at(p)[0] - event.offsetX) < Math.abs(place.at(a)[0] - event.offsetX) ? p : a);
  const [[across, length], [name, unit]] = place.texts;
  tip(event, `${across} ${fixed(x, 3)} ${length}: ${name.toLowerCase()} ${Number(y.toPrecision(5))} ${unit}`.trim());
}

function zoom(by) {
  state.zoom = Math.min(Math.max(state.zoom * by, 1), 40);
  if (state.rigid) drawView();
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

const N_SWEPT = 25; // positions across the track
// T-gamma needs friction: the button says what is computed
const rolls = () => Object.keys(state.inputs).some(path => path.startsWith("rolling."));
function nameSweep() {
  if (!lasting) $("sweep").textContent = `Compute maximum pressures${rolls() ? " and T-gamma" : ""} at ${N_SWEPT} positions`;
}

async function sweep(goesOn) {
  const begun = asked, points = state.sweep = [], n = N_SWEPT;
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

// ---- what can be run again, and files of what is seen --------------------------------------------------------------
const quoted = cell => /[",\n]/.test(cell) ? `"${String(cell).replaceAll('"', '""')}"` : String(cell);
const csv = rows => rows.map(row => row.map(quoted).join(",")).join("\n") + "\n";
const PICTURES = { wheelset: () => [$("view"), drawView], patches: () => [$("patches"), drawPatches],
  ...Object.fromEntries(CURVES.map(([name], number) => [name, () => [$("curves").children[number], () => drawCurve(number)]])) };
const fileName = name => name.toLowerCase().replace(/[^a-z0-9]+/g, "-");

// tables as the command writes them, the results and curves as they are seen, and pictures
async function exported(what) {
  const [kind, name] = what.split(":");
  if (kind === "results") return download("results.csv", csv([state.elastic.table.header, ...state.elastic.table.rows]), "text/csv");
  if (kind === "curves") {
    const shown = places.curves.filter(Boolean), columns = shown.flatMap(({ texts }) => texts.map(words => words.filter(Boolean).join(", ")));
    const lines = Array.from({ length: Math.max(...shown.map(one => one.points.length)) }, (_, i) => shown.flatMap(one => one.points[i] || ["", ""]));
    return download("curves.csv", csv([columns, ...lines]), "text/csv");
  }
  if (kind === "table") return download(name, (await ask("tables", inputsNow()))[name], "text/csv");
  const [canvas, draw] = PICTURES[name]();
  if (kind === "png") return canvas.toBlob(picture => download(`${fileName(name)}.png`, picture, "image/png"));
  vector = true;
  try { draw(); download(`${fileName(name)}.svg`, vector.text, "image/svg+xml"); } finally { vector = null; draw(); }
}

function fillExports() {
  const groups = { "Tables, CSV": [["results:", "results on this page"], ["table:patches.csv", "patches"],
    ["table:subsurface.csv", "stresses below the patches"], ["table:rails.csv", "rails on their sleepers"], ["curves:", "curves on this page"]] };
  for (const format of ["png", "svg"]) groups[`Pictures, ${format.toUpperCase()}`] = Object.keys(PICTURES).map(name => [`${format}:${name}`, name.toLowerCase()]);
  for (const [caption, choices] of Object.entries(groups)) {
    const group = element("optgroup");
    group.label = caption;
    group.append(...choices.map(([value, words]) => new Option(words, value)));
    $("what").append(group);
  }
}

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
  view.addEventListener("pointerdown", event => { tip(); drag = [event.clientX, state.lateral]; view.setPointerCapture(event.pointerId); });
  view.addEventListener("pointermove", event => {
    if (!drag) return readView(event);
    $("free").checked = state.free = false;
    shift(drag[1] + (event.clientX - drag[0]) / scaleOfView);
  });
  for (const name of ["pointerup", "pointercancel"]) view.addEventListener(name, () => { drag = null; });
  view.addEventListener("wheel", event => {
    if (!event.ctrlKey) return; // the wheel alone scrolls the page
    event.preventDefault();
    zoom(event.deltaY < 0 ? 1.25 : 0.8);
  }, { passive: false });
  for (const [canvas, read] of [[view, readView], [$("patches"), readPatches]]) {
    canvas.addEventListener("pointermove", read);
    canvas.addEventListener("pointerleave", () => tip());
  }
  view.addEventListener("keydown", event => {
    if (event.key === "+" || event.key === "-") return zoom(event.key === "+" ? 1.25 : 0.8);
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
  $("nearer").addEventListener("click", () => zoom(1.6));
  $("farther").addEventListener("click", () => zoom(0.625));
  $("undo").addEventListener("click", () => step(-1));
  $("redo").addEventListener("click", () => step(1));
  $("keep").addEventListener("click", keep);
  $("flange").addEventListener("change", drawCurves);
  $("units").addEventListener("change", () => take(async () => { if (state.kept) keep(); await showUnits($("units").value); await loadGeometry(); }));
  for (const name of Object.keys(PRESETS)) $("preset").add(new Option(name, name));
  $("preset").addEventListener("change", () => { if ($("preset").value) preset($("preset").value); $("preset").value = ""; });
  fillExports();
  $("export").addEventListener("click", () => take(() => exported($("what").value)));
  addEventListener("keydown", event => {
    if (!(event.ctrlKey || event.metaKey) || !"zy".includes(event.key.toLowerCase()) || /INPUT/.test(event.target.tagName)) return;
    event.preventDefault();
    step(event.key.toLowerCase() === "y" || event.shiftKey ? 1 : -1);
  });
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
  const address = location.hash.slice(1);
  await showUnits();
  state.form.initial = state.units;
  $("wheel").value = "S1002";
  $("rail").value = "60E1";
  listen();
  for (const name of state.form.files) await readFile(name, new Blob([]));
  await (address ? restore(address) : loadGeometry());
}
const started = start().catch(failed);
