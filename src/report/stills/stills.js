// Page of a render by path class: the shown layer, the classes in the sum, and the numbers.

const element = (id) => document.getElementById(id);
const BEAUTY = "beauty", SUM = "sum"; // layers to show besides the classes, which are numbers
const SAME = "same"; // compared layer: the second set's counterpart of the shown layer

async function start() {
  const data = await loadData(), [set, other] = data.sets;
  const pixels = data.width * data.height;
  const view = new View(element("view"), data.width, data.height);
  const ticked = set.classes.map(() => true);
  const powers = set.classes.map(() => ({ ...UNCHANGED }));
  let shown = set.additive ? SUM : BEAUTY;
  let compared = null; // { set, what }
  let lastCompared = null;
  let exposure = set.beauty.exposure, operator = "none";
  const rows = [];

  /** Class of set `from` with the same name as class `index` of the first set. */
  const counterpart = (from, index) => from === set ? set.classes[index]
    : from.classes.find((layer) => layer.name === set.classes[index].name);

  const sums = new Map(); // sum of each set, until a class is ticked
  function sumOf(from) {
    if (!sums.has(from)) {
      const used = [...ticked.keys()].filter((i) => ticked[i] && counterpart(from, i));
      sums.set(from, addUp(used.map((i) => counterpart(from, i)), pixels, used.map((i) => factorOf(powers[i]))));
    }
    return sums.get(from);
  }
  const resolved = (what) => (what === SAME ? shown : what);
  const valuesOf = (from, what) => what === BEAUTY ? from.beauty.values
    : what === SUM ? sumOf(from) : (counterpart(from, what)?.values ?? null);
  const nameOf = (from, what) => (what === BEAUTY ? "beauty" : what === SUM ? "sum" : set.classes[what].name)
    + (other ? ` · ${from.label}` : "");

  function paintShown() {
    paintBy(operator, view.pictures[0], valuesOf(set, shown), data.width, data.height, exposure);
    const values = compared && valuesOf(compared.set, resolved(compared.what));
    view.pictures[1] = values ? view.pictures[1] ?? document.createElement("canvas") : null;
    if (values) paintBy(operator, view.pictures[1], values, data.width, data.height, exposure);
    element("nameA").textContent = nameOf(set, shown);
    element("nameB").textContent = compared
      ? nameOf(compared.set, resolved(compared.what)) + (values ? "" : " (has no such class)") : "";
    element("nameB").hidden = element("split").hidden = !compared;
    view.draw();
  }

  /** Paints a thumbnail, centred, and scaled with smoothing to fit. */
  function paintThumbnail(row, values, stops) {
    const picture = document.createElement("canvas"), thumbnail = row.querySelector(".thumbnail");
    paint(picture, values, data.width, data.height, stops);
    const context = thumbnail.getContext("2d"), size = thumbnail.width;
    const scale = size / Math.max(data.width, data.height);
    context.clearRect(0, 0, size, size);
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, (size - data.width * scale) / 2, (size - data.height * scale) / 2,
      data.width * scale, data.height * scale);
  }

  function tellPixel() {
    const at = view.pixel, i = at && at[1] * data.width + at[0];
    const value = (values) => (at && values ? formatRgb(values, i) : "");
    element("pixelPlace").textContent = at ? `x ${at[0]}  y ${at[1]}` : "point at a pixel, click to keep it";
    element("pixelShown").textContent = value(valuesOf(set, shown));
    element("pixelCompared").textContent =
      compared ? value(valuesOf(compared.set, resolved(compared.what))) : "";
    element("beautyValue").textContent = value(set.beauty.values);
    element("sumValue").textContent = value(sumOf(set));
    set.classes.forEach((layer, c) => { rows[c].querySelector(".value").textContent = value(layer.values); });
  }

  function update() {
    element("showBeauty").setAttribute("aria-pressed", shown === BEAUTY);
    element("showSum").setAttribute("aria-pressed", shown === SUM);
    rows.forEach((row, c) => {
      row.querySelector("button").setAttribute("aria-pressed", shown === c);
      row.querySelector("input").checked = ticked[c];
      row.classList.toggle("off", !ticked[c]);
      const { stops, colour } = powers[c];
      row.querySelector(".stops").value = stops;
      row.querySelector(".colour").value = colour;
      row.querySelector("output").textContent = `${stops < 0 ? "−" : "+"}${Math.abs(stops).toFixed(1)}`;
      row.classList.toggle("changed", stops !== 0 || colour !== UNCHANGED.colour);
    });
    const scaledShare = (layer, c) => {
      const before = luminance(...layer.mean), f = factorOf(powers[c]);
      return before > 0 ? layer.share * luminance(...layer.mean.map((v, k) => v * f[k])) / before : 0;
    };
    const share = set.classes.reduce((sum, layer, c) => sum + (ticked[c] ? scaledShare(layer, c) : 0), 0);
    element("sumShare").textContent =
      `${ticked.filter(Boolean).length} of ${ticked.length}, ${formatShare(share)}`;
    element("exposure").value = exposure;
    element("exposureText").textContent = `${exposure < 0 ? "−" : "+"}${Math.abs(exposure).toFixed(1)}`;
    paintShown();
    tellPixel();
  }

  const show = (what) => { shown = what; update(); };
  const setExposure = (stops) => { exposure = Math.min(Math.max(stops, -12), 16); update(); };
  function sumChanged() {
    sums.clear();
    shown = SUM; // the sum has changed, so it is shown
    paintThumbnail(element("showSum"), sumOf(set), set.beauty.exposure);
    if (element("keepExposure").checked) update();
    else setExposure(automaticExposure(sumOf(set)));
  }
  function tick(changes) {
    changes.forEach(([c, on]) => { ticked[c] = on; });
    sumChanged();
  }
  function setPowers(changes) {
    changes.forEach(([c, change]) => Object.assign(powers[c], change));
    sumChanged();
  }
  const ownExposure = () => shown === BEAUTY ? set.beauty.exposure
    : shown === SUM ? automaticExposure(sumOf(set)) : set.classes[shown].exposure;

  function compareWith(choice) {
    compared = choice;
    if (choice) lastCompared = choice;
    const options = [...element("compare").options];
    element("compare").selectedIndex =
      options.findIndex((o) => o.choice?.set === choice?.set && o.choice?.what === choice?.what);
    update();
  }

  function listClasses() {
    set.classes.forEach((layer, c) => {
      const row = document.createElement("li");
      row.innerHTML = `<input type="checkbox" checked><button type="button" class="row">
        <canvas class="thumbnail" width="56" height="56"></canvas><span class="text"><b></b>
        <span class="share"></span><code></code><span class="value"></span></span></button>
        <span class="power"><input type="range" class="stops" min="-6" max="6" step="0.1" value="0">
        <output></output><input type="color" class="colour" value="#ffffff"></span>`;
      const find = (selector) => row.querySelector(selector);
      find("b").textContent = layer.name;
      find("code").textContent = find("code").title = layer.expression;
      find(".share").textContent = formatShare(layer.share);
      find(".share").title = `mean ${layer.mean.map(formatValue).join("  ")}`;
      find("input").setAttribute("aria-label", `${layer.name} in the sum`);
      find("input").addEventListener("change", (event) => tick([[c, event.target.checked]]));
      find("button").addEventListener("click", () => show(c));
      find(".stops").setAttribute("aria-label", `power of ${layer.name} in stops`);
      find(".colour").setAttribute("aria-label", `colour of ${layer.name}`);
      find(".stops").addEventListener("input", (event) => setPowers([[c, { stops: Number(event.target.value) }]]));
      find(".colour").addEventListener("input", (event) => setPowers([[c, { colour: event.target.value }]]));
      element("classes").append(row);
      rows.push(row);
      paintThumbnail(row, layer.values, layer.exposure);
    });
    paintThumbnail(element("showBeauty"), set.beauty.values, set.beauty.exposure);
    paintThumbnail(element("showSum"), sumOf(set), set.beauty.exposure);
  }

  function listComparisons() {
    const select = element("compare");
    select.append(new Option("nothing"));
    for (const from of data.sets) {
      const group = document.createElement("optgroup");
      group.label = from.label || from.title;
      const add = (what, name) => {
        const option = new Option(name);
        option.choice = { set: from, what };
        group.append(option);
      };
      if (from !== set) add(SAME, "what is shown");
      add(BEAUTY, "beauty");
      add(SUM, "sum of the ticked classes");
      set.classes.forEach((layer, c) => { if (counterpart(from, c)) add(c, layer.name); });
      select.append(group);
    }
    select.addEventListener("change", () => compareWith(select.selectedOptions[0].choice ?? null));
  }

  function save(name, blob) {
    const link = document.createElement("a");
    link.download = name;
    link.href = URL.createObjectURL(blob);
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
  const savedName = (ending) => `${set.title.replace(/\.[^.]*$/, "")}-relit.${ending}`;
  const sceneText = () =>
    relitScene(set.scene, set.classes, powers.map((power, c) => (ticked[c] ? factorOf(power) : [0, 0, 0])));
  const isByLight = Boolean(set.scene) && set.classes.every((layer) => layer.lamps);

  const toggleCompare = () => compareWith(compared ? null
    : lastCompared ?? { set: other ?? set, what: other ? SAME : BEAUTY });

  function onKey(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, summary")) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (arrows && event.target === view.canvas) {
      if (event.shiftKey) view.pan(-40 * arrows[0], -40 * arrows[1]);
      else view.step(...arrows);
      event.preventDefault();
      return;
    }
    const digit = /^Digit([1-9])$/.exec(event.code)?.[1] - 1;
    if (digit < set.classes.length) {
      if (event.shiftKey) tick([[digit, !ticked[digit]]]);
      else show(digit);
      return;
    }
    const actions = {
      0: () => show(BEAUTY), s: () => show(SUM), e: () => setExposure(set.beauty.exposure),
      o: () => setExposure(ownExposure()), "[": () => setExposure(exposure - 0.5),
      "]": () => setExposure(exposure + 0.5), "+": () => view.zoomBy(2), "=": () => view.zoomBy(2),
      "-": () => view.zoomBy(0.5), f: () => view.fit(), c: toggleCompare, Escape: () => view.mark(null),
      ",": () => view.setSplit(view.split - 0.02), ".": () => view.setSplit(view.split + 0.02),
    };
    actions[event.key]?.();
  }

  element("title").textContent = set.title;
  element("label").textContent = [`${data.width} × ${data.height}`, set.label].filter(Boolean).join(", ");
  for (const remark of [...set.remarks, ...(other?.remarks ?? []).map((r) => `${other.label}: ${r}`)]) {
    const item = document.createElement("li");
    item.textContent = remark;
    element("remarks").append(item);
  }
  element("settings").textContent = data.sets.map((s) => s.settings).filter(Boolean).join("\n");
  listClasses();
  listComparisons();
  if (other) compareWith({ set: other, what: SAME });
  const click = (id, action) => element(id).addEventListener("click", action);
  click("showBeauty", () => show(BEAUTY));
  click("showSum", () => show(SUM));
  click("tickAll", () => tick(ticked.map((_, c) => [c, true])));
  click("tickNone", () => tick(ticked.map((_, c) => [c, false])));
  click("resetPowers", () => setPowers(powers.map((_, c) => [c, UNCHANGED])));
  click("savePng", () => view.pictures[0].toBlob((blob) => save(savedName("png"), blob)));
  click("saveScene", () => save(savedName("pbrt"), new Blob([sceneText()], { type: "text/plain" })));
  element("saveScene").hidden = !isByLight;
  element("keepExposure").addEventListener("change", sumChanged);
  click("commonExposure", () => setExposure(set.beauty.exposure));
  click("ownExposure", () => setExposure(ownExposure()));
  click("zoomIn", () => view.zoomBy(2));
  click("zoomOut", () => view.zoomBy(0.5));
  click("fit", () => view.fit());
  element("exposure").addEventListener("input", (event) => setExposure(Number(event.target.value)));
  offerOperators(element("operator"), operator, (name) => { operator = name; update(); });
  element("split").addEventListener("input", (event) => view.setSplit(event.target.value / 1000));
  view.onSplit = (split) => { element("split").value = split * 1000; };
  view.onZoom = (zoom) => { element("zoomText").textContent = `${Math.round(zoom * 100)} %`; };
  view.onPixel = tellPixel;
  document.addEventListener("keydown", onKey);
  update();
  view.fit();
  document.body.dataset.ready = "yes";
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
