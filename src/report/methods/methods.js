// Page of all methods side by side: a card for each, and a table of the light by path class.

const element = (id) => document.getElementById(id);

async function start() {
  const data = JSON.parse(element("data").textContent), pixels = data.width * data.height;
  await Promise.all(data.pictures.map(async (picture) => {
    if (picture.pixels) picture.values = await decodeLayer({ ...picture, name: picture.name ?? "reference" }, pixels);
    delete picture.pixels;
  }));
  element("title").textContent = data.title;
  element("label").textContent = data.label;
  element("coarse").hidden = data.exact;
  const cards = [addCard("reference", "all", data.reference),
    ...data.methods.map((method) => addCard(method.name, method.claims, captionOf(method), method))];
  fillClasses(data);
  fillSettings(data);
  let exposure = data.exposure;
  const update = () => {
    cards.forEach((canvas, i) => draw(canvas, data, i, exposure));
    element("exposure").value = exposure;
    element("exposureText").textContent = `${exposure < 0 ? "−" : "+"}${Math.abs(exposure).toFixed(1)}`;
  };
  element("show").addEventListener("input", update);
  element("exposure").addEventListener("input", (event) => { exposure = Number(event.target.value); update(); });
  update();
  document.body.dataset.ready = "yes";
}

function formatShort(x) {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6 ? x.toExponential(2) : String(Number(x.toPrecision(3)));
}

function captionOf(method) {
  if (method.failure) return `no picture: ${method.failure}`;
  return `${formatShort(method.seconds)} s, ${formatShort(method.samples_per_pixel)} samples per pixel; ` +
    `error ${formatShort(method.relmse_noise_free)}, on its own paths ${formatShort(method.own_relmse_noise_free)} ` +
    `(mean ${formatShort(method.own_mean_ratio)}); leaves out ${formatShort(100 * method.missing)} % of the light`;
}

/** Adds a card. Returns its canvas. */
function addCard(name, expression, caption, method) {
  const figure = document.createElement("figure"), canvas = document.createElement("canvas");
  const words = document.createElement("figcaption");
  const add = (tag, text, className = "") => {
    const part = document.createElement(tag);
    part.textContent = text;
    part.className = className;
    words.append(part);
  };
  add("b", name);
  add("code", expression);
  add("small", caption, method?.failure ? "bad" : "");
  if (method?.suppositions) add("small", `assumes ${method.suppositions}`);
  if (method?.non_finite > 0) add("small", `${method.non_finite} pixels are not finite`, "bad");
  figure.append(canvas, words);
  element("cards").append(figure);
  return canvas;
}

function draw(canvas, data, i, exposure) {
  const values = data.pictures[i].values, reference = data.pictures[0].values, show = element("show").value;
  if (!values) { canvas.width = data.width; canvas.height = data.height; return; }
  const sign = show === "missing" ? 1 : -1;
  const shown = show === "picture" ? values : values.map((x, k) => Math.max(0, sign * (reference[k] - x)));
  paint(canvas, shown, data.width, data.height, exposure);
}

function row(table, cells, tag = "td") {
  const tr = table.insertRow();
  for (const content of cells) {
    const cell = document.createElement(tag);
    cell.append(content);
    tr.append(cell);
  }
  return tr;
}

function fillClasses(data) {
  const table = element("classes"), shown = data.methods.filter((method) => !method.failure);
  row(table, ["class", "reference", ...shown.map((method) => method.name)], "th");
  const light = data.classes.reduce((sum, c) => sum + c.mean, 0);
  data.classes.forEach((c, i) => {
    const name = document.createElement("span"), code = document.createElement("code");
    code.textContent = c.expression.length > 60 ? `${c.expression.slice(0, 58)}…` : c.expression;
    code.title = c.expression;
    name.append(c.name, code);
    const percent = (x) => (100 * x / light).toFixed(2);
    const tr = row(table, [name, percent(c.mean),
      ...shown.map((method) => method.class_is_claimed[i] ? percent(method.class_means[i]) : "–")]);
    shown.forEach((method, k) => {
      const away = (method.class_means[i] - c.mean) / light;
      if (method.class_is_claimed[i] && Math.abs(away) > 0.005) tr.cells[k + 2].className = away < 0 ? "less" : "more";
    });
  });
}

function fillSettings(data) {
  for (const method of data.methods) {
    const dt = document.createElement("dt"), dd = document.createElement("dd");
    dt.textContent = method.name;
    dd.textContent = method.settings;
    element("settings").append(dt, dd);
  }
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
