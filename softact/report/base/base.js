"use strict";
/* Draws the figures of a page from the data that stand in them; see softact/report/base. */

const PLAIN = { displaylogo: false, displayModeBar: false, responsive: true };
const AXIS = { gridcolor: "@line", zerolinecolor: "@strong", linecolor: "@strong",
  automargin: true, exponentformat: "power" };
const PARALLEL = { l: 70, r: 70, t: 90, b: 30 };  // room for the axes' names above them
const HOVERLABEL = { bgcolor: "@pale", bordercolor: "@strong", font: { color: "@ink" } };
const jobs = [], themeJobs = [];

function byId(id) {
  return document.getElementById(id);
}

/* Call ``job(data)`` once the figures stand. */
function whenReady(job) {
  jobs.push(job);
}

/* Call ``job`` when the colours change: light to dark, or to paper. */
function onTheme(job) {
  themeJobs.push(job);
}

function narrow() {
  return window.innerWidth < 740;
}

/* A copy with colour tokens such as "@c1" replaced by the colours of the moment. */
function themed(value) {
  if (typeof value === "string") {
    if (!/^@[a-z]+\d?$/.test(value)) return value;
    return getComputedStyle(document.documentElement).
      getPropertyValue(`--${value.slice(1)}`).trim() || value;
  }
  if (Array.isArray(value)) {
    return value.length && typeof value[0] === "number" ? value : value.map(themed);
  }
  if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, themed(part)]));
}

function fonts() {
  return { family: "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif",
    color: "@ink", size: 12 };
}

/* Sides of a 3-D plot's axes, for aspectmode "manual", such that what is drawn fills the given parts
   of the view: with a parallel projection plotly shows a height of two, however far the eye is.
   box: [low, high] of the three axes; camera: {eye, up}; area: of the plot, {width, height}. */
function fittedSides(box, { eye, up }, area, across, high) {
  const cross = (a, b) => [0, 1, 2].map((n) =>
    a[(n + 1) % 3] * b[(n + 2) % 3] - a[(n + 2) % 3] * b[(n + 1) % 3]);
  const unit = (a) => a.map((part) => part / Math.hypot(...a));
  const right = unit(cross(up, eye)), above = unit(cross(eye, right));
  const sides = box.map(([low, high]) => high - low);
  const seen = (direction) => sides.reduce((sum, side, n) =>
    sum + side * Math.abs(direction[n]), 0);
  const zoom = Math.min(2 * high / seen(above),
    2 * across * area.width / area.height / seen(right));
  return sides.map((side) => side * zoom);
}

async function inflated(base64) {
  const packed = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

async function loadPlotly() {
  const packed = byId("plotly").textContent;
  if (!packed) return;
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await inflated(packed));
  document.head.append(script);
}

/* Layout of a plot: what all have in common, then its own. */
function layoutOf(plot) {
  const { xaxis, yaxis, ...own } = plot.layout;
  const legend = plot.traces.filter((trace) => trace.showlegend !== false).length > 1;
  const parallel = plot.traces.some((trace) => trace.type === "parcoords");
  return {
    font: fonts(), hovermode: "closest",
    margin: parallel ? PARALLEL : { l: 56, r: 12, t: 12, b: 46 },
    paper_bgcolor: "@paper", plot_bgcolor: "@paper", showlegend: legend, dragmode: false,
    colorway: ["@c1", "@c2", "@c3", "@c4", "@c5", "@c6", "@c7", "@c8"],
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)",
      maxheight: 0.95 },
    hoverlabel: HOVERLABEL,
    ...own,
    xaxis: { ...AXIS, title: { text: plot.x }, ...xaxis },
    yaxis: { ...AXIS, title: { text: broken(plot.y ?? "", TITLE_LETTERS) }, ...yaxis, ...namesOfBars(plot) },
  };
}

const LETTERS = 16, TITLE_LETTERS = 30, LEGEND_LETTERS = 36;

/* A text in lines of up to so many letters. */
function broken(text, letters) {
  return String(text).split(" ").reduce((lines, word) => {
    const longer = `${lines.at(-1)} ${word}`.trim();
    return longer.length > letters ? [...lines, word] : [...lines.slice(0, -1), longer];
  }, [""]).filter(Boolean).join("<br>");
}

/* Names of lying bars in lines of up to 16 letters where the window is narrow: the bars need room. */
function namesOfBars(plot) {
  const bars = plot.traces.find((trace) => trace.orientation === "h");
  if (!bars || !narrow()) return {};
  const texts = bars.y.map((name) => broken(name, LETTERS));
  return { tickmode: "array", tickvals: bars.y, ticktext: texts };
}

const HOVER = "%{x:.4~g}, %{y:.4~g}";

function tracesOf(plot) {
  return plot.traces.map((trace) => ({
    ...(["scatter", "bar", "scattergl"].includes(trace.type) ? {
      hovertemplate: plot.traces.length > 1 ? HOVER : `${HOVER}<extra></extra>`,
    } : {}), ...trace, ...(trace.name ? { name: broken(trace.name, LEGEND_LETTERS) } : {}),
  }));
}

/* Room for a legend of many names, which stands above the axes. */
function makeRoom(box, plot) {
  const names = new Set(plot.traces.filter((trace) => trace.showlegend !== false).
    map((trace) => broken(trace.name ?? "", LEGEND_LETTERS)));
  const lines = [...names].flatMap((name) => name.split("<br>"));
  const longest = Math.max(0, ...lines.map((line) => line.length));
  const across = Math.max(1, Math.floor((box.clientWidth - 70) / (60 + 7 * longest)));
  const rows = Math.ceil(lines.length / across);
  box.style.height = "";
  if (names.size > 1 && rows > 1) {
    box.style.height = `${box.clientHeight + 20 * (rows - 1)}px`;
  }
  const ticks = namesOfBars(plot).ticktext?.join("<br>").split("<br>").length ?? 0;
  if (17 * ticks + 70 > box.clientHeight) box.style.height = `${17 * ticks + 70}px`;
}

function drawPlot(box, plot) {
  makeRoom(box, plot);
  return Plotly.react(box, themed(tracesOf(plot)), themed(layoutOf(plot)), PLAIN);
}

/* ---- data as CSV ---- */

/* Columns {head: values} of a plot: its own table, or what its curves are made of. */
function columnsOf(plot) {
  if (plot.table) return plot.table;
  const traces = plot.traces.filter((trace) => trace.x && trace.y);
  const [xHead, yHead] = [plot.x || "x", plot.y || "y"];
  const first = traces[0], same = (trace) => JSON.stringify(trace.x) === JSON.stringify(first.x);
  if (traces.length === 1) return { [xHead]: first.x, [yHead]: first.y };
  const names = new Set(traces.map((trace) => trace.name));
  if (traces.every(same) && names.size === traces.length) {
    return { [xHead]: first.x,
      ...Object.fromEntries(traces.map((trace) => [`${trace.name}: ${yHead}`, trace.y])) };
  }
  return {
    curve: traces.flatMap((trace) => trace.x.map(() => trace.name ?? "")),
    [xHead]: traces.flatMap((trace) => trace.x), [yHead]: traces.flatMap((trace) => trace.y),
  };
}

/* A text that a spreadsheet would compute gets an apostrophe, as in softact/files.py. */
function harmless(text) {
  const signed = /^[+-](\d+\.?\d*|\.\d+)([eE][+-]?\d+)?( ?[A-Za-z°%µ][\w°/^]*)?$/;
  return /^'*[=+@\t\n-]/.test(text) && !signed.test(text) ? `'${text}` : text;
}

function csvOf(plot) {
  const columns = columnsOf(plot), heads = Object.keys(columns);
  const cell = (value) => {
    const text = value === null || value === undefined ? "" : harmless(String(value));
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const rows = columns[heads[0]].map((_, n) => heads.map((head) => cell(columns[head][n])));
  return [heads.map(cell), ...rows].map((row) => row.join(",")).join("\n") + "\n";
}

function save(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/* ---- all figures ---- */

/* What the plot of a figure shows, as softact/report/base/plots.py has it: {title, x, y, traces,
   table, file}; for a frame, whose plot the page's own script draws. */
function describe(box, plot) {
  const figure = box.closest("figure");
  figure.querySelector("b").textContent = plot.title;
  box.setAttribute("aria-label", plot.title);
  figure.plot = plot;
}

function watchLinks() {
  const give = (event) => {
    const plot = event.target.closest?.(".csv")?.closest("figure").plot;
    if (plot) save(plot.file, csvOf(plot));
  };
  document.addEventListener("click", give);
  document.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") give(event);
  });
}

async function drawFigure(figure) {
  const plot = JSON.parse(figure.querySelector("script").textContent);
  const box = figure.querySelector(".plot");
  figure.plot = plot;
  const wide = figure.classList.contains("wide");
  onTheme(({ width, height }) => drawPlot(box, { ...plot, layout: { ...plot.layout, height,
    width: width && wide ? 2 * width : width } }));
  return drawPlot(box, plot);
}

function changeTheme(sizes = {}) {
  themeJobs.forEach((job) => job(sizes));
}

function watchTheme() {
  const root = document.documentElement;
  // A page on its way to paper keeps its sizes when the browser changes the colours for print.
  let sizes = {};
  const resize = (wanted) => {
    sizes = wanted;
    changeTheme(sizes);
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => changeTheme(sizes));
  // Half of the width of a sheet of A4 for each; paper is white.
  window.addEventListener("beforeprint", () => {
    root.classList.add("light");
    document.querySelectorAll("details").forEach((part) => { part.open = true; });
    resize({ width: 330, height: 270 });
  });
  window.addEventListener("afterprint", () => {
    root.classList.remove("light");
    resize({ width: undefined, height: undefined });
  });
}

async function start() {
  await loadPlotly();
  watchLinks();
  const stored = [...document.querySelectorAll("figure.chart")].filter(
    (figure) => figure.querySelector("script"));
  await Promise.all(stored.map(drawFigure));
  const data = JSON.parse(byId("data").textContent);
  for (const job of jobs) await job(data);
  watchTheme();
}

document.addEventListener("DOMContentLoaded", () => start().then(() => {
  document.body.dataset.ready = "yes";
}, (error) => {
  const note = document.createElement("p");
  note.className = "banner bad";
  note.textContent = `The plots could not be drawn (${error.message}); a browser of 2023 or ` +
    "later is needed.";
  document.querySelector("header").append(note);
  document.body.dataset.ready = "failed";
}));
