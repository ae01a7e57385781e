// Page of the diagnosis: statements, a map of the regions over the picture, and a table of the classes.

const element = (id) => document.getElementById(id);
const STATES = {
  right: "#5ac88a", missing: "#6fb6ff", doubled: "#ff7a6b", scaled: "#f0b45a", unknown: "#8a8f99",
};

async function start() {
  const data = JSON.parse(element("data").textContent), pixels = data.width * data.height;
  await Promise.all(data.pictures.map(async (picture) => {
    picture.values = await decodeLayer(picture, pixels);
    delete picture.pixels;
  }));
  const page = { data, exposure: data.exposure_of_display, chosen: firstWrong(data) };
  element("title").textContent = data.title;
  element("label").textContent = data.label;
  fillStatements(page);
  fillClasses(page);
  fillLegend();
  listen(page);
  update(page);
  document.body.dataset.ready = "yes";
}

/** Initial class: the class of the first statement that has one, else the brightest. */
function firstWrong(data) {
  const shown = data.statements.find((s) => s.class >= 0);
  if (shown) return shown.class;
  return data.classes.reduce((best, c, i) => (c.share > data.classes[best].share ? i : best), 0);
}

/** Text of a factor, without the sign of a rounded zero. */
const formatFactor = (factor) => (Math.round(factor * 100) / 100 + 0).toFixed(2);
const sure = (certainty) =>
  certainty > 0.999 ? "more than 99.9 % sure" : `${Number((100 * certainty).toFixed(1))} % sure`;

function part(tag, text, className = "") {
  const out = document.createElement(tag);
  out.textContent = text;
  out.className = className;
  return out;
}

function fillStatements(page) {
  const { data } = page;
  element("verdict").textContent = data.statements.length === 0
    ? "No errors were found in this picture."
    : `${data.statements.length} ${data.statements.length === 1 ? "error was" : "errors were"} found`;
  for (const statement of data.statements) {
    const item = document.createElement("li");
    item.append(part("b", statement.what), part("span", sure(statement.certainty), "sure"));
    if (statement.class >= 0) {
      const button = part("button", "where");
      button.type = "button";
      button.addEventListener("click", () => choose(page, statement.class));
      item.append(button);
    }
    item.append(part("small", statement.advice));
    element("statements").append(item);
  }
  for (const remark of data.remarks) element("remarks").append(part("li", remark));
}

function fillClasses(page) {
  const table = element("classes"), { classes } = page.data, percent = (x) => `${(100 * x).toFixed(1)} %`;
  const head = table.createTHead().insertRow(), body = table.createTBody();
  for (const title of ["class", "share", "state", "sure", "factor", "±", "shown in", "of these in this state"])
    head.append(part("th", title));
  classes.forEach((c, i) => {
    element("map").append(new Option(c.name, i));
    const row = body.insertRow(), isKnown = c.state !== "unknown";
    const name = row.insertCell();
    name.append(c.name, part("code", c.expression.length > 40 ? `${c.expression.slice(0, 38)}…` : c.expression));
    row.insertCell().textContent = percent(c.share);
    const cells = [c.state, isKnown ? percent(c.certainty) : "–", isKnown ? formatFactor(c.factor) : "–",
      isKnown ? c.standard_error.toFixed(3) : "–", percent(c.told_in), c.told_in > 0 ? percent(c.state_in) : "–"];
    cells.forEach((text, k) => {
      const cell = row.insertCell();
      cell.textContent = text;
      if (k === 0) cell.style.color = STATES[c.state];
    });
    row.addEventListener("click", () => choose(page, i));
  });
}

function fillLegend() {
  for (const [state, colour] of Object.entries(STATES)) {
    const item = document.createElement("li"), box = document.createElement("i");
    box.style.borderColor = colour;
    box.style.background = state === "unknown" ? "none" : `${colour}66`;
    item.append(box, state);
    element("legend").append(item);
  }
}

function choose(page, i) {
  page.chosen = i;
  update(page);
}

function shownValues(page) {
  const [picture, reference, ...classes] = page.data.pictures.map((p) => p.values), show = element("show").value;
  if (show === "reference") return reference;
  if (show === "class") return classes[page.chosen];
  if (show === "picture") return picture;
  const sign = show === "less" ? 1 : -1;
  return picture.map((x, k) => Math.max(0, sign * (reference[k] - x)));
}

function update(page) {
  const { data } = page;
  paint(element("view"), shownValues(page), data.width, data.height, page.exposure);
  element("map").value = page.chosen;
  element("exposure").value = page.exposure;
  element("exposureText").textContent = `${page.exposure < 0 ? "−" : "+"}${Math.abs(page.exposure).toFixed(1)}`;
  [...element("classes").tBodies[0].rows].forEach((row, i) => { row.className = i === page.chosen ? "chosen" : ""; });
  drawRegions(page);
}

/** Draws the regions at a higher resolution than the picture's, for thin lines. */
function drawRegions(page) {
  const { data } = page, canvas = element("regions"), zoom = Math.max(1, Math.ceil(960 / data.width));
  canvas.width = data.width * zoom;
  canvas.height = data.height * zoom;
  const context = canvas.getContext("2d");
  for (const region of data.regions) {
    const { state } = region.classes[page.chosen], place = [region.x, region.y, region.width, region.height];
    const [x, y, width, height] = place.map((v) => v * zoom);
    context.strokeStyle = STATES[state];
    context.globalAlpha = state === "unknown" ? 0.35 : 0.9;
    context.lineWidth = 2;
    context.strokeRect(x + 1.5, y + 1.5, width - 3, height - 3);
    if (state === "unknown" || state === "right") continue;
    context.fillStyle = STATES[state];
    context.globalAlpha = 0.3;
    context.fillRect(x + 1.5, y + 1.5, width - 3, height - 3);
  }
}

function describeRegion(page, x, y) {
  const region = page.data.regions.find((r) => x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height);
  if (!region) return;
  const known = region.classes.map((c, i) => ({ ...c, name: page.data.classes[i].name }))
    .filter((c) => c.state !== "unknown")
    .map((c) => `${c.name} ${c.state} (${formatFactor(c.factor)} ± ${c.standard_error.toFixed(2)})`);
  const other = region.unexplained > 0 ? `; ${(100 * region.unexplained).toFixed(0)} % differ for other reasons` : "";
  element("region").textContent =
    `Region at ${region.x}, ${region.y}: ${known.length > 0 ? known.join(", ") : "no class can be judged"}${other}.`;
}

function listen(page) {
  element("show").addEventListener("change", () => update(page));
  element("map").addEventListener("change", (event) => choose(page, Number(event.target.value)));
  element("exposure").addEventListener("input", (event) => {
    page.exposure = Number(event.target.value);
    update(page);
  });
  element("regions").addEventListener("pointermove", (event) => {
    const area = element("regions").getBoundingClientRect();
    describeRegion(page, (event.clientX - area.left) / area.width * page.data.width,
      (event.clientY - area.top) / area.height * page.data.height);
  });
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
