/* Draws a sweep's page from the data that stand in it; see softact/report/base for the rest. */

const BLUE = "@c1", ORANGE = "@c2", GREY = "@strong";
const TURBO = ["#30123b", "#4662d7", "#36aaf9", "#1ae4b6", "#72fe5e", "#c8ef34", "#faba39",
  "#f66b19", "#ca2a04"].map((colour, n) => [n / 8, colour]);
let data;

const round = (value) => value === null || value === undefined ? "–"
  : typeof value === "number" ? String(+value.toPrecision(5)) : value;

function chartLayout(rest) {
  const { xaxis, yaxis, ...others } = rest;
  return themed({
    font: fonts(), paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    hovermode: "closest", margin: { l: 60, r: 14, t: 36, b: 48 }, showlegend: false,
    dragmode: false, xaxis: { ...AXIS, ...xaxis }, yaxis: { ...AXIS, ...yaxis }, ...others,
  });
}

const complete = (n) => data.status[n] === "complete";
const everyPoint = () => data.status.map((_, n) => n);

function choose(select, columns, start) {
  columns.forEach((column, n) => select.add(new Option(column.label, n)));
  select.value = Math.max(0, Math.min(start, columns.length - 1));
}

/* Points that no other complete one beats in both goals. */
function paretoFront(x, y, signX, signY) {
  const order = everyPoint().filter((n) => complete(n) && x[n] !== null && y[n] !== null)
    .sort((a, b) => signX * (x[b] - x[a]) || signY * (y[b] - y[a]));
  const front = [];
  let best = -Infinity;
  for (const n of order) {
    if (signY * y[n] > best) {
      front.push(n);
      best = signY * y[n];
    }
  }
  return front;
}

function drawFront() {
  const first = data.measures[+byId("first").value], second = data.measures[+byId("second").value];
  if (!first || !second) return;
  const x = first.values, y = second.values;
  const front = paretoFront(x, y, +byId("firstgoal").value, +byId("secondgoal").value);
  const some = (points, marker, name) => ({
    type: points.length > 2000 ? "scattergl" : "scatter", mode: "markers", name, customdata: points,
    x: points.map((n) => x[n]), y: points.map((n) => y[n]), marker,
    text: points.map((n) => `point ${n}: ${data.texts[n]}`),
    hovertemplate: "%{text}<br>%{x:.4~g}, %{y:.4~g}<extra></extra>",
  });
  const good = everyPoint().filter(complete);
  const early = everyPoint().filter((n) => data.status[n] === "no_equilibrium");
  const traces = [
    some(good, { color: BLUE, size: 8, opacity: 0.75 }, "complete"),
    some(early, { color: ORANGE, size: 8, symbol: "x" }, "stopped early"),
    { ...some(front, { color: BLUE, size: 11, line: { width: 2, color: ORANGE } }, "front"),
      mode: "lines+markers", line: { color: ORANGE, width: 1.5 } },
  ];
  const box = byId("front");
  Plotly.react(box, themed(traces), chartLayout({
    xaxis: { title: { text: first.label } }, yaxis: { title: { text: second.label } },
    showlegend: true, legend: { orientation: "h", y: 1.12 },
  }), PLAIN);
  box.removeAllListeners("plotly_click");
  box.on("plotly_click", (event) => showPoint(event.points[0].customdata));
}

function rowsOf(number) {
  const cells = [...data.axes, ...data.measures].map(
    (column) => [column.label, round(column.values[number])]);
  return [["status", data.status[number].replace("_", " ")], ...cells];
}

async function showPoint(number) {
  const box = byId("onepoint");
  box.replaceChildren();
  const head = document.createElement("h3");
  head.textContent = `Point ${number}: ${data.texts[number]}`;
  const shape = document.createElement("div");
  shape.id = "oneshape";
  const scroll = document.createElement("div");
  scroll.className = "scroll";
  const table = document.createElement("table");
  for (const [name, value] of rowsOf(number)) {
    const row = table.insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
  }
  scroll.append(table);
  const note = document.createElement("pre");
  const folder = `${data.cache}/${data.run[number].slice(0, 2)}/${data.run[number]}`;
  note.textContent = data.run[number] ? `softact report ${folder}` : "";
  box.append(head, shape, scroll, note);
  box.dataset.point = number;
  const packed = data.shapes[number];
  if (!packed) {
    shape.style.height = "auto";
    shape.textContent = data.run[number] && data.status[number] !== "failed"
      ? "This page holds the shapes of a part of the points; the command below makes the report "
        + "of this one." : "There is no shape.";
    return;
  }
  await drawShape(shape, packed);
}

async function drawShape(box, packed) {
  const raw = await inflated(packed.data), n = packed.vertices, t = packed.triangles;
  const Kind = packed.wide ? Uint32Array : Uint16Array;
  const faces = new Kind(raw, 0, 3 * t);
  const steps = new Uint16Array(raw.slice(faces.byteLength, faces.byteLength + 6 * n));
  const shade = new Uint8Array(raw, faces.byteLength + 6 * n);
  const corner = (c) => Int32Array.from({ length: t }, (_, k) => faces[3 * k + c]);
  const place = (a) => Float32Array.from({ length: n },
    (_, k) => packed.low[a] + packed.scale * steps[a * n + k]);
  const [low, high] = packed.range;
  const trace = {
    type: "mesh3d", x: place(0), y: place(1), z: place(2), i: corner(0), j: corner(1),
    k: corner(2), hoverinfo: "skip", lighting: { ambient: 0.6, diffuse: 0.6 },
    ...(packed.field ? {
      intensity: Float32Array.from(shade, (s) => low + (high - low) * s / 255),
      cmin: low, cmax: high, colorscale: TURBO,
      colorbar: { title: { text: packed.field, side: "right" }, thickness: 10, len: 0.9 },
    } : { color: "#9fb4c0" }),
  };
  const xyz = ([x, y, z]) => ({ x, y, z });
  const axis = { showbackground: false, nticks: 4, title: { text: "" }, gridcolor: "#8884" };
  await Plotly.newPlot(box, [trace], chartLayout({
    margin: { l: 0, r: 0, t: 0, b: 0 }, dragmode: "orbit",
    scene: {
      aspectmode: "data", xaxis: axis, yaxis: axis, zaxis: axis,
      camera: { eye: xyz(packed.eye.map((v) => 1.6 * v)), up: xyz(packed.up),
        projection: { type: "orthographic" } },
    },
  }), PLAIN);
  box.dataset.ready = "yes";
}

/* Number of each point along an axis, 0 to 1, for its colour. */
function along(axis) {
  const values = axis.values, numbers = axis.number ? values
    : values.map((v) => [...new Set(values)].indexOf(v));
  const known = numbers.filter((v) => v !== null);
  const low = Math.min(...known), high = Math.max(...known);
  return { part: numbers.map((v) => high > low ? ((v ?? low) - low) / (high - low) : 0.5), low, high };
}

function shadeAt(part) {
  const stops = ["#440154", "#3b528b", "#21918c", "#5ec962", "#e0b400"];
  const place = part * (stops.length - 1), n = Math.min(Math.floor(place), stops.length - 2);
  const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  const [a, b] = [rgb(stops[n]), rgb(stops[n + 1])];
  return `rgb(${a.map((v, k) => Math.round(v + (place - n) * (b[k] - v))).join(",")})`;
}

function drawCurves() {
  const { columns, of } = data.curves, y = +byId("curve").value, x = +byId("load").value;
  const axis = data.axes[+byId("colour").value], { part } = along(axis);
  const traces = Object.entries(of).filter(([, line]) => line[x] && line[y]).map(([n, line]) => ({
    type: "scatter", mode: "lines", x: line[x], y: line[y], customdata: line[x].map(() => +n),
    line: { color: shadeAt(part[n]), width: 1.6, dash: complete(n) ? "solid" : "dot" },
    name: `point ${n}: ${data.texts[n]}`,
    hovertemplate: "%{fullData.name}<br>%{x:.4~g}, %{y:.4~g}<extra></extra>",
  }));
  const box = byId("curves");
  Plotly.react(box, themed(traces), chartLayout({
    xaxis: { title: { text: columns[x] } }, yaxis: { title: { text: columns[y] } },
  }), PLAIN);
  box.removeAllListeners("plotly_click");
  box.on("plotly_click", (event) => {
    showPoint(event.points[0].customdata);
    byId("pareto").scrollIntoView();
  });
  const held = Object.keys(of).length, all = data.status.filter((s) => s !== "missing").length;
  const ends = axis.values.filter((v) => v !== null);
  const ends2 = axis.number ? [Math.min(...ends), Math.max(...ends)].map(round) : [ends[0], ends.at(-1)];
  byId("curvenote").textContent = `Dark: ${axis.label} ${ends2[0]}, light: ${ends2[1]}; dotted: `
    + `stopped early.${held < all ? ` ${held} of ${all} curves; all are in curves.h5.` : ""}`;
}

/* Mean of a measure in classes of an axis: its values, or eight bins of a sample. */
function classes(axis, measure) {
  const points = everyPoint().filter((n) => complete(n) && measure.values[n] !== null
    && axis.values[n] !== null && axis.values[n] !== "");
  const values = [...new Set(points.map((n) => axis.values[n]))];
  const bin = axis.number && values.length > 12;
  const low = Math.min(...values), width = bin ? (Math.max(...values) - low) / 8 : 0;
  const sums = new Map();
  for (const n of points) {
    const value = axis.values[n];
    const key = bin ? low + (Math.min(7, Math.floor((value - low) / width)) + 0.5) * width : value;
    const sum = sums.get(key) ?? [0, 0];
    sums.set(key, [sum[0] + measure.values[n], sum[1] + 1]);
  }
  const keys = [...sums.keys()].sort((a, b) => axis.number ? a - b : String(a).localeCompare(b));
  return { points, keys, means: keys.map((key) => sums.get(key)[0] / sums.get(key)[1]) };
}

function drawEffects() {
  const measure = data.measures[+byId("effect").value];
  if (!measure) return;
  const parent = byId("effects");
  parent.replaceChildren();
  for (const axis of data.axes) {
    const box = document.createElement("div");
    parent.append(box);
    const { points, keys, means } = classes(axis, measure);
    Plotly.newPlot(box, themed([
      { type: "scatter", mode: "markers", x: points.map((n) => axis.values[n]), hoverinfo: "x+y",
        y: points.map((n) => measure.values[n]), marker: { color: GREY, size: 5, opacity: 0.5 } },
      { type: "scatter", mode: "lines+markers", x: keys, y: means,
        line: { color: BLUE, width: 2.5 }, hovertemplate: "%{x}: mean %{y:.4~g}<extra></extra>" },
    ]), chartLayout({
      xaxis: { title: { text: axis.label }, ...(axis.number ? {} : { type: "category" }) },
      yaxis: { title: { text: measure.label } },
    }), PLAIN);
  }
}

function drawParallel() {
  const good = everyPoint().filter(complete);
  if (!good.length) return;
  const dimension = (column) => {
    if (column.number !== false) {
      return { label: column.label, values: good.map((n) => column.values[n]) };
    }
    const names = [...new Set(column.values)];
    return { label: column.label, values: good.map((n) => names.indexOf(column.values[n])),
      tickvals: names.map((_, n) => n), ticktext: names };
  };
  const measures = data.measures.slice(0, Math.max(2, 8 - data.axes.length));
  const colour = measures[0] ?? data.axes[0];
  Plotly.newPlot(byId("parallel"), [{
    type: "parcoords", dimensions: [...data.axes, ...measures].map(dimension),
    line: { color: good.map((n) => colour.values[n]), colorscale: "Viridis", showscale: true,
      colorbar: { title: { text: colour.label, side: "right" }, thickness: 10 } },
    labelangle: -12,
  }], chartLayout({ margin: { l: 70, r: 60, t: 90, b: 30 } }), PLAIN);
}

function drawAll() {
  drawFront();
  if (data.curves.columns.length) drawCurves();
  else byId("curvesection").hidden = true;
  drawEffects();
  drawParallel();
}

whenReady(async ({ packed }) => {
  data = JSON.parse(new TextDecoder().decode(await inflated(packed)));
  const stress = data.measures.findIndex((m) => m.name.startsWith("max_principal_stress"));
  choose(byId("first"), data.measures, 0);
  choose(byId("second"), data.measures, stress < 0 ? 1 : stress);
  choose(byId("effect"), data.measures, 0);
  const columns = data.curves.columns.map((label) => ({ label }));
  choose(byId("load"), columns, 0);
  choose(byId("curve"), columns, 1);
  choose(byId("colour"), data.axes, 0);
  for (const id of ["first", "second", "firstgoal", "secondgoal"]) {
    byId(id).addEventListener("change", drawFront);
  }
  for (const id of ["curve", "load", "colour"]) byId(id).addEventListener("change", drawCurves);
  byId("effect").addEventListener("change", drawEffects);
  drawAll();
  onTheme(drawAll);
});
