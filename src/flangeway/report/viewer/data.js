// The packed arrays of the parts, as packing.py writes them.

async function unpacked(header, text) {
  const bytes = await inflated(bytesOfBase64(text));
  let start = 0;
  return header.parts.map(({ arrays, ...part }) => {
    part.arrays = {};
    for (const [name, type, count, on, components] of arrays) {
      const plain = interleaved(bytes.subarray(start, start + 4 * count), count);
      const numbers = type === "f4" ? new Float32Array(plain) : new Uint32Array(plain);
      if (on) part.arrays[name] = { on, components, numbers };
      else part[name] = numbers;
      start += 4 * count;
    }
    for (const name of ["corners", "places", "cells"]) if (part[name]) undoDifferences(part[name]);
    if (part.places) spread(part);
    return part;
  });
}

function bytesOfBase64(text) {
  const characters = atob(text.trim());
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// All first bytes, then all second ones ...: back to numbers of four bytes.
function interleaved(planes, count) {
  const bytes = new Uint8Array(4 * count);
  for (let plane = 0; plane < 4; plane++) {
    const from = plane * count;
    for (let i = 0; i < count; i++) bytes[4 * i + plane] = planes[from + i];
  }
  return bytes.buffer;
}

function undoDifferences(numbers) {
  for (let i = 1; i < numbers.length; i++) numbers[i] += numbers[i - 1];
}

// Give each point the coordinates and values of its place.
function spread(part) {
  const { places, points } = part;
  part.points = Float32Array.from({ length: 2 * places.length }, (_, i) => points[2 * places[i >> 1] + (i & 1)]);
  for (const array of Object.values(part.arrays)) {
    if (array.on !== "places") continue;
    const n = points.length / 2;
    const spread = new Float32Array(array.components * places.length);
    for (let c = 0; c < array.components; c++) {
      for (let i = 0; i < places.length; i++) spread[c * places.length + i] = array.numbers[c * n + places[i]];
    }
    array.numbers = spread;
  }
}
