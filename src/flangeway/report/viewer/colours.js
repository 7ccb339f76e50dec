// Colours of values, as in the pictures: what is far from zero is dark, on a light ground whatever the page's theme.

const MAPS = {
  oneSign: "fcf0b2 fed395 feb47b fd9668 f9785d ed5a5f d9466b c03a76 a6317d 8b2981 721f81 59157e 3f0f72 221150 0e0b2b",
  bothSigns: "0b2f6b 1f5fa8 5f97cc a9c8e3 eeeeea f0c09a dd8a52 b3501e 6b2705",
};
const N_COLOURS = 256;

// Which colours a range of values gets: `sign` is -1 where the negative end is to stand out, 0 for both ends.
function signOf(range) {
  const share = Math.min(-range.low, range.high) / Math.max(-range.low, range.high);
  if (range.low < 0 && range.high > 0 && share > 0.15) return 0;
  return Math.abs(range.low) > Math.abs(range.high) ? -1 : 1;
}

// 256 colours as bytes red, green, blue, 255.
function colourTable(sign) {
  const text = sign === 0 ? MAPS.bothSigns : MAPS.oneSign;
  const stops = text.split(" ").map((hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16)));
  if (sign < 0) stops.reverse();
  const table = new Uint8Array(4 * N_COLOURS);
  for (let i = 0; i < N_COLOURS; i++) {
    const at = (i / (N_COLOURS - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c++) {
      table[4 * i + c] = Math.round(stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]));
    }
    table[4 * i + 3] = 255;
  }
  return table;
}

function cssGradient(table) {
  const stops = [];
  for (let i = 0; i < N_COLOURS; i += 15) stops.push(`rgb(${table[4 * i]},${table[4 * i + 1]},${table[4 * i + 2]})`);
  return `linear-gradient(to right,${stops.join(",")})`;
}

// Round numbers within a range, six or fewer steps apart.
function ticksOf(low, high, wanted = 6) {
  if (!(high > low)) return [low];
  const raw = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * step; i++) ticks.push(i * step);
  return ticks;
}

// The greatest of 1, 2, 5, 10 ... that is not above a number.
function roundBelow(number) {
  const power = 10 ** Math.floor(Math.log10(number));
  return [5, 2, 1].map((factor) => factor * power).find((candidate) => candidate <= number * (1 + 1e-9));
}

// A number in a few digits, for people.
function shown(value, digits = 4) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e7) return value.toExponential(digits - 2).replace("-", "\u2212");
  return String(Number(value.toPrecision(digits))).replace("-", "\u2212");
}
