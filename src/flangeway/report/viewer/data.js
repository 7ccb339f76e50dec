// The packed arrays of the parts, as packing.py writes them.

async function unpacked(header, text) {
  const bytes = await inflated(bytesOfBase64(text));
  let start = 0;
  return header.parts.map(({ arrays, ...part }) => {
    part.arrays = {};
    for (const [name, type, count, on, components, steps] of arrays) {
      const plain = interleaved(bytes.subarray(start, start + 4 * count), count);
      const numbers = type === "f4" ? new Float32Array(plain) : new Uint32Array(plain);
      if (on) part.arrays[name] = { on, components, steps, numbers };
      else part[name] = numbers;
      start += 4 * count;
    }
    for (const name of ["corners", "places", "cells"]) if (part[name]) undoDifferences(part[name]);
    if (part.places && part.heights) part.heights = spread(part, part.heights, 1);
    if (part.places) part.points = spread(part, part.points, 2);
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

// Numbers of each point from those of its place, as many in a row.
function spread({ places }, numbers, row) {
  return Float32Array.from({ length: row * places.length }, (_, i) => numbers[row * places[Math.floor(i / row)] + (i % row)]);
}

// Numbers of an array at a step, component after component.
function numbersAt({ numbers, steps }, step) {
  const count = numbers.length / steps;
  const first = count * Math.min(step, steps - 1);
  return numbers.subarray(first, first + count);
}
