// Global tone operators of the program, which need only the luminances of a picture, with their defaults; painting of a
// canvas by these and the operators of localTone.js. Formulas and sources: src/tonemaps.

const GREY_CARD = 0.18;

/** Scale of the input by which a rising curve maps the grey card to itself. */
function greyKeepingScale(curve) {
  let low = 0, high = 1;
  while (curve(high * GREY_CARD) < GREY_CARD) high *= 2;
  for (let i = 0; i < 50; ++i) {
    const middle = (low + high) / 2;
    if (curve(middle * GREY_CARD) < GREY_CARD) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

/** Operator that applies one curve to each channel. */
function channelCurve(curve) {
  const scale = greyKeepingScale(curve);
  return () => (colour) => { for (let c = 0; c < 3; ++c) colour[c] = curve(scale * colour[c]); };
}

function hable(x) {
  const A = 0.15, B = 0.50, C = 0.10, D = 0.20, E = 0.02, F = 0.30;
  return x * (A * (1 - E / F) * x + B * (C - E / F)) / (x * (A * x + B) + D * F);
}
const aces = (x) => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);

/** Scales a colour to luminance y; desaturates it if a channel would exceed 1. */
function setLuminance(colour, y) {
  const before = luminance(...colour);
  if (!(before > 0)) { colour.fill(0); return; }
  for (let c = 0; c < 3; ++c) colour[c] *= y / before;
  const largest = Math.max(...colour);
  if (largest <= 1) return;
  const part = y >= 1 ? 0 : (1 - y) / (largest - y);
  for (let c = 0; c < 3; ++c) colour[c] = y + (colour[c] - y) * part;
}

/** Quantile q of the luminances of a picture. Sorted luminances are cached, since sliders request them repeatedly. */
const quantiles = new WeakMap();
function luminanceQuantile(values, q) {
  let sorted = quantiles.get(values);
  if (!sorted) {
    sorted = new Float32Array(values.length / 3);
    for (let i = 0; i < sorted.length; ++i) {
      const y = luminance(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
      sorted[i] = Number.isFinite(y) ? Math.max(y, 0) : 0;
    }
    quantiles.set(values, sorted.sort());
  }
  return sorted[Math.floor(q * (sorted.length - 1))];
}

function reinhard(quantile) {
  const w = Math.max(1, quantile(0.999)), s = (1 - GREY_CARD / (w * w)) / (1 - GREY_CARD);
  return (colour) => {
    const y = luminance(...colour);
    setLuminance(colour, (s * y + y * y / (w * w)) / (1 + s * y));
  };
}

function drago(quantile) {
  const white = Math.max(10 * GREY_CARD, quantile(0.999)), exponent = Math.log(0.85) / Math.log(0.5);
  const curve = (y, scale) => {
    const t = Math.min(y / white, 1);
    return Math.min(1, Math.log1p(scale * t * white) * Math.log(10)
      / (Math.log1p(scale * white) * Math.log(2 + 8 * t ** exponent)));
  };
  let low = 1e-4, high = 1e4;
  for (let i = 0; i < 60; ++i) {
    const middle = Math.sqrt(low * high);
    if (curve(GREY_CARD, middle) < GREY_CARD) low = middle;
    else high = middle;
  }
  const scale = Math.sqrt(low * high);
  return (colour) => setLuminance(colour, curve(luminance(...colour), scale));
}

/** Operators by name. Each takes a function for quantiles of exposed luminance, and returns one that changes a colour. */
const TONE_OPERATORS = {
  none: () => () => {},
  filmic: channelCurve((x) => hable(x) / hable(11.2)),
  aces: channelCurve(aces),
  reinhard,
  drago,
};

/** Paints like paint() of pixels.js, by an operator; `direct`: the values without glare. */
function paintBy(operator, canvas, values, width, height, exposure, direct = values) {
  if (operator === "none") { paint(canvas, values, width, height, exposure); return; }
  const scale = 2 ** exposure;
  const exposed = (list) => list.map((v) => (Number.isFinite(v * scale) ? Math.min(Math.max(v * scale, 0), 1e9) : 0));
  const light = exposed(values);
  const shown = light.slice();
  if (LOCAL_OPERATORS[operator]) {
    LOCAL_OPERATORS[operator](shown, width, height);
  } else {
    const change = TONE_OPERATORS[operator]((q) => scale * luminanceQuantile(values, q));
    for (let i = 0; i < shown.length; i += 3) change(shown.subarray(i, i + 3));
  }
  mixBrightEdges(direct === values ? light : exposed(direct), light, shown, width, height);
  paint(canvas, shown, width, height, 0);
}

/** Fills a <select> with the operators, and calls onChange(name) when the user chooses one. */
function offerOperators(select, chosen, onChange) {
  for (const name of Object.keys({ ...TONE_OPERATORS, ...LOCAL_OPERATORS })) select.append(new Option(name, name));
  select.value = chosen;
  select.addEventListener("change", () => onChange(select.value));
}
