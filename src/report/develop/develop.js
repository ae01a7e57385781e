// Page of a developed picture: linear values, with adjustable exposure and tone operator.

const element = (id) => document.getElementById(id);

async function start() {
  const data = JSON.parse(element("data").textContent), { width, height } = data;
  const values = await decodeLayer(data.picture, width * height);
  const direct = data.direct ? await decodeLayer(data.direct, width * height) : values, view = new View(element("view"), width, height);
  let exposure = data.exposure, operator = data.operator;

  function update() {
    paintBy(operator, view.pictures[0], values, width, height, exposure, direct);
    element("exposure").value = exposure;
    element("exposureText").textContent = `${exposure < 0 ? "−" : "+"}${Math.abs(exposure).toFixed(1)}`;
    document.body.dataset.shown = `${operator} ${exposure}`;
    view.draw();
  }
  const setExposure = (stops) => { exposure = Math.min(Math.max(stops, -12), 16); update(); };
  view.onPixel = () => {
    const at = view.pixel;
    element("pixelPlace").textContent = at ? `x ${at[0]}  y ${at[1]}` : "point at a pixel, click to keep it";
    element("pixelShown").textContent = at ? formatRgb(values, at[1] * width + at[0]) : "";
  };
  view.onZoom = (zoom) => { element("zoomText").textContent = `${Math.round(zoom * 100)} %`; };

  element("title").textContent = data.title;
  element("label").textContent = `${width} × ${height}`;
  offerOperators(element("operator"), operator, (name) => { operator = name; update(); });
  const actions = { "+": () => view.zoomBy(2), "=": () => view.zoomBy(2), "-": () => view.zoomBy(0.5),
    f: () => view.fit(), e: () => setExposure(data.exposure), "[": () => setExposure(exposure - 0.5),
    "]": () => setExposure(exposure + 0.5), Escape: () => view.mark(null), ArrowLeft: () => view.step(-1, 0),
    ArrowRight: () => view.step(1, 0), ArrowUp: () => view.step(0, -1), ArrowDown: () => view.step(0, 1) };
  for (const [id, key] of Object.entries({ zoomIn: "+", zoomOut: "-", fit: "f", automatic: "e" }))
    element(id).addEventListener("click", actions[key]);
  element("exposure").addEventListener("input", (event) => setExposure(Number(event.target.value)));
  document.addEventListener("keydown", (event) => {
    if (event.target.matches("input, select") || event.ctrlKey || event.metaKey || !actions[event.key]) return;
    actions[event.key]();
    event.preventDefault();
  });
  update();
  view.fit();
  document.body.dataset.ready = "yes";
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
