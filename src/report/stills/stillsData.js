// Data of the page: one or two sets of layers.

function addUp(layers, pixels) {
  const out = new Float32Array(pixels * 3);
  for (const layer of layers)
    for (let i = 0; i < out.length; ++i) out[i] += layer.values[i];
  return out;
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
