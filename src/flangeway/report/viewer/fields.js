// The fields, by the names that they have in the VTU files. `of` a cell gets xx, yy, xy, zz; of a point ux, uy.

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

const STRESSES = "Stresses, means of cells";
const DISPLACEMENTS = "Elastic displacement of points";

const FIELDS = [
  { key: "von_mises_MPa", name: "von Mises stress", of: vonMisesOf },
  { key: "principal_1_MPa", name: "principal stress 1 (greatest)", of: (...s) => principalsOf(...s)[0] },
  { key: "principal_2_MPa", name: "principal stress 2", of: (...s) => principalsOf(...s)[1] },
  { key: "principal_3_MPa", name: "principal stress 3 (least)", of: (...s) => principalsOf(...s)[2] },
  { key: "max_in_plane_shear_MPa", name: "largest in-plane shear", of: radiusOf },
  { key: "stress_xx_MPa", name: "stress xx", of: (xx) => xx },
  { key: "stress_yy_MPa", name: "stress yy", of: (xx, yy) => yy },
  { key: "stress_xy_MPa", name: "stress xy", of: (xx, yy, xy) => xy },
  { key: "stress_zz_MPa", name: "stress zz", of: (xx, yy, xy, zz) => zz },
  { key: "displacement_mm", name: "displacement, magnitude", of: Math.hypot, onPoints: true },
  { key: "displacement_mm:x", name: "displacement x", of: (x) => x, onPoints: true },
  { key: "displacement_mm:y", name: "displacement y", of: (x, y) => y, onPoints: true },
].map((field) => ({
  ...field,
  unit: field.onPoints ? "mm" : "MPa",
  group: field.onPoints ? DISPLACEMENTS : STRESSES,
}));

// Values of a field on a part's cells or points; each is computed once.
function valuesOf(part, field) {
  part.values ??= new Map();
  if (!part.values.has(field.key)) {
    part.values.set(field.key, field.onPoints ? pointValues(part, field) : cellValues(part, field));
  }
  return part.values.get(field.key);
}

function cellValues(part, field) {
  const n = part.sizes.length;
  const s = part.stresses;
  const values = new Float32Array(n);
  for (let i = 0; i < n; i++) values[i] = field.of(s[i], s[n + i], s[2 * n + i], s[3 * n + i]);
  return values;
}

function pointValues(part, field) {
  const d = part.displacement;
  const values = new Float32Array(d.length / 2);
  for (let i = 0; i < values.length; i++) values[i] = field.of(d[2 * i], d[2 * i + 1]);
  return values;
}

// Means of cells' values about each point, weighted by area: what is drawn in smooth colours.
function smoothed(part, values) {
  const n = part.points.length / 2;
  const sums = new Float64Array(n);
  const totals = new Float64Array(n);
  for (let cell = 0; cell < values.length; cell++) {
    const area = part.areas[cell];
    for (let i = part.offsets[cell]; i < part.offsets[cell + 1]; i++) {
      sums[part.corners[i]] += area * values[cell];
      totals[part.corners[i]] += area;
    }
  }
  return Float32Array.from(sums, (sum, i) => (totals[i] > 0 ? sum / totals[i] : 0));
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
