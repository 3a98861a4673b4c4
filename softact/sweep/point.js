/* One run of a page of many: its name, its last shape, its values, the command for its report. */

const TURBO = ["#30123b", "#4662d7", "#36aaf9", "#1ae4b6", "#72fe5e", "#c8ef34", "#faba39",
  "#f66b19", "#ca2a04"].map((colour, n) => [n / 8, colour]);
const round = (value) => value === null || value === undefined ? "–"
  : typeof value === "number" ? String(+value.toPrecision(5)) : value;

/* number: of the run on its page; rows: [name, value] of the table; shape: as shape.py packs it, or
   nothing; solved: whether the run has a shape, though perhaps not on this page. */
async function showRun({ number, title, rows, shape, solved, command }) {
  const box = byId("onepoint");
  const make = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
  const drawn = make("div", ""), scroll = make("div", ""), table = make("table", "");
  drawn.id = "oneshape";
  scroll.className = "scroll";
  scroll.tabIndex = 0;
  for (const [name, value] of rows) table.insertRow().append(make("td", name), make("td", value));
  scroll.append(table);
  box.replaceChildren(make("h3", title), drawn, scroll, ...(command ? [make("pre", command)] : []));
  box.dataset.point = number;
  if (shape) return drawShape(drawn, shape);
  drawn.style.height = "auto";
  drawn.textContent = solved ? "This page holds the shapes of a part of the runs; the command below "
    + "makes the report of this one." : "There is no shape.";
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
  const extents = [trace.x, trace.y, trace.z].map((values) =>
    [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))]);
  const sides = fittedSides(extents, packed, box.getBoundingClientRect(), 0.7, 0.85);
  await Plotly.newPlot(box, [trace], themed({
    font: fonts(), paper_bgcolor: "rgba(0,0,0,0)", margin: { l: 0, r: 0, t: 0, b: 0 },
    dragmode: "orbit",
    scene: {
      aspectmode: "manual", aspectratio: xyz(sides), xaxis: axis, yaxis: axis, zaxis: axis,
      camera: { eye: xyz(packed.eye.map((v) => 1.6 * v)), up: xyz(packed.up),
        projection: { type: "orthographic" } },
    },
  }), PLAIN);
  box.dataset.ready = "yes";
}

onTheme(() => {
  if (byId("oneshape")?.dataset.ready) {
    Plotly.relayout("oneshape", { "font.color": themed("@ink") });
  }
});
