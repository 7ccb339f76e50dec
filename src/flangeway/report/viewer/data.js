// The packed arrays of the parts, as packing.py writes them.

async function unpacked(header, text) {
  const bytes = await inflated(bytesOfBase64(text));
  let start = 0;
  return header.parts.map((described) => {
    const part = { name: described.name, side: described.side, origin: described.origin, rigid: described.rigid };
    for (const [name, type, count] of described.arrays) {
      const plain = interleaved(bytes.subarray(start, start + 4 * count), count);
      part[name] = type === "f4" ? new Float32Array(plain) : new Uint32Array(plain);
      start += 4 * count;
    }
    undoDifferences(part.corners);
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
