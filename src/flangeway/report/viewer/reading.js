// The value under the pointer, or at the cross in the middle for keyboard users; announced to screen readers when it stops.

const REST_MS = 500;

class Reading {
  constructor(root, { unit, axes, deforms }) {
    this.axes = axes;
    this.end = deforms ? ` ${unit}, undeformed` : ` ${unit}`;
    this.unit = unit;
    this.output = root.querySelector(".viewer-reading");
    this.live = root.querySelector(".viewer-live");
  }

  // `found` is what cellAt gives.
  show(found, field) {
    this.output.replaceChildren();
    if (!found) {
      this.add("span", "viewer-what", "no part here");
      return this.tell();
    }
    const { part, cell, point, at } = found;
    const perCell = onCells(part, field);
    const value = valuesOf(part, field)[perCell ? cell : point];
    const number = part.cells ? part.cells[cell] : cell;
    const main = this.add("span", "viewer-value");
    this.add("data", "reading-value", `${shown(value, 6)} ${field.unit}`, value, main);
    const what = this.add("span", "viewer-what", `${field.name}, `);
    this.add("data", "reading-part", part.name, part.name, what);
    what.append(perCell ? ", cell " : ", point ");
    if (perCell) this.add("data", "reading-cell", String(number), number, what);
    else this.add("data", "reading-point", String(point), point, what);
    at.forEach((value, i) => {
      what.append(i ? ` ${this.unit}, ${this.axes[i]} ` : ` at ${this.axes[i]} `);
      this.add("data", `reading-${this.axes[i]}`, fixed(value), value, what);
    });
    what.append(this.end);
    if (!perCell) this.add("data", "reading-cell", ` (cell ${number})`, number, what);
    this.tell();
  }

  add(tag, name, text = "", value = undefined, parent = this.output) {
    const element = document.createElement(tag);
    element.className = name;
    element.textContent = text;
    if (value !== undefined) element.value = value;
    parent.append(element);
    return element;
  }

  tell(text = undefined) {
    clearTimeout(this.timer);
    const words = text ?? Array.from(this.output.children, (child) => child.textContent).join(": ");
    this.timer = setTimeout(() => {
      this.live.textContent = [this.first, words].filter(Boolean).join("; ");
      this.first = "";
    }, REST_MS);
  }

  // Announce some words before the next value.
  tellFirst(words) {
    this.first = words;
    this.tell();
  }
}

function fixed(value) {
  return value.toFixed(3).replace("-", "\u2212");
}
