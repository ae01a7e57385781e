// Antialiasing of edges that are brighter than white, under a tone operator: src/report/develop/brightEdges.cpp.

function offsetsWithin(radius2) {
  const out = [], r = Math.floor(Math.sqrt(radius2));
  for (let y = -r; y <= r; ++y)
    for (let x = -r; x <= r; ++x) if (x * x + y * y <= radius2) out.push([x, y]);
  return out.sort((a, b) => a[0] ** 2 + a[1] ** 2 - b[0] ** 2 - b[1] ** 2); // stable sort
}
const EDGE_REACH2 = 6;
const EDGE_OFFSETS = offsetsWithin(EDGE_REACH2), SIDE_OFFSETS = offsetsWithin(25), EVEN = 0.8;

/** Changes `shown`, the tone-mapped `glaring`, which is the exposed picture; `light`: the same picture without glare. */
function mixBrightEdges(light, glaring, shown, width, height) {
  const brightness = Float32Array.from({ length: width * height },
    (_, i) => Math.max(light[3 * i], light[3 * i + 1], light[3 * i + 2]));
  /** First pixel, in the order of the offsets, for which `is` is true; -1 if there is none. */
  const find = (x, y, offsets, is) => {
    for (const [dx, dy] of offsets) {
      const i = x + dx, j = y + dy;
      if (i >= 0 && j >= 0 && i < width && j < height && is(j * width + i)) return j * width + i;
    }
    return -1;
  };
  /** Minimum and maximum brightness of a pixel and its neighbours. */
  const range = (x, y) => {
    let least = Infinity, most = 0;
    for (let j = Math.max(y - 1, 0); j <= Math.min(y + 1, height - 1); ++j)
      for (let i = Math.max(x - 1, 0); i <= Math.min(x + 1, width - 1); ++i) {
        least = Math.min(least, brightness[j * width + i]);
        most = Math.max(most, brightness[j * width + i]);
      }
    return [least, most];
  };
  const isBright = Uint8Array.from(brightness, (b, i) => {
    if (b <= 1) return 0;
    const [least, most] = range(i % width, Math.floor(i / width));
    return least > 1 && least >= EVEN * most;
  });
  if (!brightness.some((b) => b > 1)) return;
  /** Nearest even pixel of the brighter side; -1 if there is none. */
  const evenSide = (x, y) => {
    let most = 0;
    find(x, y, SIDE_OFFSETS, (i) => {
      if (isBright[i]) most = Math.max(most, brightness[i]);
      return false;
    });
    return most > 0 ? find(x, y, SIDE_OFFSETS, (i) => isBright[i] && brightness[i] > 0.5 * most) : -1;
  };
  /** Brightest pixel around a pixel next to a narrow bright line; -1 if there is no such line. */
  const narrowLamp = (x, y) => {
    let brightest = y * width + x, near = 0, low = Infinity; // near: maximum within the reach of an edge
    for (const [dx, dy] of SIDE_OFFSETS) {
      const i = x + dx, j = y + dy;
      if (i < 0 || j < 0 || i >= width || j >= height) continue;
      const b = brightness[j * width + i];
      if (dx * dx + dy * dy <= EDGE_REACH2) near = Math.max(near, b);
      else if (near <= 0.5) return -1;
      low = Math.min(low, b);
      if (b > brightness[brightest]) brightest = j * width + i;
    }
    const top = brightness[brightest];
    if (top <= 1 || near < 0.5 * top || low >= 0.5 * top) return -1;
    let sum = 0, sx = 0, sy = 0, xx = 0, xy = 0, yy = 0;
    for (const [dx, dy] of SIDE_OFFSETS) {
      const i = x + dx, j = y + dy;
      if (i < 0 || j < 0 || i >= width || j >= height) continue;
      const w = (brightness[j * width + i] - low) / (top - low);
      sum += w, sx += w * dx, sy += w * dy;
      xx += w * dx * dx, xy += w * dx * dy, yy += w * dy * dy;
    }
    const a = xx / sum - (sx / sum) ** 2, b = xy / sum - sx * sy / sum ** 2, c = yy / sum - (sy / sum) ** 2;
    const root = Math.hypot((a - c) / 2, b), along = (a + c) / 2 + root, across = (a + c) / 2 - root;
    return sum >= 4 && across <= 1.5 && along >= 2 * across ? brightest : -1;
  };
  const most = (values, i) => Math.max(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  /** Pixel as bright as `dark` would be in the glare at `here`; without glare `dark` itself. */
  const withGlareOf = (here, dark) => {
    if (light === glaring) return dark;
    const limit = Math.max(...[0, 1, 2].map((c) => glaring[3 * here + c] - (light[3 * here + c] - light[3 * dark + c])));
    let out = dark;
    find(here % width, Math.floor(here / width), SIDE_OFFSETS, (i) => {
      if (most(glaring, i) > most(glaring, out) && most(glaring, i) <= limit) out = i;
      return false;
    });
    return out;
  };
  const before = shown.slice(), colour = (values, i) => [0, 1, 2].map((c) => values[3 * i + c]);
  const shownAt = (i) => colour(before, i).map((v) => Math.min(v, 1));
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const here = y * width + x;
      if (isBright[here]) continue;
      const narrow = narrowLamp(x, y), bright = narrow >= 0 ? narrow : evenSide(x, y);
      if (bright < 0) continue;
      const top = brightness[bright];
      const isReached = (i, j) => find(i, j, EDGE_OFFSETS, (k) => brightness[k] > 0.5 * top) >= 0;
      if (!isReached(x, y)) continue;
      const dark = find(x, y, SIDE_OFFSETS, (i) => !isReached(i % width, Math.floor(i / width)));
      if (dark < 0) continue;
      const low = colour(light, dark), contrast = colour(light, bright).map((v, c) => v - low[c]);
      const length2 = contrast.reduce((sum, v) => sum + v * v, 0);
      const covered = Math.min(Math.max(
        colour(light, here).reduce((sum, v, c) => sum + (v - low[c]) * contrast[c], 0) / length2, 0), 1);
      const shownBright = shownAt(bright), shownDark = shownAt(withGlareOf(here, dark)), part = Math.min(top - 1, 1);
      shownAt(here).forEach((v, c) => {
        const mixed = covered * shownBright[c] + (1 - covered) * shownDark[c];
        shown[3 * here + c] = v + part * (Math.min(mixed, v) - v);
      });
    }
}
