// The viewer itself: brings the picture, the controls of the page and the keys together.

const PAN_SHARE = 0.1;
const ZOOM_STEP = 1.3;
const MARGIN = 0.04;
const LINEAR_SHARE = 0.2;
const LARGEST_FACTOR = 1000;
const LONGEST_BAR = 160;
const SIDES_APART = 0.2;

class Viewer {
  constructor(root, parts, { fields, views, unit, axes, steps }) {
    this.root = root;
    this.parts = parts;
    this.fields = fields;
    this.unit = unit;
    this.axes = axes;
    this.deforms = parts.some((part) => part.arrays.displacement);
    this.canvas = this.find("#viewer-canvas");
    this.cross = this.find(".viewer-cross");
    this.field = fields[0];
    this.factor = 1;
    this.found = null;
    this.ranges = new Map();
    this.picture = new Picture(this.canvas, parts);
    this.navigation = new Navigation(this.picture, this.canvas, () => this.moved());
    this.reading = new Reading(root, this);
    this.scale = new Scale(root, () => this.recolour());
    this.steps = new Steps(root, steps, (words) => this.chooseStep(words));
    const given = views.map((view) => givenView(view, parts));
    this.views = [{ name: "whole", box: () => this.wholeBox() }, ...sidesOf(parts, this), ...given];
    this.find("#viewer-smooth").checked = this.picture.solid;
    if (this.picture.solid) this.scale.mode.value = "full";
    this.moveSides();
    this.fillControls();
    this.listen();
    this.resized();
    this.chooseField(this.field.key);
    this.lookAtWhole();
    if (this.picture.solid) this.tilt();
    this.picture.render();
  }

  find(selector) {
    return this.root.querySelector(selector);
  }

  shownParts() {
    return this.parts.filter((part) => !part.hidden);
  }

  wholeBox() {
    return widened(boxOf(this.shownParts().length ? this.shownParts() : this.parts, this.factor));
  }

  lookAtWhole() {
    const box = this.wholeBox();
    const zoom = this.navigation.zoomOf(box);
    this.navigation.limit(zoom);
    this.navigation.look((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, zoom);
  }

  // Draw the sides of the track closer together than they are, or as they are.
  moveSides() {
    const sides = sideGroups(this.parts);
    const closer = sides.length > 1 && this.find("#viewer-closer").checked;
    this.find("#viewer-closer").parentElement.hidden = sides.length < 2;
    for (const part of this.parts) part.shift = 0;
    let end = null;
    for (const side of sides) {
      const box = boxOf(side, 1);
      const shift = closer && end !== null ? end + SIDES_APART * (box[2] - box[0]) - box[0] : 0;
      for (const part of side) part.shift = Math.min(shift, 0);
      end = box[2] + Math.min(shift, 0);
    }
    this.picture.place();
  }

  // controls

  fillControls() {
    const groups = new Map();
    for (const field of this.fields) {
      if (!groups.has(field.group)) {
        const group = document.createElement("optgroup");
        group.label = field.group;
        this.find("#viewer-field").append(group);
        groups.set(field.group, group);
      }
      groups.get(field.group).append(new Option(`${field.name}, ${field.unit}`, field.key));
    }
    this.views.forEach((view, i) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = view.name;
      button.title = `Key ${i}`;
      button.addEventListener("click", () => this.fly(view));
      this.find(".viewer-views").append(button);
    });
    for (const part of this.parts) {
      const label = document.createElement("label");
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true, value: part.name });
      box.addEventListener("change", () => this.showPart(part, box.checked));
      label.append(box, ` ${part.name}`);
      this.find(".viewer-parts").append(label);
    }
    this.find(".viewer-parts").hidden = this.parts.length < 2;
    for (const name of [".viewer-slide", "#viewer-true"]) this.find(name).hidden = !this.deforms;
    for (const name of ["#viewer-tilt", ".viewer-tilt-keys"]) this.find(name).hidden = !this.picture.solid;
    this.find("#viewer-slider").value = sliderOf(this.factor);
  }

  listen() {
    const on = (selector, event, action) => this.find(selector).addEventListener(event, action);
    on("#viewer-field", "change", (event) => this.chooseField(event.target.value));
    on("#viewer-slider", "input", (event) => this.deform(factorOf(event.target.valueAsNumber)));
    on("#viewer-factor", "input", (event) => {
      const factor = event.target.valueAsNumber;
      const sensible = factor >= 0 && factor <= LARGEST_FACTOR;
      event.target.setAttribute("aria-invalid", String(!sensible));
      if (sensible) this.deform(factor, event.target);
    });
    on("#viewer-true", "click", () => this.deform(1));
    on("#viewer-lines", "change", () => this.showLines());
    on("#viewer-smooth", "change", () => this.recolour());
    on("#viewer-common", "change", () => this.recolour());
    on("#viewer-closer", "change", () => {
      this.moveSides();
      this.lookAtWhole();
      this.read();
    });
    on("#viewer-tilt", "click", () => this.tilt());
    on("#viewer-in", "click", () => this.navigation.zoomBy(ZOOM_STEP));
    on("#viewer-out", "click", () => this.navigation.zoomBy(1 / ZOOM_STEP));
    this.canvas.addEventListener("pointermove", (event) => this.pointed(event));
    this.canvas.addEventListener("pointerdown", (event) => this.pointed(event));
    this.canvas.addEventListener("pointerleave", () => this.left());
    this.canvas.addEventListener("keydown", (event) => this.pressed(event));
    new ResizeObserver(() => this.resized()).observe(this.canvas);
    window.addEventListener("beforeprint", () => this.printing(() => this.steps.print()));
    window.addEventListener("afterprint", () => this.printing(() => this.steps.printed()));
  }

  pressed(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const actions = {
      ArrowLeft: () => this.navigation.pan(-PAN_SHARE, 0),
      ArrowRight: () => this.navigation.pan(PAN_SHARE, 0),
      ArrowUp: () => this.navigation.pan(0, PAN_SHARE),
      ArrowDown: () => this.navigation.pan(0, -PAN_SHARE),
      "+": () => this.navigation.zoomBy(ZOOM_STEP),
      "=": () => this.navigation.zoomBy(ZOOM_STEP),
      "-": () => this.navigation.zoomBy(1 / ZOOM_STEP),
      f: () => this.nextField(1),
      F: () => this.nextField(-1),
      m: () => this.find("#viewer-lines").click(),
      s: () => this.steps.next(1),
      S: () => this.steps.next(-1),
      t: () => this.tilt(),
    };
    const view = /^\d$/.test(event.key) ? this.views[Number(event.key)] : undefined;
    const action = view ? () => this.fly(view) : (actions[event.key] ?? actions[event.key.toLowerCase()]);
    if (!action) return;
    event.preventDefault();
    this.pointer = null;
    this.cross.hidden = false;
    action();
    this.read();
  }

  // what is shown

  chooseField(key) {
    this.field = this.fields.find((field) => field.key === key);
    this.find("#viewer-field").value = key;
    if (this.scale.mode.value === "own") this.scale.mode.value = "robust";
    this.canvas.setAttribute("aria-label", `Picture of the parts, coloured by ${this.field.name} in ${this.field.unit}`);
    this.recolour();
  }

  nextField(step) {
    const { fields } = this;
    this.chooseField(fields[(fields.indexOf(this.field) + step + fields.length) % fields.length].key);
  }

  chooseStep(words) {
    for (const part of this.parts) stepTo(part, this.steps.at);
    this.picture.setMotion();
    this.recolour();
    this.reading.tellFirst(words);
  }

  recolour() {
    const smooth = this.find("#viewer-smooth").checked;
    this.picture.setValues(
      this.parts.map((part) => {
        const values = valuesOf(part, this.field);
        if (smooth && jumps(part, this.field)) return { values: smoothed(part, this.field, values), perCell: false };
        return { values, perCell: onCells(part, this.field) };
      })
    );
    this.rerange();
    this.read();
  }

  rerange() {
    const common = this.find("#viewer-common").checked;
    const steps = common ? Array.from({ length: this.steps.last + 1 }, (_, step) => step) : [this.steps.at];
    const sizes = this.shownParts().flatMap((part) => steps.map((step) => sizeOf(part, this.field, step)));
    const range = this.scale.rangeFor(rangeOver(steps.map((step) => this.rangeAt(step))), Math.max(0, ...sizes));
    const table = colourTable(signOf(range));
    this.picture.shared.range.value = [range.low, range.high];
    this.picture.setTable(table);
    const where = common ? "In all load steps" : "In this load step";
    this.scale.show(this.field, range, table, this.steps.last > 0 ? where : "");
    this.picture.renderSoon();
  }

  // Range of the field in the shown parts at a step.
  rangeAt(step) {
    const parts = this.shownParts();
    const key = [this.field.key, step, ...parts.map((part) => this.parts.indexOf(part))].join();
    if (!this.ranges.has(key)) this.ranges.set(key, rangeOf(parts.map((part) => valuesOf(part, this.field, step)), TAIL));
    return this.ranges.get(key);
  }

  deform(factor, source = null) {
    this.factor = factor;
    this.picture.shared.factor.value = factor;
    const [slider, number] = [this.find("#viewer-slider"), this.find("#viewer-factor")];
    slider.value = sliderOf(factor);
    slider.setAttribute("aria-valuetext", `${shown(factor, 3)} times`);
    if (source !== number) {
      number.value = Number(factor.toPrecision(3));
      number.removeAttribute("aria-invalid");
    }
    this.read();
    this.picture.renderSoon();
  }

  showPart(part, visible) {
    part.hidden = !visible;
    this.picture.items.find((item) => item.part === part).group.visible = visible;
    this.rerange();
    this.read();
  }

  // Look at a picture with heights from above, or tilted again.
  tilt() {
    if (!this.picture.solid) return;
    this.tilted = !this.tilted;
    this.picture.shared.shade.value = this.tilted ? SHADE : 0;
    this.navigation.turn(this.tilted ? TILTED : ABOVE);
    this.find("#viewer-tilt").textContent = this.tilted ? "from above" : "tilted";
    this.read();
  }

  showLines() {
    for (const item of this.picture.items) item.mesh.visible = this.find("#viewer-lines").checked;
    this.picture.renderSoon();
  }

  fly(view) {
    this.navigation.fly(view.box(), () => this.read());
    this.reading.tell(`Flying to: ${view.name}`);
  }

  printing(change) {
    change();
    this.rerange();
    this.picture.render();
  }

  // pointer

  pointed(event) {
    const box = this.canvas.getBoundingClientRect();
    this.pointer = [event.clientX - box.left, event.clientY - box.top];
    this.cross.hidden = true;
    this.read();
  }

  left() {
    if (!this.pointer) return;
    this.pointer = undefined;
    this.mark();
  }

  // Read at the pointer, or at the cross while keys are used; without both the material that was read last.
  read() {
    if (this.pointer === undefined) {
      if (this.found) this.reading.show(this.found.part.hidden ? null : this.found, this.field);
      return;
    }
    const pixel = this.pointer ?? [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2];
    this.found = this.picture.solid
      ? cellInFront(this.parts, pixel, (place) => this.navigation.pixelOf(place), this.factor)
      : cellAt(this.parts, ...this.navigation.placeAt(...pixel), this.factor);
    this.reading.show(this.found, this.field);
    this.mark();
  }

  // Outline the cell that is read.
  mark() {
    const corners = this.found && this.pointer !== undefined ? outlineOf(this.found.part, this.found.cell, this.factor) : [];
    const pixels = corners.map((corner) => this.navigation.pixelOf(corner).slice(0, 2).map((at) => at.toFixed(1)).join());
    this.find(".viewer-mark polygon").setAttribute("points", pixels.join(" "));
  }

  moved() {
    const zoom = this.picture.camera.zoom;
    const bar = this.find(".viewer-length");
    const length = roundBelow(LONGEST_BAR / zoom);
    // a share of the picture, which paper makes smaller
    bar.style.width = `${(100 * length * zoom) / this.canvas.clientWidth}%`;
    bar.firstElementChild.textContent = `${shown(length)} ${this.unit}`;
    this.mark();
    this.picture.renderSoon();
  }

  resized() {
    if (!this.canvas.clientWidth) return;
    this.picture.resize(this.canvas.clientWidth, this.canvas.clientHeight);
    this.moved();
    this.picture.render();
  }
}

function widened([x0, y0, x1, y1]) {
  const margin = MARGIN * Math.max(x1 - x0, y1 - y0);
  return [x0 - margin, y0 - margin, x1 + margin, y1 + margin];
}

// The parts of each side of the track, from the least x on.
function sideGroups(parts) {
  const sides = [...new Set(parts.map((part) => part.side))];
  const groups = sides.map((side) => parts.filter((part) => part.side === side));
  return groups.sort((a, b) => a[0].origin[0] - b[0].origin[0]);
}

// A view for each side of the track, if there are several.
function sidesOf(parts, viewer) {
  const groups = sideGroups(parts);
  if (groups.length < 2) return [];
  return groups.map((group) => ({ name: `${group[0].side} rail`, box: () => widened(boxOf(group, viewer.factor)) }));
}

// A view about a place; it moves with the side whose part is nearest.
function givenView({ name, centre, width }, parts) {
  const away = (part) => Math.hypot(part.origin[0] - centre[0], part.origin[1] - centre[1]);
  const nearest = parts.reduce((best, part) => (away(part) < away(best) ? part : best));
  const half = width / 2;
  const box = () => {
    const x = centre[0] + nearest.shift;
    return [x - half, centre[1] - half / 2, x + half, centre[1] + half / 2];
  };
  return { name, box };
}

// The slider: the first fifth is linear from 0 to 1, the rest goes by powers up to the largest factor.
function factorOf(slider) {
  const share = slider / 1000;
  if (share <= LINEAR_SHARE) return share / LINEAR_SHARE;
  return LARGEST_FACTOR ** ((share - LINEAR_SHARE) / (1 - LINEAR_SHARE));
}

function sliderOf(factor) {
  if (factor <= 1) return Math.round(1000 * LINEAR_SHARE * factor);
  return Math.round(1000 * (LINEAR_SHARE + ((1 - LINEAR_SHARE) * Math.log(factor)) / Math.log(LARGEST_FACTOR)));
}

async function startViewer() {
  const root = document.getElementById("viewer");
  const [message, body] = [root.querySelector(".viewer-message"), root.querySelector(".viewer-body")];
  const instead = message.textContent.replace("The interactive picture is being made ready.", "").trim();
  const fail = (reason) => {
    message.textContent = `${reason} ${instead}`.trim();
    root.dataset.state = "failed";
    body.hidden = true;
  };
  if (!document.createElement("canvas").getContext("webgl2")) {
    return fail("This browser shows no interactive picture: it has no WebGL 2, or it is switched off.");
  }
  if (typeof DecompressionStream === "undefined") {
    return fail("This browser is too old for the interactive picture: it cannot inflate data.");
  }
  try {
    const header = JSON.parse(document.getElementById("viewer-header").textContent);
    const parts = await unpacked(header, document.getElementById("viewer-data").textContent);
    for (const part of parts) {
      part.step = Math.max(0, header.steps.length - 1);
      prepare(part);
    }
    body.hidden = false;
    new Viewer(root, parts, header);
    message.hidden = true;
    root.dataset.state = "ready";
  } catch (error) {
    console.error(error);
    fail(`The interactive picture could not be made: ${error.message}.`);
  }
}

// Within a fold it starts when that is opened: a hidden picture has no size.
function startWhenShown() {
  const fold = document.getElementById("viewer").closest("details:not([open])");
  if (fold) fold.addEventListener("toggle", startViewer, { once: true });
  else startViewer();
}
