/* Draws a sweep's page from the data that stand in it; see softact/report/base for the rest. */

const BLUE = "@c1", ORANGE = "@c2", GREY = "@strong";
let data, sheet = {};  // sheet: what onTheme says of paper

function chartLayout(rest, wide = 2) {
  const { xaxis, yaxis, ...others } = rest;
  const size = sheet.width ? { width: wide * sheet.width, height: sheet.height } : {};
  return themed({
    font: fonts(), paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    hovermode: "closest", hoverlabel: HOVERLABEL, margin: { l: 60, r: 14, t: 36, b: 48 }, showlegend: false,
    dragmode: false, xaxis: { ...AXIS, ...xaxis }, yaxis: { ...AXIS, ...yaxis }, ...others,
    ...size,
  });
}

/* Columns of the axes, for a CSV. */
const axesOf = (pick) => Object.fromEntries(data.axes.map((a) => [a.label, pick(a.values)]));
/* A point's name and coordinates, a line each: a phone is narrow. */
const told = (n) => `point ${n}: ${data.texts[n]}`.replaceAll(", ", "<br>");
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
    text: points.map((n) => told(n)),
    hovertemplate: "%{text}<br>%{x:.4~g}, %{y:.4~g}<extra></extra>",
  });
  const good = everyPoint().filter(complete);
  const early = everyPoint().filter((n) => data.status[n] === "no_equilibrium");
  const traces = [
    some(good, { color: BLUE, size: 8, opacity: 0.75 }, "complete"),
    some(early, { color: ORANGE, size: 8, symbol: "x" }, "stopped early"),
    // Not joined: between two of them nothing was computed.
    some(front, { color: BLUE, size: 11, line: { width: 2, color: ORANGE } }, "front"),
  ];
  const box = byId("front");
  Plotly.react(box, themed(traces), chartLayout({
    xaxis: { title: { text: first.label } }, yaxis: { title: { text: second.label } },
    showlegend: true, legend: { orientation: "h", y: 1.12 },
  }), PLAIN);
  const shown = [...good, ...early], pick = (values) => shown.map((n) => values[n]);
  describe(box, {
    title: `${second.label} and ${first.label}`, file: "pareto_front.csv", table: {
      point: shown, ...axesOf(pick), status: pick(data.status), [first.label]: pick(x),
      [second.label]: pick(y), front: shown.map((n) => front.includes(n) ? "yes" : "no"),
    },
  });
  box.removeAllListeners("plotly_click");
  box.on("plotly_click", (event) => showPoint(event.points[0].customdata));
}

function rowsOf(number) {
  const cells = [...data.axes, ...data.measures].map(
    (column) => [column.label, round(column.values[number])]);
  return [["status", data.status[number].replace("_", " ")], ...cells];
}

/* Point ``number`` beside the front. */
function showPoint(number) {
  const folder = `${data.cache}/${data.run[number].slice(0, 2)}/${data.run[number]}`;
  const solved = data.run[number] && data.status[number] !== "failed";
  return showRun({
    number, title: `Point ${number}: ${data.texts[number]}`, rows: rowsOf(number),
    shape: data.shapes[number], solved, command: data.run[number] ? `softact report ${folder}` : "",
  });
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
  const dark = themed("@paper") !== "#ffffff";
  const stops = dark ? ["#8a6fd6", "#5b92dd", "#2fb3a6", "#84d96f", "#ffe66b"]
    : ["#440154", "#3b528b", "#21918c", "#5ec962", "#e0b400"];
  const place = part * (stops.length - 1), n = Math.min(Math.floor(place), stops.length - 2);
  const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  const [a, b] = [rgb(stops[n]), rgb(stops[n + 1])];
  return `rgb(${a.map((v, k) => Math.round(v + (place - n) * (b[k] - v))).join(",")})`;
}

/* A row for each increment of the curves. */
function curveTable(traces, x, y) {
  const pick = (values) => traces.flatMap((t) => t.customdata.map((n) => values[n]));
  return { point: traces.flatMap((t) => t.customdata), ...axesOf(pick),
    [x]: traces.flatMap((t) => t.x), [y]: traces.flatMap((t) => t.y) };
}

function drawCurves() {
  const { columns, of } = data.curves, y = +byId("curve").value, x = +byId("load").value;
  const axis = data.axes[+byId("colour").value], { part } = along(axis);
  const traces = Object.entries(of).filter(([, line]) => line[x] && line[y]).map(([n, line]) => ({
    type: "scatter", mode: "lines", x: line[x], y: line[y], customdata: line[x].map(() => +n),
    line: { color: shadeAt(part[n]), width: 1.6, dash: complete(n) ? "solid" : "dot" },
    name: told(n),
    hovertemplate: "%{fullData.name}<br>%{x:.4~g}, %{y:.4~g}<extra></extra>",
  }));
  const box = byId("curves");
  Plotly.react(box, themed(traces), chartLayout({
    xaxis: { title: { text: columns[x] } }, yaxis: { title: { text: columns[y] } },
  }), PLAIN);
  describe(box, { title: `${columns[y]} over ${columns[x]}`, file: "curves_shown.csv",
    table: curveTable(traces, columns[x], columns[y]) });
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
    const figure = byId("effect-frame").content.firstElementChild.cloneNode(true);
    const box = figure.querySelector(".plot");
    parent.append(figure);
    const { points, keys, means } = classes(axis, measure);
    const traces = [
      { type: "scatter", mode: "markers", name: "runs", x: points.map((n) => axis.values[n]), hoverinfo: "x+y",
        y: points.map((n) => measure.values[n]), marker: { color: GREY, size: 5, opacity: 0.5 } },
      { type: "scatter", mode: "lines+markers", name: "mean", x: keys, y: means,
        line: { color: BLUE, width: 2.5 }, hovertemplate: "%{x}: mean %{y:.4~g}<extra></extra>" },
    ];
    describe(box, { title: axis.label, file: `effect_of_${axis.name}.csv`, traces,
      x: axis.label, y: measure.label });
    Plotly.newPlot(box, themed(traces), chartLayout({
      xaxis: { title: { text: axis.label }, ...(axis.number ? {} : { type: "category" }) },
      yaxis: { title: { text: measure.label } },
    }, 1), PLAIN);
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
  const shown = [...data.axes, ...measures], box = byId("parallel");
  describe(box, { title: "The complete runs", file: "parallel_coordinates.csv", table: {
    point: good, ...Object.fromEntries(shown.map((c) => [c.label, good.map((n) => c.values[n])])),
  } });
  Plotly.newPlot(box, [{
    type: "parcoords", dimensions: shown.map(dimension),
    line: { color: good.map((n) => colour.values[n]), colorscale: "Viridis", showscale: true,
      colorbar: { title: { text: colour.label, side: "right" }, thickness: 10 } },
    labelangle: -12,
  }], chartLayout({ margin: PARALLEL }), PLAIN);
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
  ["first", "second"].forEach((id, n) => {
    const [name, sign] = data.wanted[n] || [], place = data.measures.findIndex((m) => m.name === name);
    if (place < 0) return;
    byId(id).value = place;
    byId(`${id}goal`).value = sign;
  });
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
  onTheme((sizes) => {
    sheet = sizes;
    drawAll();
  });
});
