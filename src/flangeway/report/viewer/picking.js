// Which cell is drawn at a place, and where its material lies in the undeformed part.

function cellAt(parts, x, y, factor) {
  for (let i = parts.length - 1; i >= 0; i--) {
    const part = parts[i];
    if (part.hidden) continue;
    const [localX, localY] = [x - part.origin[0] - part.shift, y - part.origin[1]];
    for (const cell of boxesOf(part, factor).search(localX, localY, localX, localY)) {
      const found = inCell(part, cell, localX, localY, factor);
      if (found) return { part, cell, ...found };
    }
  }
  return null;
}

// The cell in front at a pixel of a picture with heights; `pixelOf` gives pixel and depth of a place.
function cellInFront(parts, pixel, pixelOf, factor) {
  let best = null;
  for (const part of parts.filter((each) => !each.hidden)) {
    const n = part.points.length / 2;
    const seen = Array.from({ length: n }, (_, point) => pixelOf(placeOf(part, point, factor)));
    for (let cell = 0; cell < part.sizes.length; cell++) {
      for (let t = part.firstTriangle[cell]; t < part.firstTriangle[cell + 1]; t++) {
        const points = [0, 1, 2].map((i) => part.corners[part.triangles[3 * t + i]]);
        const [a, b, c] = points.map((point) => seen[point]);
        if (pixel.some((at, i) => at < Math.min(a[i], b[i], c[i]) || at > Math.max(a[i], b[i], c[i]))) continue;
        const shares = sharesOf([a, b, c], ...pixel);
        if (shares.some((share) => !(share >= -1e-9))) continue;
        const mean = (of) => points.reduce((sum, point, i) => sum + shares[i] * of(point), 0);
        const depth = mean((point) => seen[point][2]);
        if (best && depth >= best.depth) continue;
        const at = [0, 1].map((axis) => part.origin[axis] + mean((point) => part.points[2 * point + axis]));
        const point = points[shares.indexOf(Math.max(...shares))];
        best = { part, cell, point, depth, at: [...at, mean((each) => heightOf(part, each))] };
      }
    }
  }
  return best;
}

// Where a point is drawn, in mm, and its height.
function placeOf(part, point, factor) {
  const [x, y] = [0, 1].map((axis) => part.origin[axis] + drawn(part, point, axis, factor));
  return [x + part.shift, y, heightOf(part, point)];
}

// Boxes of the cells as they are drawn; made again when the deformation is drawn otherwise.
function boxesOf(part, factor) {
  if (part.boxes?.factor === factor) return part.boxes.index;
  const index = new viewerLibraries.Flatbush(part.sizes.length, 16, Float64Array);
  for (let cell = 0; cell < part.sizes.length; cell++) {
    let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = part.offsets[cell]; i < part.offsets[cell + 1]; i++) {
      const px = drawn(part, part.corners[i], 0, factor);
      const py = drawn(part, part.corners[i], 1, factor);
      if (px < x0) x0 = px;
      if (px > x1) x1 = px;
      if (py < y0) y0 = py;
      if (py > y1) y1 = py;
    }
    index.add(x0, y0, x1, y1);
  }
  index.finish();
  part.boxes = { factor, index };
  return index;
}

// The nearest corner, and the place of the material in the undeformed part; null outside of the cell.
function inCell(part, cell, x, y, factor) {
  for (let t = part.firstTriangle[cell]; t < part.firstTriangle[cell + 1]; t++) {
    const points = [0, 1, 2].map((i) => part.corners[part.triangles[3 * t + i]]);
    const shares = sharesOf(points.map((point) => [drawn(part, point, 0, factor), drawn(part, point, 1, factor)]), x, y);
    if (shares.some((share) => !(share >= -1e-9))) continue;
    const at = [0, 1].map(
      (axis) => part.origin[axis] + points.reduce((sum, p, i) => sum + shares[i] * part.points[2 * p + axis], 0)
    );
    return { point: nearestCorner(part, cell, x, y, factor), at };
  }
  return null;
}

// Corners of a cell as they are drawn, in mm.
function outlineOf(part, cell, factor) {
  const corners = part.corners.subarray(part.offsets[cell], part.offsets[cell + 1]);
  return Array.from(corners, (point) => placeOf(part, point, factor));
}

function sharesOf([a, b, c], x, y) {
  const whole = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / whole;
  const third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / whole;
  return [1 - second - third, second, third];
}

function nearestCorner(part, cell, x, y, factor) {
  let [nearest, least] = [-1, Infinity];
  for (let i = part.offsets[cell]; i < part.offsets[cell + 1]; i++) {
    const point = part.corners[i];
    const distance = Math.hypot(drawn(part, point, 0, factor) - x, drawn(part, point, 1, factor) - y);
    if (distance < least) [nearest, least] = [point, distance];
  }
  return nearest;
}
