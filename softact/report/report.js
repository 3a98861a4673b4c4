/* The 3-D view of one run; what it rests on is in shape.js and in base/base.js. */

const SURFACE = 0, SIDES = 2, HELD = 3, PICKED = 4, BODIES = 5;  // places of the traces

class Picture extends Shape {
  constructor(view, raw) {
    super(view, raw);
    this.mesh = false;
    this.picked = null;  // what ``at`` gave
    this.fit();
  }

  /* Fit the axes to this state. */
  fit() {
    this.box = this.margined(this.extent());
  }

  margined(extent) {
    const margin = 0.04 * Math.max(...extent.map(([low, high]) => high - low));
    return extent.map(([low, high]) => [low - margin, high + margin]);
  }

  /* Where a state would stick out of the axes, they take in all states. */
  makeRoom() {
    const inside = this.extent().every(([low, high], n) =>
      low >= this.box[n][0] && high <= this.box[n][1]);
    if (inside) return false;
    this.box = this.view.box;
    return true;
  }

  trace() {
    const { x, y, z, i, j, k, intensity } = this.geometry();
    const { colours, fields } = this.view, field = fields[this.field];
    const scale = colours.map((colour, n) => [n / (colours.length - 1), colour]);
    return {
      type: "mesh3d", x, y, z, i, j, k, flatshading: false, hoverinfo: "skip",
      lighting: { ambient: 0.55, diffuse: 0.6, specular: 0.12, roughness: 0.6, fresnel: 0.1,
        vertexnormalsepsilon: 0, facenormalsepsilon: 0 },
      // In the eye's frame (right, up, away from the eye): the light turns with the reader.
      lightposition: { x: 3e4, y: 6e4, z: -1e5 },
      ...(field ? {
        intensity, cmin: field.low, cmax: field.high, colorscale: scale,
        colorbar: {
          title: { text: field.label, side: narrow() ? "top" : "right" }, thickness: 14,
          outlinewidth: 0, ...(narrow() ? { orientation: "h", x: 0.5, y: -0.02, yanchor: "top",
            len: 0.9, nticks: 5 } : { len: 0.8, x: 1.0 }),
        },
      } : { color: "#9fb4c0" }),
    };
  }

  layout() {
    const { box } = this, { camera } = this.view;
    const coarse = Math.max(...box.map(([low, high]) => high - low)) / 6;
    const power = 10 ** Math.floor(Math.log10(coarse));
    const dtick = power * [1, 2, 5, 10].find((step) => step * power >= coarse);
    const axes = ["x", "y", "z"].map((name, n) => ({
      range: box[n], title: { text: name }, showbackground: false, gridcolor: "@line",
      zeroline: false, dtick, tick0: 0, showspikes: false,
    }));
    const xyz = ([x, y, z]) => ({ x, y, z });
    const eye = xyz(camera.eye.map((part) => 2 * part)), up = xyz(camera.up);
    return {
      font: fonts(), margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "@paper",
      scene: {
        aspectmode: "manual", aspectratio: xyz(this.sides()),
        dragmode: Math.abs(up.z) > 0.99 ? "turntable" : "orbit",
        camera: { eye, up, projection: { type: "orthographic" } },
        xaxis: axes[0], yaxis: axes[1], zaxis: axes[2],
      },
    };
  }

  sides() {
    const [across, high] = narrow() ? [0.9, 0.7] : [0.75, 0.85];
    const area = byId("shape").getBoundingClientRect();
    return fittedSides(this.box, this.view.camera, area, across, high);
  }

  /* Corners of a cube about the axes' box, not drawn: plotly scales each axis by the extent of
     what is drawn, and its shading is right only where the three scales are the same. */
  cube() {
    const { box } = this, half = Math.max(...box.map(([low, high]) => high - low)) / 2;
    const [x, y, z] = box.map(([low, high]) =>
      [(low + high) / 2 - half, (low + high) / 2 + half]);
    return { type: "scatter3d", mode: "markers", x, y, z, marker: { size: 0.1, opacity: 0 },
      hoverinfo: "skip", showlegend: false };
  }

  /* The rigid obstacles: where they are in this state, and whether they are there. */
  bodies() {
    return this.view.bodies.map((body) => {
      const { middle } = body, shift = body.shift[this.state], turn = body.turn[this.state];
      const arms = ["x", "y", "z"].map((axis, n) => body[axis].map((at) => at - middle[n]));
      const [x, y, z] = turn.map((row, n) => arms[0].map((_, i) =>
        middle[n] + shift[n] + row[0] * arms[0][i] + row[1] * arms[1][i] + row[2] * arms[2][i]));
      return { x, y, z, visible: body.there[this.state], body };
    });
  }

  obstacles() {
    return this.bodies().map(({ body, ...moved }) => ({
      type: "mesh3d", ...moved, i: body.i, j: body.j, k: body.k, color: body.colour,
      opacity: 0.45, flatshading: true, hoverinfo: "skip",
    }));
  }

  /* Edges of the elements. */
  edgeLines() {
    return { visible: this.mesh, ...(this.mesh ? this.meshLines() : { x: [], y: [], z: [] }) };
  }

  /* Outlines of the held surfaces, each with its name. */
  heldLines() {
    const lines = { x: [], y: [], z: [] }, text = [];
    this.view.held.forEach(({ name, pairs }) => {
      const { x, y, z } = this.lines(this.copied(pairs));
      const best = this.nearest({ x, y, z });
      text.push(...x.map((_, n) => (n === best ? name : "")));
      lines.x.push(...x), lines.y.push(...y), lines.z.push(...z);
    });
    return { ...lines, text };
  }

  /* Of points, the one highest up and toward the eye. */
  nearest({ x, y, z }) {
    const { eye, up } = this.view.camera;
    const heights = x.map((value, n) => (value === null ? -Infinity
      : [value, y[n], z[n]].reduce((sum, v, axis) => sum + v * (up[axis] + 0.7 * eye[axis]), 0)));
    return heights.indexOf(Math.max(...heights));
  }

  /* Where in the window a vertex is drawn, and how deep: (x, y, z) -> [px, px, depth]. */
  projection() {
    const { glplot, dataScale } = byId("shape")._fullLayout.scene._scene;
    const { model, view, projection } = glplot.cameraParams;
    const area = byId("shape").querySelector(".gl-container canvas").getBoundingClientRect();
    const times = (matrix, v) => [0, 1, 2, 3].map((row) =>
      v.reduce((sum, part, column) => sum + matrix[4 * column + row] * part, 0));
    return (...place) => {
      const scaled = [...place.map((value, axis) => value * dataScale[axis]), 1];
      const [x, y, z, w] = times(projection, times(view, times(model, scaled)));
      return [area.left + area.width * (1 + x / w) / 2, area.top + area.height * (1 - y / w) / 2, z / w];
    };
  }

  /* The place of the surface that is seen at a place of the window: its triangle's vertices and
     their weights, and whether it is no face of a cut; null beside it. */
  at(left, top) {
    const { x, y, z, i, j, k } = this.geometry(), project = this.projection();
    const seen = Array.from(x, (value, n) => project(value, y[n], z[n]));
    let found = null, depth = Infinity;
    for (let face = 0; face < i.length; face++) {
      const ids = [i[face], j[face], k[face]], [a, b, c] = ids.map((id) => seen[id]);
      const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      const one = ((left - a[0]) * (c[1] - a[1]) - (top - a[1]) * (c[0] - a[0])) / area;
      const two = ((b[0] - a[0]) * (top - a[1]) - (b[1] - a[1]) * (left - a[0])) / area;
      const weights = [1 - one - two, one, two];
      if (!weights.every((weight) => weight >= 0)) continue;
      const here = weights.reduce((sum, weight, n) => sum + weight * [a, b, c][n][2], 0);
      if (here < depth) [found, depth] = [[ids, weights, face < this.skinFaces], here];
    }
    return found;
  }

  pickedPoint() {
    if (this.picked === null) return { x: [], y: [], z: [], visible: false };
    const [x, y, z] = this.told(...this.picked).now;
    return { x: [x], y: [y], z: [z], visible: true };
  }

  traces() {
    const line = { type: "scatter3d", mode: "lines", hoverinfo: "skip", showlegend: false };
    return [
      this.trace(), this.cube(),
      { ...line, ...this.edgeLines(), line: { color: "#15202b", width: 1 } },
      { ...line, ...this.heldLines(), mode: "lines+text", textposition: "top left",
        textfont: { color: "@c2", size: 13 }, line: { color: "@c2", width: 6 } },
      { ...line, ...this.pickedPoint(), mode: "markers",
        marker: { size: 7, color: "#000000", line: { color: "#ffffff", width: 2 } } },
      ...this.obstacles(),
    ];
  }

  draw() {
    return Plotly.newPlot("shape", themed(this.traces()), themed(this.layout()), {
      displaylogo: false, responsive: true,
      modeBarButtons: [["toImage", "zoom3d", "pan3d", "resetCameraDefault3d"]],
    });
  }

  /* New colours of text, grid and background; the camera is left alone. */
  async recolour() {
    const { paper_bgcolor, font, scene } = themed(this.layout()), colour = themed("@c2");
    const grid = Object.fromEntries(["xaxis", "yaxis", "zaxis"].map((axis) =>
      [`scene.${axis}.gridcolor`, scene[axis].gridcolor]));
    await Plotly.restyle("shape", { "line.color": colour, "textfont.color": colour }, [HELD]);
    return Plotly.relayout("shape", { paper_bgcolor, "font.color": font.color, ...grid });
  }

  /* The axes as they are to be now. */
  refit() {
    const { scene } = this.layout();
    const ranges = ["xaxis", "yaxis", "zaxis"].flatMap((axis) =>
      [[`scene.${axis}.range`, scene[axis].range], [`scene.${axis}.dtick`, scene[axis].dtick]]);
    return { ...Object.fromEntries(ranges), "scene.aspectratio": scene.aspectratio };
  }

  /* Redraw the surface and leave the camera alone; one drawing at a time, the last of which
     shows the newest state. */
  async update(change) {
    Object.assign(this, change);
    this.stale = true;
    if (this.drawing) return this.drawing;
    this.drawing = (async () => {
      while (this.stale) {
        this.stale = false;
        if (this.makeRoom() || this.fitted) await this.show(this.refit());
        else await this.show({});
        this.fitted = false;
      }
      this.drawing = null;
    })();
    return this.drawing;
  }

  async show(layout) {
    const { x, y, z, i, j, k, intensity, cmin, cmax, colorbar } = this.trace();
    const arrays = { x, y, z, i, j, k, ...(intensity ? { intensity } : {}) };
    const change = listed(arrays);
    if (colorbar) Object.assign(change, { cmin, cmax, "colorbar.title.text": colorbar.title.text });
    await Plotly.restyle("shape", change, [SURFACE]);
    if (Object.keys(layout).length) {
      await Plotly.restyle("shape", listed(this.cube(), "xyz"), [SURFACE + 1]);
      await Plotly.relayout("shape", layout);
    }
    // Each takes a drawing of its own: those that show nothing, and did not, are left alone.
    const { data } = byId("shape"), restyle = (values, nth) =>
      Plotly.restyle("shape", listed(values), [nth]);
    if (this.mesh || data[SIDES].visible) await restyle(this.edgeLines(), SIDES);
    if (this.view.held.length) await restyle(this.heldLines(), HELD);
    if (this.picked || data[PICKED].visible) await restyle(this.pickedPoint(), PICKED);
    for (const [n, { x, y, z, visible }] of this.bodies().entries()) {
      await Plotly.restyle("shape", { x: [x], y: [y], z: [z], visible }, [BODIES + n]);
    }
  }
}

/* Call ``job(x, y)`` where a click or a touch ends where it began; plotly takes both for turning. */
function onClick(box, job) {
  let start = null;
  box.addEventListener("pointerdown", (event) => {
    start = event.isPrimary && !event.button ? event : null;
  }, true);
  window.addEventListener("pointerup", (event) => {
    const still = start && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < 5;
    if (still) job(event.clientX, event.clientY);
    start = null;
  }, true);
}

/* Values as Plotly.restyle wants them for one trace. */
function listed(values, names) {
  return Object.fromEntries(Object.entries(values).
    filter(([name]) => !names || names.includes(name)).map(([name, value]) => [name, [value]]));
}

/* Three digits and the unit, where there is one. */
function quantity(value, unit) {
  return `${+value.toPrecision(3)} ${unit}`.trim();
}

/* A place in mm. */
function coordinates(place) {
  return place.map((value) => value.toFixed(1).replace("-0.0", "0.0").replace("-", "\u2212")).
    join(", ");
}

/* What is written of the picked place. */
function describePick(shape) {
  const box = byId("picked");
  box.hidden = shape.picked === null;
  if (box.hidden) return;
  const { before, now, values, surface, region } = shape.told(...shape.picked);
  const moved = Math.hypot(...now.map((value, n) => value - before[n]));
  const where = [shape.view.regions.length > 1 ? region : "", surface].filter(Boolean).join(", ");
  const rows = [
    ["Place", where || "inside, on the cut"],
    ["Undeformed at x, y, z", `${coordinates(before)} mm`],
    ["Now at x, y, z", `${coordinates(now)} mm, ${quantity(moved, "mm")} away`],
    ...shape.view.fields.map(({ name, unit }, n) =>
      [name[0] === "v" ? name : name[0].toUpperCase() + name.slice(1), quantity(values[n], unit)]),
  ];
  box.querySelector("table").replaceChildren(...rows.map(([head, text]) => {
    const row = document.createElement("tr"), th = document.createElement("th");
    th.scope = "row";
    th.textContent = head;
    row.append(th);
    row.insertCell().textContent = text;
    return row;
  }));
}

/* The select and the slider of the section; ``show`` redraws. */
function sectionControls(shape, show) {
  const axis = byId("sectionaxis"), place = byId("sectionat"), other = byId("sectionother");
  const said = byId("sectionsaid"), part = byId("sectionpart");
  const change = () => {
    part.hidden = axis.value === "";
    if (part.hidden) return show({ section: null, picked: null });
    const n = +axis.value, values = shape.undeformed(n);
    const [low, high] = values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)],
      [Infinity, -Infinity]);
    const at = low + (high - low) * (+place.value + 0.5) / (+place.max + 1);
    said.textContent = `${"xyz"[n]} = ${at.toFixed(1)} mm`;
    const away = shape.view.camera.eye[n] > 0;  // what stands before the cut is taken away
    return show({ section: { axis: n, at, below: away !== other.checked }, picked: null });
  };
  [axis, other].forEach((each) => each.addEventListener("change", change));
  place.addEventListener("input", change);
  return change;
}

async function drawView(view) {
  if (!view) return;
  const shape = new Picture(view, await unpack(view));
  const slider = byId("load"), field = byId("field"), cut = byId("cut"), play = byId("play");
  const mesh = byId("mesh");
  slider.max = view.states.length - 1;
  slider.value = shape.state;
  view.fields.forEach((item, n) => field.add(new Option(item.label, n)));
  field.parentElement.hidden = view.fields.length < 2;
  byId("cutlabel").hidden = !view.mirrors.length || !view.inner;
  const say = () => {
    byId("caption").textContent = view.states[shape.state];
    const item = view.fields[shape.field];
    byId("range").textContent = item && item.largest > item.high * 1.02
      ? `Colours end at ${quantity(item.high, item.unit)}; on the outside the ${item.name} ` +
        `reaches ${quantity(item.largest, item.unit)}.` : "";
    describePick(shape);
  };
  const show = (change) => {
    const drawn = shape.update(change);
    say();
    return drawn;
  };
  const cutAnew = sectionControls(shape, show);
  slider.addEventListener("input", () => show({ state: +slider.value }));
  field.addEventListener("change", () => show({ field: +field.value }));
  mesh.addEventListener("change", () => show({ mesh: mesh.checked }));
  cut.addEventListener("change", () => {
    Object.assign(shape, { cut: cut.checked, picked: null });
    return cutAnew();
  });
  byId("fit").addEventListener("click", () => {
    shape.fit();
    return show({ fitted: true });
  });
  byId("unpick").addEventListener("click", () => show({ picked: null }));
  play.addEventListener("click", async () => {
    if (shape.playing) {
      shape.playing = false;
      return;
    }
    shape.playing = true;
    play.textContent = "\u275a\u275a";
    const first = +slider.value === +slider.max ? 0 : +slider.value;
    for (let k = first; k < view.states.length && shape.playing; k++) {
      slider.value = k;
      await show({ state: k });
      await new Promise((done) => setTimeout(done, 120));
    }
    shape.playing = false;
    play.textContent = "\u25b6";
  });
  await shape.draw();
  onClick(byId("shape"), (x, y) => {
    const picked = shape.at(x, y);
    if (picked) show({ picked });
  });
  document.querySelectorAll(".showspot").forEach((button) => {
    button.addEventListener("click", () => {
      const vertex = shape.nearestTo(button.dataset.place.split(",").map(Number));
      byId("view").scrollIntoView();
      show({ picked: [[vertex, vertex, vertex], [1, 0, 0], true] });
    });
  });
  say();
  onTheme(() => shape.recolour());
}

whenReady((data) => drawView(data.view));
