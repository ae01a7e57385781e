// Local tone operators, which depend on a pixel's surroundings, with their defaults. Formulas, sources: src/tonemaps.

/** Blurs the rows of a field and transposes it: two calls blur both axes. */
function blurredTransposed(field, width, height, half) {
  const out = new Float32Array(field.length), reach = half.length - 1;
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      let sum = 0, weight = 0;
      for (let i = Math.max(0, x - reach); i <= Math.min(width - 1, x + reach); ++i) {
        const w = half[Math.abs(i - x)];
        sum += w * field[y * width + i];
        weight += w;
      }
      out[x * height + y] = sum / weight;
    }
  return out;
}

/** Gaussian blur, see gaussianBlur() of src/model/film/toneCurve.cpp: a wide blur uses a smaller picture. */
function gaussianBlur(field, width, height, sigma) {
  const factor = Math.max(1, Math.floor(sigma / 8)), w = Math.ceil(width / factor), h = Math.ceil(height / factor);
  const rest = factor > 1 ? Math.sqrt((sigma / factor) ** 2 - 0.25) : sigma;
  const half = Array.from({ length: Math.ceil(3.5 * rest) + 1 }, (_, i) => Math.exp(-0.5 * (i / rest) ** 2));
  const small = factor > 1 ? reducedField(field, width, height, factor) : field;
  const blurred = blurredTransposed(blurredTransposed(small, w, h, half), h, w, half);
  return factor > 1 ? enlargedField(blurred, width, height, factor) : blurred;
}

/** Reduced field: means of blocks of factor x factor pixels. */
function reducedField(field, width, height, factor) {
  const w = Math.ceil(width / factor), h = Math.ceil(height / factor);
  const out = new Float32Array(w * h), counts = new Float32Array(w * h);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const block = Math.floor(y / factor) * w + Math.floor(x / factor);
      out[block] += field[y * width + x];
      ++counts[block];
    }
  return out.map((sum, i) => sum / counts[i]);
}

/** Enlarged field, by bilinear interpolation between the centres of blocks. */
function enlargedField(blocks, width, height, factor) {
  const w = Math.ceil(width / factor), h = Math.ceil(height / factor), out = new Float32Array(width * height);
  const place = (i, n) => Math.min(Math.max((i + 0.5) / factor - 0.5, 0), n - 1);
  for (let y = 0; y < height; ++y) {
    const v = place(y, h), y0 = Math.floor(v), y1 = Math.min(y0 + 1, h - 1);
    for (let x = 0; x < width; ++x) {
      const u = place(x, w), x0 = Math.floor(u), x1 = Math.min(x0 + 1, w - 1);
      const row = (j) => blocks[j * w + x0] + (blocks[j * w + x1] - blocks[j * w + x0]) * (u - x0);
      out[y * width + x] = row(y0) + (row(y1) - row(y0)) * (v - y0);
    }
  }
  return out;
}

const luminances = (values) => Float32Array.from({ length: values.length / 3 },
  (_, i) => luminance(values[3 * i], values[3 * i + 1], values[3 * i + 2]));

/** Sets the luminance of each pixel i to newLuminance(i). */
function setLuminances(values, newLuminance) {
  for (let i = 0; 3 * i < values.length; ++i) setLuminance(values.subarray(3 * i, 3 * i + 3), newLuminance(i));
}

/** Dodging and burning of Reinhard et al. 2002, equations 5 to 9. */
function dodgeBurn(values, width, height) {
  const light = luminances(values).map((y) => y / (1 - GREY_CARD)), unit = 0.001 * Math.max(width, height);
  const blurred = (size) => gaussianBlur(light, width, height, 0.25 * size * unit);
  let centre = blurred(1);
  const adaptation = centre.slice(), ended = new Uint8Array(light.length);
  for (let scale = 0, size = 1; scale < 8; ++scale, size *= 1.6) {
    const surround = blurred(1.6 * size);
    for (let i = 0; i < light.length; ++i) {
      if (ended[i]) continue;
      adaptation[i] = centre[i];
      const difference = (centre[i] - surround[i]) / (2 ** 8 * GREY_CARD / (size * size) + centre[i]);
      ended[i] = Math.abs(difference) > 0.05;
    }
    centre = surround;
  }
  setLuminances(values, (i) => light[i] / (1 + adaptation[i]));
}

/** Bilateral filter, piecewise linear in the field's value. */
function bilateral(field, width, height, sigmaSpace, sigmaRange) {
  const low = field.reduce((a, b) => Math.min(a, b)), range = field.reduce((a, b) => Math.max(a, b)) - low;
  if (!(range > 0)) return field;
  const segments = Math.max(1, Math.ceil(range / (0.5 * sigmaRange))), step = range / segments;
  const out = new Float32Array(field.length);
  for (let j = 0; j <= segments; ++j) {
    const level = low + j * step, weight = field.map((v) => Math.exp(-0.5 * ((v - level) / sigmaRange) ** 2));
    const weights = gaussianBlur(weight, width, height, sigmaSpace);
    const sums = gaussianBlur(weight.map((w, i) => w * field[i]), width, height, sigmaSpace);
    for (let i = 0; i < field.length; ++i) {
      const share = 1 - Math.abs(field[i] - level) / step;
      if (share > 0) out[i] += share * sums[i] / weights[i];
    }
  }
  return out;
}

/** Operator of Durand and Dorsey 2002. */
function durand(values, width, height) {
  const light = luminances(values), brightest = light.reduce((a, b) => Math.max(a, b), 0);
  if (!(brightest > 0)) return;
  const base = bilateral(light.map((y) => Math.log10(Math.max(y, 1e-6 * brightest))), width, height,
    0.02 * Math.max(width, height), 0.4);
  const top = base.slice().sort()[Math.floor(0.999 * (base.length - 1))], grey = Math.log10(GREY_CARD);
  const contrast = top > 0 ? -grey / (top - grey) : 1;
  setLuminances(values, (i) => light[i] * 10 ** ((contrast - 1) * (base[i] - grey)));
}

/** Operators by name; each changes an exposed picture in place. */
const LOCAL_OPERATORS = { dodgeburn: dodgeBurn, durand };
