// Data of the page: one or two sets of layers.

/** Sum of layers, each with a factor for red, green and blue; without `factors` these are one. */
function addUp(layers, pixels, factors) {
  const out = new Float32Array(pixels * 3);
  layers.forEach((layer, k) => {
    const [r, g, b] = factors?.[k] ?? [1, 1, 1], values = layer.values;
    for (let i = 0; i < out.length; i += 3) {
      out[i] += r * values[i];
      out[i + 1] += g * values[i + 1];
      out[i + 2] += b * values[i + 2];
    }
  });
  return out;
}

/** Power and colour of a class: a factor of two to the power of `stops`, and the colour of a filter as `#rrggbb`. */
const UNCHANGED = { stops: 0, colour: "#ffffff" };

function factorOf(power) {
  const linear = (byte) => (byte <= 0.04045 ? byte / 12.92 : ((byte + 0.055) / 1.055) ** 2.4);
  return [1, 3, 5].map((at) => 2 ** power.stops * linear(parseInt(power.colour.slice(at, at + 2), 16) / 255));
}

/** Scene file in which the lamps have the powers of the layers; `included` is the file of the scene. */
function relitScene(included, layers, factors) {
  const escapes = { "\n": "\\n", "\r": "\\r", "\t": "\\t", "\b": "\\b", "\f": "\\f" };
  const quoted = (text) => `"${text.replace(/[\\"]/g, "\\$&").replace(/[\n\r\t\x08\f]/g, (c) => escapes[c])}"`;
  const lines = layers.flatMap((layer, k) => (factors[k].every((f) => f === 1) ? []
    : layer.lamps.map((lamp) => `LightScale ${quoted(lamp)} "rgb scale" [ ${factors[k].join(" ")} ]`)));
  return [`# Powers of lamps from the page of stills. Belongs beside the scene file.`, ...lines,
    `Include ${quoted(included)}`, ""].join("\n");
}

/** Loads the sets, decodes `values` of all layers, and splits `layers` into `beauty` and `classes`. */
async function loadData() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const pixels = data.width * data.height;
  for (const set of data.sets) {
    await Promise.all(set.layers.map(async (layer) => {
      if (layer.pixels) layer.values = await decodeLayer(layer, pixels);
      delete layer.pixels;
    }));
    [set.beauty, ...set.classes] = set.layers;
    set.beauty.values ??= addUp(set.classes, pixels);
  }
  return data;
}
