// Page of error against time: plot, tables, and comparison of pictures.

const element = (id) => document.getElementById(id);
const COLOURS = ["#f0b45a", "#5ab0f0", "#7ed07e", "#e07ab8", "#c9a0ff", "#f0806a", "#5fd4c8", "#d0d06a"];
const GREY = "#8a92a1";
const colourOf = (i) => COLOURS[i % COLOURS.length];
const REFERENCE = "reference";

async function start() {
  const data = JSON.parse(element("data").textContent);
  const pixels = data.width * data.height;
  await Promise.all(data.pictures.map(async (picture) => {
    picture.values = await decodeLayer({ ...picture, name: picture.run }, pixels);
    delete picture.pixels;
  }));
  const reference = data.pictures[0].values;

  element("title").textContent = data.title;
  element("label").textContent = data.label;
  drawPlot(data);
  fillMeasurements(data);
  fillSettings(data);
  startPictures(data, reference);
  document.body.dataset.ready = "yes";
}

/** Label of an axis tick: at powers of ten, and at 2 and 5 if the axis has few decades. */
function tickText(value, decades) {
  const digit = Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9));
  return digit === 1 || (decades < 2.5 && (digit === 2 || digit === 5)) ? Number(value.toPrecision(3)) : "";
}

function drawPlot(data) {
  const axis = (title) => ({
    type: "logarithmic",
    title: { display: true, text: title, color: "#e6e8ec" },
    grid: { color: "#343943" },
    ticks: {
      color: GREY, autoSkip: false, maxRotation: 0,
      callback(value) { return tickText(value, Math.log10(this.max / this.min)); },
    },
  });
  const points = (curve) => curve.filter(([, e]) => e > 0).map(([x, y]) => ({ x, y }));
  const chart = new Chart(element("plot"), {
    type: "scatter",
    data: { datasets: [] },
    options: {
      animation: false, maintainAspectRatio: false, responsive: true,
      scales: { x: axis("seconds"), y: axis("") },
      interaction: { mode: "nearest", intersect: false },
      plugins: {
        legend: { position: "bottom", labels: { color: "#e6e8ec", usePointStyle: true,
          filter: (item) => item.text !== "" } },
        tooltip: { filter: (item) => item.dataset.label !== "", callbacks: {
          label: (item) => `${item.dataset.label}: ${formatValue(item.parsed.y)} at ${formatValue(item.parsed.x)} s` } },
      },
    },
  });
  const select = element("measure");
  data.measures.forEach((measure, i) => select.append(new Option(measure.title, i)));

  function show(measure) {
    const seeds = (run) => data.cells.filter((cell) => cell.run === run && cell[measure.key] > 0)
      .map((cell) => ({ x: cell.seconds, y: cell[measure.key] }));
    const datasets = [];
    measure.runs.forEach((run, i) => {
      const colour = colourOf(i), name = data.runs[i].name;
      datasets.push({ label: `${name}  ${run.fit_text}`, data: points(run.curve), showLine: true,
        borderColor: colour, backgroundColor: colour, borderWidth: 2, pointRadius: 4, order: 1 });
      datasets.push({ label: "", data: seeds(name), backgroundColor: `${colour}80`, pointRadius: 2, order: 2,
        borderWidth: 0 });
    });
    measure.slopes.forEach((slope, i) => datasets.push({ label: `∝ ${slope.label}`, data: points(slope.line),
      showLine: true, pointStyle: "line", borderColor: GREY, backgroundColor: GREY, borderWidth: 1.5, pointRadius: 0,
      pointHitRadius: 0, borderDash: i === 0 ? [7, 5] : [2, 4], order: 3 }));
    chart.data.datasets = datasets;
    chart.options.scales.y.title.text = measure.title;
    chart.update();
    element("definition").textContent = measure.definition;
    element("slopes").textContent = measure.slopes.map((s) => `${s.label}: ${s.why}.`).join(" ");
    const missing = measure.runs.flatMap((run) => run.curve).filter(([, e]) => !(e > 0)).length;
    element("missing").textContent = missing === 0 ? ""
      : `${missing} ${missing === 1 ? "point is" : "points are"} not above zero and cannot be drawn.`;
    fillReach(data, measure);
  }
  select.addEventListener("change", () => show(data.measures[select.value]));
  show(data.measures[0]);
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

function named(data, i) {
  const text = document.createElement("span"), key = document.createElement("span");
  key.className = "key";
  key.style.background = colourOf(i);
  text.append(key, data.runs[i].name);
  return text;
}

function fillReach(data, measure) {
  const table = element("reach");
  table.replaceChildren();
  row(table, [measure.title, ...measure.targets.map((t) => String(Number(t.toPrecision(1)))), "error ∝"], "th");
  measure.runs.forEach((run, i) => row(table, [named(data, i), ...run.reach, run.fit_text]));
}

function fillMeasurements(data) {
  const table = element("all"), errors = data.measures.filter((m) => !/variance|bias/.test(m.key));
  row(table, ["run", "budget", "seeds", "seconds", "samples/pixel", "photons", ...errors.map((m) => m.title),
    "mean ratio", "variance", "bias²"], "th");
  const interval = (values) => {
    const text = document.createElement("span");
    if (!values) return "needs two seeds";
    const small = document.createElement("small");
    small.textContent = ` ${formatShort(values[1])} … ${formatShort(values[2])}`;
    text.append(formatShort(values[0]), small);
    return text;
  };
  for (const p of data.points) {
    const tr = row(table, [named(data, data.runs.findIndex((run) => run.name === p.run)), p.budget, p.seeds,
      formatShort(p.seconds), formatShort(p.samples_per_pixel), p.photons > 0 ? formatShort(p.photons) : "–",
      ...errors.map((m) => formatShort(p[m.key])), p.mean_ratio === null ? "–" : p.mean_ratio.toFixed(4),
      interval(p.variance_interval), interval(p.bias2_interval)]);
    if (p.non_finite > 0) {
      tr.cells[0].append(` (${p.non_finite} pixels not finite)`);
      tr.cells[0].className = "bad";
    }
  }
  if (!data.independent)
    element("ownNoise").textContent = "There is only one reference: all errors and bias² include its noise.";
}

function formatShort(x) {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6 ? x.toExponential(2) : String(Number(x.toPrecision(4)));
}

function fillSettings(data) {
  const list = element("settings");
  const add = (name, text) => {
    const dt = document.createElement("dt"), dd = document.createElement("dd");
    dt.textContent = name;
    dd.textContent = text;
    list.append(dt, dd);
  };
  add("measured against", data.reference);
  for (const [name, value] of data.identity) add(name, value);
  for (const run of data.runs) add(`run ${run.name}`, run.settings);
}

function startPictures(data, reference) {
  const view = new View(element("view"), data.width, data.height);
  view.pictures = [document.createElement("canvas"), document.createElement("canvas")];
  const names = [...data.runs.map((run) => run.name), REFERENCE];
  let exposure = data.exposure, operator = "none";
  for (const id of ["left", "right"]) {
    for (const name of names) element(id).append(new Option(name));
    element(id).addEventListener("change", update);
  }
  element("right").selectedIndex = Math.min(1, names.length - 1);
  element("budget").max = data.budgets.length - 1;
  element("budget").value = data.budgets.length - 1;
  element("epsilon").textContent = data.map_epsilon;

  const budget = () => data.budgets[element("budget").value];
  /** Picture selected by the control `id`; null if it was not rendered. */
  const pictureOf = (id) => {
    const name = element(id).value;
    return data.pictures.find((p) => p.run === name && (name === REFERENCE || p.budget === budget())) ?? null;
  };
  const nameOf = (id, picture) => element(id).value === REFERENCE ? REFERENCE : picture
    ? `${picture.run}, ${formatShort(picture.seconds)} s${errorText(picture)}`
    : `${element(id).value}: not rendered at ${budget()}`;
  function errorText(picture) {
    const point = data.points.find((p) => p.run === picture.run && p.budget === picture.budget);
    return `, ${data.measures[0].title} ${formatShort(point[data.measures[0].key])}`;
  }

  function paintError(canvas, values) {
    canvas.width = data.width;
    canvas.height = data.height;
    const context = canvas.getContext("2d"), image = context.createImageData(data.width, data.height);
    for (let i = 0, p = 0; i < values.length; i += 3, p += 4) {
      let error = 0;
      for (let c = 0; c < 3; ++c)
        error += Math.abs(values[i + c] - reference[i + c]) / (Math.abs(reference[i + c]) + data.map_epsilon) / 3;
      const t = 1 + Math.log10(Math.max(error, 1e-6)) / 3;
      const colour = Number.isFinite(error)
        ? data.colours[Math.round(255 * Math.min(Math.max(t, 0), 1))] : [255, 0, 255];
      image.data.set([...colour, 255], p);
    }
    context.putImageData(image, 0, 0);
  }

  function update() {
    const error = element("show").value === "error";
    ["left", "right"].forEach((id, side) => {
      const picture = pictureOf(id), canvas = view.pictures[side];
      if (!picture) { canvas.width = canvas.height = 1; }
      else if (error) paintError(canvas, picture.values);
      else paintBy(operator, canvas, picture.values, data.width, data.height, exposure);
      element(side === 0 ? "nameA" : "nameB").textContent = nameOf(id, picture);
    });
    element("budgetText").textContent = budget();
    element("exposure").value = exposure;
    element("exposureText").textContent = `${exposure < 0 ? "−" : "+"}${Math.abs(exposure).toFixed(1)}`;
    element("exposure").disabled = element("operator").disabled = error;
    element("scale").hidden = !error;
    tellPixel();
    view.draw();
  }

  function tellPixel() {
    const at = view.pixel, i = at && at[1] * data.width + at[0];
    element("pixelPlace").textContent = at ? `x ${at[0]}  y ${at[1]}` : "point at a pixel, click to keep it";
    const tell = (id, picture, name) => {
      element(id).textContent = at && picture ? `${name} ${formatRgb(picture.values, i)}` : "";
    };
    tell("pixelA", pictureOf("left"), element("left").value);
    tell("pixelB", pictureOf("right"), element("right").value);
    tell("pixelR", data.pictures[0], "r");
  }

  const context = element("colours").getContext("2d"), bar = context.createImageData(256, 1);
  data.colours.forEach((colour, i) => bar.data.set([...colour, 255], 4 * i));
  context.putImageData(bar, 0, 0);

  for (const id of ["budget", "show"]) element(id).addEventListener("input", update);
  element("exposure").addEventListener("input", (event) => { exposure = Number(event.target.value); update(); });
  offerOperators(element("operator"), operator, (name) => { operator = name; update(); });
  element("split").addEventListener("input", (event) => view.setSplit(event.target.value / 1000));
  element("zoomIn").addEventListener("click", () => view.zoomBy(2));
  element("zoomOut").addEventListener("click", () => view.zoomBy(0.5));
  element("fit").addEventListener("click", () => view.fit());
  view.onSplit = (split) => { element("split").value = split * 1000; };
  view.onZoom = (zoom) => { element("zoomText").textContent = `${Math.round(zoom * 100)} %`; };
  view.onPixel = tellPixel;
  element("view").addEventListener("keydown", (event) => {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (arrows) view.step(...arrows);
    const actions = { "+": () => view.zoomBy(2), "-": () => view.zoomBy(0.5), f: () => view.fit(),
      Escape: () => view.mark(null) };
    actions[event.key]?.();
    if (arrows || actions[event.key]) event.preventDefault();
  });
  update();
  view.fit();
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
