// What drawing and searching need of a part's polygons: offsets, areas, triangles, edges, motion.

function prepare(part) {
  const n = part.sizes.length;
  part.offsets = new Uint32Array(n + 1);
  for (let i = 0; i < n; i++) part.offsets[i + 1] = part.offsets[i] + part.sizes[i];
  part.cellOfCorner = new Uint32Array(part.corners.length);
  for (let i = 0; i < n; i++) part.cellOfCorner.fill(i, part.offsets[i], part.offsets[i + 1]);
  part.areas = Float32Array.from({ length: n }, (_, cell) => areaOf(part, cell));
  Object.assign(part, trianglesOf(part), edgesOf(part));
  stepTo(part, part.step);
  return part;
}

function cross(part, a, b, c) {
  const p = part.points;
  const abx = p[2 * b] - p[2 * a];
  const aby = p[2 * b + 1] - p[2 * a + 1];
  return abx * (p[2 * c + 1] - p[2 * a + 1]) - aby * (p[2 * c] - p[2 * a]);
}

function areaOf(part, cell) {
  let twice = 0;
  const first = part.corners[part.offsets[cell]];
  for (let i = part.offsets[cell] + 1; i + 1 < part.offsets[cell + 1]; i++) {
    twice += cross(part, first, part.corners[i], part.corners[i + 1]);
  }
  return Math.abs(twice) / 2;
}

// Triangles as places in `corners`: fans, or ears where a fan would leave the cell; and the first one of each cell.
function trianglesOf(part) {
  const triangles = new Uint32Array(3 * (part.corners.length - 2 * part.sizes.length));
  const firstTriangle = new Uint32Array(part.sizes.length + 1);
  let n = 0;
  for (let cell = 0; cell < part.sizes.length; cell++) {
    const start = part.offsets[cell];
    const size = part.sizes[cell];
    if (size === 3 || isFan(part, start, size)) {
      for (let i = 1; i + 1 < size; i++) {
        triangles[n++] = start;
        triangles[n++] = start + i;
        triangles[n++] = start + i + 1;
      }
    } else {
      const outline = Array.from(part.corners.subarray(start, start + size), (point) => pointAt(part, point));
      for (const triple of viewerLibraries.ShapeUtils.triangulateShape(outline, [])) {
        for (const corner of triple) triangles[n++] = start + corner;
      }
    }
    firstTriangle[cell + 1] = n / 3;
  }
  return { triangles: triangles.subarray(0, n), firstTriangle };
}

function pointAt(part, point) {
  return new viewerLibraries.Vector2(part.points[2 * point], part.points[2 * point + 1]);
}

// Whether a fan about the first corner fills the cell: so it is for convex cells and some others.
function isFan(part, start, size) {
  const first = part.corners[start];
  for (let i = 1; i + 1 < size; i++) {
    if (cross(part, first, part.corners[start + i], part.corners[start + i + 1]) < 0) return false;
  }
  return true;
}

// Edges once each, as pairs of points, and those of the boundary, which have one cell. Of cells that were cut to be drawn
// only the rims count: their places have the numbers below `rim`.
function edgesOf(part) {
  const n = part.points.length / 2;
  const rim = part.rim ?? n;
  const keys = new Float64Array(part.corners.length);
  const pointAtPlace = part.places ? new Uint32Array(n) : null;
  part.places?.forEach((place, point) => (pointAtPlace[place] = point));
  let used = 0;
  for (let cell = 0; cell < part.sizes.length; cell++) {
    const [start, end] = [part.offsets[cell], part.offsets[cell + 1]];
    for (let i = start; i < end; i++) {
      let a = part.corners[i];
      let b = part.corners[i + 1 < end ? i + 1 : start];
      if (part.places) [a, b] = [part.places[a], part.places[b]];
      if (a < rim && b < rim) keys[used++] = a < b ? a * n + b : b * n + a;
    }
  }
  return edgesOfKeys(keys.subarray(0, used).sort(), n, pointAtPlace);
}

// The edges of sorted keys, each as often as it has cells.
function edgesOfKeys(keys, n, pointAtPlace) {
  const edges = new Uint32Array(2 * keys.length);
  const boundary = [];
  let count = 0;
  for (let i = 0; i < keys.length; ) {
    let next = i + 1;
    while (next < keys.length && keys[next] === keys[i]) next++;
    let low = Math.floor(keys[i] / n);
    let high = keys[i] - low * n;
    if (pointAtPlace) [low, high] = [pointAtPlace[low], pointAtPlace[high]];
    edges[count++] = low;
    edges[count++] = high;
    if (next === i + 1) boundary.push(low, high);
    i = next;
  }
  return { edges: edges.slice(0, count), boundary: Uint32Array.from(boundary) };
}

// Places at first touch and motion since then, x, y, motion x, motion y of each point, from the part's origin; the
// motion is that at the part's step.
function motionOf(part) {
  const { points, rigid } = part;
  const array = part.arrays.displacement;
  const displacement = array ? numbersAt(array, part.step) : new Float32Array(points.length);
  const n = displacement.length / 2;
  const motion = new Float32Array(2 * points.length);
  for (let i = 0; i < points.length; i += 2) {
    for (let axis = 0; axis < 2; axis++) {
      const moved = rigid[0][axis] * points[i] + rigid[1][axis] * points[i + 1] + rigid[2][axis];
      motion[2 * i + axis] = points[i + axis] - moved;
      const at = array?.on === "places" ? part.places[i / 2] : i / 2;
      motion[2 * i + 2 + axis] = moved + displacement[axis * n + at];
    }
  }
  return motion;
}

// Move a part to what it is at a step.
function stepTo(part, step) {
  part.step = step;
  part.motion = motionOf(part);
  part.boxes = undefined;
}

// Where a point is drawn, along one axis, from the part's origin.
function drawn(part, point, axis, factor) {
  return part.motion[4 * point + axis] + factor * part.motion[4 * point + 2 + axis];
}

function heightOf(part, point) {
  return part.heights ? part.heights[point] : 0;
}

// Box of the parts as they are drawn, in mm: least x, least y, greatest x, greatest y.
function boxOf(parts, factor) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const part of parts) {
    for (let point = 0; 2 * point < part.points.length; point++) {
      for (let axis = 0; axis < 2; axis++) {
        const at = part.origin[axis] + (axis === 0 ? (part.shift ?? 0) : 0) + drawn(part, point, axis, factor);
        if (at < box[axis]) box[axis] = at;
        if (at > box[axis + 2]) box[axis + 2] = at;
      }
    }
  }
  return box;
}
