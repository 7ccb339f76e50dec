// Values of the fields that the page's header names, from the components of their arrays.

function radiusOf(xx, yy, xy) {
  return Math.hypot((xx - yy) / 2, xy);
}

function principalsOf(xx, yy, xy, zz) {
  const middle = (xx + yy) / 2;
  const radius = radiusOf(xx, yy, xy);
  return [middle + radius, middle - radius, zz].sort((a, b) => b - a);
}

function vonMisesOf(xx, yy, xy, zz) {
  const squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2;
  return Math.sqrt(squares / 2 + 3 * xy ** 2);
}

const FORMULAS = {
  value: (value) => value,
  x: (x) => x,
  y: (x, y) => y,
  magnitude: (x, y) => Math.hypot(x, y),
  "von-mises": vonMisesOf,
  "principal-1": (...s) => principalsOf(...s)[0],
  "principal-2": (...s) => principalsOf(...s)[1],
  "principal-3": (...s) => principalsOf(...s)[2],
  "in-plane-shear": radiusOf,
  xx: (xx) => xx,
  yy: (xx, yy) => yy,
  xy: (xx, yy, xy) => xy,
  zz: (xx, yy, xy, zz) => zz,
};

function onCells(part, field) {
  return part.arrays[field.array].on === "cells";
}

// Whether a field may jump from cell to cell, so that smooth colours are other colours.
function jumps(part, field) {
  const { on } = part.arrays[field.array];
  return on === "cells" || (on === "points" && part.places !== undefined);
}

// Values of a field on a part's cells or points at a step, by default the part's; each is computed once.
function valuesOf(part, field, step = part.step) {
  part.values ??= new Map();
  if (!part.values.has(field.key)) part.values.set(field.key, []);
  const found = part.values.get(field.key);
  found[step] ??= computed(part, field, step);
  return found[step];
}

function computed(part, field, step) {
  const { on, components } = part.arrays[field.array];
  const numbers = numbersAt(part.arrays[field.array], step);
  const of = FORMULAS[field.formula];
  const n = numbers.length / components;
  const [a, b, c, d] = [0, 1, 2, 3].map((i) => numbers.subarray(n * Math.min(i, components - 1)));
  const values = new Float32Array(n);
  for (let i = 0; i < n; i++) values[i] = of(a[i], b[i], c[i], d[i]);
  return on === "places" ? spread(part, values, 1) : values;
}

// The largest number that a field's values at a step are computed from.
function sizeOf(part, field, step) {
  const array = part.arrays[field.array];
  array.sizes ??= [];
  array.sizes[step] ??= numbersAt(array, step).reduce((most, number) => Math.max(most, Math.abs(number)), 0);
  return array.sizes[step];
}

// Means about each point, weighted by the cells' areas: what is drawn in smooth colours.
function smoothed(part, field, values) {
  const perCell = onCells(part, field);
  const n = part.points.length / 2;
  const sums = new Float64Array(n);
  const totals = new Float64Array(n);
  const place = (point) => (part.places ? part.places[point] : point);
  for (let cell = 0; cell < part.sizes.length; cell++) {
    const area = part.areas[cell];
    for (let i = part.offsets[cell]; i < part.offsets[cell + 1]; i++) {
      const at = place(part.corners[i]);
      sums[at] += area * values[perCell ? cell : part.corners[i]];
      totals[at] += area;
    }
  }
  return Float32Array.from(sums, (_, point) => {
    const at = place(point);
    return totals[at] > 0 ? sums[at] / totals[at] : 0;
  });
}

// Least and greatest value, and the bounds between which all but `tail` of the values at each end lie.
function rangeOf(arrays, tail) {
  const all = new Float32Array(arrays.reduce((count, values) => count + values.length, 0));
  let start = 0;
  for (const values of arrays) {
    all.set(values, start);
    start += values.length;
  }
  if (!all.length) return { least: 0, greatest: 0, low: 0, high: 0 };
  all.sort();
  const last = all.length - 1;
  const skipped = Math.floor(tail * last);
  return { least: all[0], greatest: all[last], low: all[skipped], high: all[last - skipped] };
}

// The range over several ranges.
function rangeOver(ranges) {
  const [least, low] = ["least", "low"].map((name) => Math.min(...ranges.map((range) => range[name])));
  const [greatest, high] = ["greatest", "high"].map((name) => Math.max(...ranges.map((range) => range[name])));
  return { least, greatest, low, high };
}
