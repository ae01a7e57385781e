// Page of a running render: requests the program's state, and the picture when there is a newer one.

const $ = (id) => document.getElementById(id);
const page = JSON.parse($("data").textContent);
const POLL_SECONDS = 0.5;

const live = {
  view: null,
  size: "", // size of the picture in the view
  version: 0, // version of the picture in the view
  state: null,
  errors: [], // [seconds, relative error]
  asked: "", // query of the last request for the picture
  ended: false,
  question: null, // { number, pixel } of the latest question about a pixel
  asking: "", // pixel of that question
};

const exposure = () => {
  const stops = Number($("exposure").value);
  return stops === 0 ? "auto" : `auto${stops > 0 ? "+" : "-"}${Math.abs(stops).toFixed(1)}`;
};

function fail(text) {
  $("failure").textContent = text;
  $("failure").hidden = !text;
}

function duration(seconds) {
  if (seconds === null) return "–";
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds), two = (x) => String(x).padStart(2, "0");
  return whole < 3600 ? `${Math.floor(whole / 60)}:${two(whole % 60)} min`
    : `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)} h`;
}

/** Fetches the newest picture with the settings of the controls; repeats if they change meanwhile. */
async function fetchPicture() {
  if (live.fetching || !live.state || live.state.version === 0) return;
  live.fetching = true;
  try {
    for (let wanted = null; wanted !== live.asked || live.version < live.state.version;) {
      wanted = live.asked = new URLSearchParams({ exposure: exposure(), tonemap: $("operator").value }).toString();
      const answer = await fetch(`shown?${wanted}`);
      if (!answer.ok) throw new Error(await answer.text());
      const bytes = new Uint8Array(await answer.arrayBuffer());
      live.version = Number(answer.headers.get("Picture-Version"));
      showPicture(bytes, answer.headers.get("Picture-Size"));
      const stops = Number(answer.headers.get("Picture-Stops"));
      $("exposureText").textContent = `${stops >= 0 ? "+" : ""}${stops.toFixed(1)}`;
      live.asked = new URLSearchParams({ exposure: exposure(), tonemap: $("operator").value }).toString();
    }
    fetchPixel();
  } finally {
    live.fetching = false;
  }
}

function showPicture(bytes, size) {
  const [width, height] = size.split("x").map(Number);
  if (live.size !== size) {
    live.view = new View($("view"), width, height);
    live.view.onPixel = () => {
      fetchPixel();
      askPaths();
    };
    live.view.onZoom = (zoom) => { $("zoomText").textContent = `${(100 * zoom).toFixed(0)} %`; };
    live.size = size;
  }
  const canvas = live.view.pictures[0];
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d"), image = context.createImageData(width, height);
  for (let i = 0, p = 0; i < bytes.length; p += 4) {
    for (let c = 0; c < 3; ++c) image.data[p + c] = bytes[i++];
    image.data[p + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  document.body.dataset.version = live.version;
  document.body.dataset.shown = live.asked;
  live.view.fitted ? live.view.fit() : live.view.draw();
}

/** Fetches the linear values of the hovered or marked pixel. */
async function fetchPixel() {
  const pixel = live.view?.pixel;
  $("pixelPlace").textContent = pixel ? `${pixel[0]}, ${pixel[1]}` : "no pixel";
  if (!pixel || live.ended) {
    $("pixelShown").textContent = "";
    return;
  }
  try {
    const values = await (await fetch(`pixel?x=${pixel[0]}&y=${pixel[1]}`)).json();
    if (live.view.pixel?.join() === pixel.join())
      $("pixelShown").textContent = formatRgb(values.map((v) => v ?? NaN), 0);
  } catch { /* the next poll detects the end of the render */ }
}

/** Asks for the paths of the marked pixel, once. The program answers between two rounds of samples. */
async function askPaths() {
  const pixel = live.view?.marked;
  if (!pixel || live.ended || !live.state?.answers_pixels || live.asking === pixel.join()) return;
  live.asking = pixel.join();
  const answer = await fetch(`ask?x=${pixel[0]}&y=${pixel[1]}`, { method: "POST" }).catch(() => null);
  if (!answer?.ok) {
    if (live.asking === pixel.join()) live.asking = ""; // a click asks again
    $("paths").hidden = false;
    $("pathsStatus").textContent = `Pixel ${pixel.join(", ")}: ${answer ? await answer.text() : "the program does not answer"}`;
    return;
  }
  live.question = { number: (await answer.json()).question, pixel };
  $("paths").hidden = false;
  $("pathsStatus").textContent = `Pixel ${pixel.join(", ")}: waiting for the end of the round`;
}

/** Gives up the latest question; a click asks again. */
function dropQuestion(text) {
  if (!live.question || live.question.isShown) return;
  $("pathsStatus").textContent = `Pixel ${live.question.pixel.join(", ")}: ${text}`;
  Object.assign(live, { question: null, asking: "" });
}

/** Shows the paths once the program has answered the latest question. */
function showPaths() {
  const { question, state } = live;
  if (!question || question.isShown) return;
  const isReplaced = state.question > question.number;
  if (isReplaced || (state.finished && !state.answered)) {
    dropQuestion(isReplaced ? "another question has replaced this one; click again" : "the render has finished without an answer");
    return;
  }
  if (state.question !== question.number || !state.answered) return;
  question.isShown = true;
  $("pathsStatus").textContent = `Paths of pixel ${question.pixel.join(", ")}`;
  $("pathsPage").src = $("pathsAlone").href = `paths?question=${question.number}`;
  $("pathsAlone").hidden = false;
  document.body.dataset.answered = question.number;
}

function closePaths() {
  Object.assign(live, { question: null, asking: "" });
  $("paths").hidden = true;
  $("pathsPage").removeAttribute("src");
}

function showState() {
  const s = live.state, none = (value, text) => (value === null ? "–" : text(value));
  $("phase").textContent = s.finished ? "finished" : s.stopped ? "stopping" : s.phase || "–";
  $("fraction").value = s.fraction;
  $("elapsed").textContent = duration(s.elapsed);
  $("left").textContent = s.finished ? "0 s" : duration(s.seconds_left);
  $("samples").textContent = s.samples_per_pixel.toPrecision(3);
  $("rays").textContent = `${(s.rays_per_second / 1e6).toFixed(2)} M/s`;
  $("learning").textContent = duration(s.learning_seconds);
  $("guide").textContent = none(s.guide, (g) => `${g.cells} cells, ${(100 * g.fraction_on).toFixed(0)} % sampled`);
  $("error").textContent = none(s.error, (e) => e.toPrecision(3));
  $("label").textContent = s.width ? `${s.width}x${s.height} pixels` : "waiting for the first samples";
  $("stop").disabled = s.stopped || s.finished;
  $("pathsHelp").hidden = !s.answers_pixels;
  showPaths();
  if (s.elapsed < (live.errors.at(-1)?.[0] ?? 0)) live.errors = []; // a new render has begun
  const last = live.errors.at(-1);
  if (s.error !== null && s.elapsed > 0 && (!last || last[1] !== s.error)) live.errors.push([s.elapsed, s.error]);
  drawErrors();
}

/** Draws error against time, both on logarithmic axes. */
function drawErrors() {
  const canvas = $("errors"), context = canvas.getContext("2d"), { width, height } = canvas, border = 34;
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  context.fillStyle = "#9aa2b1";
  context.fillText("relative error over time", border, 12);
  if (live.errors.length < 2) return;
  const span = (k) => {
    const logs = live.errors.map((e) => Math.log10(e[k]));
    const low = Math.min(...logs), high = Math.max(...logs);
    return [low, Math.max(high - low, 0.1)];
  };
  const [left, across] = span(0), [bottom, up] = span(1);
  const x = (t) => border + (Math.log10(t) - left) / across * (width - border - 8);
  const y = (e) => height - 20 - (Math.log10(e) - bottom) / up * (height - 44);
  const text = (value) => Number(value.toPrecision(2)).toString();
  context.fillText(text(10 ** (bottom + up)), 0, y(10 ** (bottom + up)) + 4);
  context.fillText(text(10 ** bottom), 0, y(10 ** bottom) + 4);
  context.fillText(`${text(10 ** left)} s`, border, height - 4);
  context.fillText(`${text(10 ** (left + across))} s`, width - 40, height - 4);
  context.strokeStyle = "#f0b45a";
  context.lineWidth = 1.5;
  context.beginPath();
  live.errors.forEach(([t, e], i) => (i ? context.lineTo(x(t), y(e)) : context.moveTo(x(t), y(e))));
  context.stroke();
}

async function poll() {
  try {
    live.state = await (await fetch("state")).json();
    showState();
    if (live.state.version > live.version) await fetchPicture();
    fail("");
  } catch (error) {
    if (live.state?.finished || error instanceof TypeError) { // no answer: the program is gone
      live.ended = true;
      dropQuestion("the program has ended without an answer");
      $("stop").disabled = true;
      $("phase").textContent = "ended";
      fail("The program has ended; this is the last picture that it sent.");
      return;
    }
    fail(error.message);
  }
  setTimeout(poll, 1000 * POLL_SECONDS);
}

function start() {
  $("title").textContent = page.title;
  for (const name of page.operators) $("operator").append(new Option(name, name));
  $("operator").value = "filmic";
  const changed = () => fetchPicture().catch((error) => fail(error.message));
  $("exposure").addEventListener("input", changed);
  $("operator").addEventListener("change", changed);
  const automatic = () => { $("exposure").value = 0; changed(); };
  $("automatic").addEventListener("click", automatic);
  $("zoomIn").addEventListener("click", () => live.view?.zoomBy(1.5));
  $("zoomOut").addEventListener("click", () => live.view?.zoomBy(1 / 1.5));
  $("fit").addEventListener("click", () => live.view?.fit());
  $("closePaths").addEventListener("click", closePaths);
  $("stop").addEventListener("click", async () => {
    $("stop").disabled = true;
    await fetch("stop", { method: "POST" });
  });
  document.addEventListener("keydown", (event) => {
    if (event.target.matches("input, select") || event.ctrlKey || event.metaKey) return;
    const keys = { "+": () => live.view?.zoomBy(1.5), "-": () => live.view?.zoomBy(1 / 1.5),
      f: () => live.view?.fit(), e: automatic, Escape: () => live.view?.mark(null),
      ArrowLeft: () => live.view?.step(-1, 0), ArrowRight: () => live.view?.step(1, 0),
      ArrowUp: () => live.view?.step(0, -1), ArrowDown: () => live.view?.step(0, 1) };
    if (!keys[event.key]) return;
    keys[event.key]();
    event.preventDefault();
  });
  poll();
}

start();
