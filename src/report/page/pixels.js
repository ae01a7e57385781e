// Pixels of a page: decoding of deflated half floats, display on a canvas, and text of values.

/** Values of all half floats (IEEE 754 binary16). */
const HALF_FLOATS = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; ++bits) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, mantissa = bits & 1023;
    table[bits] = sign * (exponent === 31 ? (mantissa ? NaN : Infinity)
      : exponent === 0 ? mantissa * 2 ** -24 : (1 + mantissa / 1024) * 2 ** (exponent - 15));
  }
  return table;
})();

async function inflate(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Decodes a typed array, whose bytes are in planes: the first bytes of all numbers, then the second bytes. */
async function decodeNumbers(base64, Type) {
  const planes = await inflate(base64), stride = Type.BYTES_PER_ELEMENT, count = planes.length / stride;
  const bytes = new Uint8Array(planes.length);
  for (let k = 0; k < stride; ++k)
    for (let i = 0; i < count; ++i) bytes[i * stride + k] = planes[k * count + i];
  return new Type(bytes.buffer);
}

/** Decodes linear RGB by pixel, from planes: the upper bytes of red, green and blue, then the lower bytes. */
async function decodeLayer(layer, pixels) {
  const bytes = await inflate(layer.pixels), out = new Float32Array(pixels * 3), unit = 2 ** -layer.scale;
  if (bytes.length !== pixels * 6) throw new Error(`the pixels of ${layer.name} are not complete`);
  for (let c = 0; c < 3; ++c)
    for (let p = 0; p < pixels; ++p)
      out[p * 3 + c] = unit * HALF_FLOATS[bytes[c * pixels + p] << 8 | bytes[(3 + c) * pixels + p]];
  return out;
}

const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

/** Automatic exposure by the program's rule, for sums that only exist in the page. */
function automaticExposure(values) {
  const lights = [];
  for (let i = 0; i < values.length; i += 3) {
    const y = luminance(values[i], values[i + 1], values[i + 2]);
    if (y > 0 && y < Infinity) lights.push(y);
  }
  if (lights.length === 0) return 0;
  const sorted = Float32Array.from(lights).sort();
  const white = ((0.9 + 0.055) / 1.055) ** 2.4;
  return Math.log2(white / sorted[Math.floor((sorted.length - 1) * 0.98)]);
}

/** Table of sRGB bytes of linear values in [0, 1], at equal steps of the square root, which resolves dark values. */
const SRGB_STEPS = 8191;
const SRGB = Uint8ClampedArray.from({ length: SRGB_STEPS + 1 }, (_, i) => {
  const x = (i / SRGB_STEPS) ** 2;
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
});

/** Paints the values for a display on a canvas. `exposure` [stops]. */
function paint(canvas, values, width, height, exposure) {
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d"), image = context.createImageData(width, height);
  const scale = 2 ** exposure, bytes = image.data;
  for (let p = 0, i = 0; i < values.length; p += 4) {
    for (let c = 0; c < 3; ++c) {
      const x = values[i++] * scale;
      bytes[p + c] = x > 0 ? SRGB[Math.round(Math.sqrt(Math.min(x, 1)) * SRGB_STEPS)] : 0;
    }
    bytes[p + 3] = 255;
  }
  context.putImageData(image, 0, 0);
}

function formatValue(x) {
  if (x === 0 || !Number.isFinite(x)) return String(x);
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(3) : x.toPrecision(4);
}
const formatRgb = (values, i) => [0, 1, 2].map((c) => formatValue(values[i * 3 + c])).join("  ");
const formatShare = (x) => `${(100 * x).toFixed(2)} %`;
