// The scale of colours: its bar with numbers, and the range that people choose.

const TAIL = 0.005;
const NOISE = 1e-6;

class Scale {
  constructor(root, changed) {
    this.bar = root.querySelector(".viewer-colours");
    this.ticks = root.querySelector(".viewer-ticks");
    this.title = root.querySelector(".viewer-scale-title");
    this.note = root.querySelector(".viewer-scale-note");
    this.mode = root.querySelector("#viewer-range");
    [this.low, this.high] = ["#viewer-low", "#viewer-high"].map((id) => root.querySelector(id));
    this.changed = changed;
    this.mode.addEventListener("change", changed);
    for (const input of [this.low, this.high]) {
      input.addEventListener("change", () => {
        this.mode.value = "own";
        changed();
      });
    }
  }

  // Range of colours for values in a range: robust, full, or the person's own while that makes sense. Differences that
  // are nothing beside the size of what the values were computed from are not shown.
  rangeFor(found, size) {
    let { low, high } = this.mode.value === "full" ? { low: found.least, high: found.greatest } : found;
    if (this.mode.value === "own") {
      const own = [this.low, this.high].map((input) => input.valueAsNumber);
      const sensible = own[1] > own[0];
      this.low.setAttribute("aria-invalid", String(!sensible));
      this.high.setAttribute("aria-invalid", String(!sensible));
      if (sensible) [low, high] = own;
    } else {
      for (const input of [this.low, this.high]) input.removeAttribute("aria-invalid");
      // one sign only: from zero, so that an unloaded part looks unloaded
      if (low > 0 && low < 0.3 * high) low = 0;
      if (high < 0 && high > 0.3 * low) high = 0;
      if (signOf({ low, high }) === 0) [low, high] = [-Math.max(-low, high), Math.max(-low, high)];
      if (!(high - low > NOISE * size)) [low, high] = [low - (size / 1000 || 0.5), high + (size / 1000 || 0.5)];
      this.low.value = Number(low.toPrecision(5));
      this.high.value = Number(high.toPrecision(5));
    }
    return { low, high, least: found.least, greatest: found.greatest };
  }

  // `where` is the step or steps that the range is of.
  show(field, range, table, where) {
    this.bar.style.background = cssGradient(table);
    this.title.textContent = `${field.name} in ${field.unit}`;
    this.ticks.replaceChildren();
    for (const tick of ticksOf(range.low, range.high)) {
      const label = document.createElement("span");
      label.textContent = shown(Math.abs(tick) < 1e-9 * (range.high - range.low) ? 0 : tick);
      label.style.left = `${(100 * (tick - range.low)) / (range.high - range.low)}%`;
      this.ticks.append(label);
    }
    const kind = this.mode.value === "robust" ? "Robust range, without the outermost 0.5 % of values at each end. " : "";
    const values = `${kind}${where ? `${where} the` : "The"} shown parts have ${shown(range.least, 5)} to ${shown(range.greatest, 5)} ${field.unit}`;
    const cut = range.least < range.low || range.greatest > range.high;
    this.note.textContent = cut ? `${values}; out-of-range values are clipped.` : `${values}.`;
  }
}
