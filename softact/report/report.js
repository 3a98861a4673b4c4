/* The 3-D view of one run; what it rests on is in base/base.js. */

async function unpack(view) {
  const raw = await inflated(view.data);
  const n = view.vertices, count = view.states.length, faces = view.outer + view.inner;
  const triangles = new Uint32Array(raw, 0, 3 * faces);
  const steps = new Uint16Array(raw, 12 * faces, 3 * n * count);
  const shades = new Uint8Array(raw, 12 * faces + 6 * n * count);
  for (let k = 3 * n; k < steps.length; k++) steps[k] += steps[k - 3 * n];
  for (let k = 0; k < shades.length; k++) {
    if (k % (n * count) >= n) shades[k] += shades[k - n];
  }
  return { triangles, steps, shades };
}

class Shape {
  constructor(view, raw) {
    this.view = view;
    this.raw = raw;
    this.state = view.states.length - 1;
    this.field = 0;
    this.cut = false;
  }

  get mirrors() {
    return this.cut ? [] : this.view.mirrors;
  }

  /* Coordinates of all vertices, the mirrored parts after the computed one. */
  places() {
    const { vertices: n, low, scale } = this.view, copies = 2 ** this.mirrors.length;
    const start = 3 * n * this.state;
    return [0, 1, 2].map((axis) => {
      const values = new Float32Array(n * copies);
      for (let k = 0; k < n; k++) {
        values[k] = low[axis] + scale * this.raw.steps[start + axis * n + k];
      }
      this.mirrors.forEach((mirror, nth) => {
        const sign = mirror === axis ? -1 : 1, size = n * 2 ** nth;
        for (let k = 0; k < size; k++) values[size + k] = sign * values[k];
      });
      return values;
    });
  }

  intensity() {
    const { vertices: n, states, fields } = this.view, copies = 2 ** this.mirrors.length;
    const { low, high } = fields[this.field];
    const start = n * (states.length * this.field + this.state);
    const values = new Float32Array(n * copies);
    for (let k = 0; k < values.length; k++) {
      values[k] = low + (high - low) * this.raw.shades[start + k % n] / 255;
    }
    return values;
  }

  triangles() {
    const n = this.view.vertices, copies = 2 ** this.mirrors.length;
    const faces = this.cut ? this.view.outer + this.view.inner : this.view.outer;
    return [0, 1, 2].map((corner) => {
      const ids = new Int32Array(faces * copies);
      for (let k = 0; k < ids.length; k++) {
        const copy = Math.floor(k / faces);
        ids[k] = copy * n + this.raw.triangles[3 * (k % faces) + corner];
      }
      return ids;
    });
  }

  trace() {
    const [x, y, z] = this.places(), [i, j, k] = this.triangles();
    const { colours, fields } = this.view, field = fields[this.field];
    const scale = colours.map((colour, n) => [n / (colours.length - 1), colour]);
    return {
      type: "mesh3d", x, y, z, i, j, k, flatshading: false, hoverinfo: "skip",
      lighting: { ambient: 0.55, diffuse: 0.6, specular: 0.12, roughness: 0.6, fresnel: 0.1,
        vertexnormalsepsilon: 0, facenormalsepsilon: 0 },
      // In the eye's frame (right, up, away from the eye): the light turns with the reader.
      lightposition: { x: 3e4, y: 6e4, z: -1e5 },
      ...(field ? {
        intensity: this.intensity(), cmin: field.low, cmax: field.high, colorscale: scale,
        colorbar: {
          title: { text: field.label, side: narrow() ? "top" : "right" }, thickness: 14,
          outlinewidth: 0, ...(narrow() ? { orientation: "h", x: 0.5, y: -0.02, yanchor: "top",
            len: 0.9, nticks: 5 } : { len: 0.8, x: 1.0 }),
        },
      } : { color: "#9fb4c0" }),
    };
  }

  layout() {
    const { box, camera } = this.view;
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
    return fittedSides(this.view.box, this.view.camera, area, across, high);
  }

  /* Corners of a cube about the axes' box, not drawn: plotly scales each axis by the extent of
     what is drawn, and its shading is right only where the three scales are the same. */
  cube() {
    const { box } = this.view, half = Math.max(...box.map(([low, high]) => high - low)) / 2;
    const [x, y, z] = box.map(([low, high]) =>
      [(low + high) / 2 - half, (low + high) / 2 + half]);
    return { type: "scatter3d", mode: "markers", x, y, z, marker: { size: 0.1, opacity: 0 },
      hoverinfo: "skip", showlegend: false };
  }

  /* The rigid obstacles: where they are in this state, and whether they are there. */
  bodies() {
    return this.view.bodies.map((body) => {
      const shift = body.shift[this.state];
      const [x, y, z] = ["x", "y", "z"].map((axis, n) => body[axis].map((at) => at + shift[n]));
      return { x, y, z, visible: body.there[this.state], body };
    });
  }

  obstacles() {
    return this.bodies().map(({ body, ...moved }) => ({
      type: "mesh3d", ...moved, i: body.i, j: body.j, k: body.k, color: body.colour,
      opacity: 0.45, flatshading: true, hoverinfo: "skip",
    }));
  }

  draw() {
    const traces = [this.trace(), this.cube(), ...this.obstacles()];
    return Plotly.newPlot("shape", traces, themed(this.layout()), {
      displaylogo: false, responsive: true,
      modeBarButtons: [["toImage", "zoom3d", "pan3d", "resetCameraDefault3d"]],
    });
  }

  /* New colours of text, grid and background; the camera is left alone. */
  recolour() {
    const { paper_bgcolor, font, scene } = themed(this.layout());
    const grid = Object.fromEntries(["xaxis", "yaxis", "zaxis"].map((axis) =>
      [`scene.${axis}.gridcolor`, scene[axis].gridcolor]));
    return Plotly.relayout("shape", { paper_bgcolor, "font.color": font.color, ...grid });
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
        const { x, y, z, i, j, k, intensity, cmin, cmax, colorbar } = this.trace();
        const arrays = { x, y, z, i, j, k, ...(intensity ? { intensity } : {}) };
        const change = Object.fromEntries(Object.entries(arrays).map(([n, v]) => [n, [v]]));
        if (colorbar) {
          Object.assign(change, { cmin, cmax, "colorbar.title.text": colorbar.title.text });
        }
        await Plotly.restyle("shape", change, [0]);
        for (const [n, { x, y, z, visible }] of this.bodies().entries()) {
          await Plotly.restyle("shape", { x: [x], y: [y], z: [z], visible }, [2 + n]);
        }
      }
      this.drawing = null;
    })();
    return this.drawing;
  }
}

/* Three digits and the unit, where there is one. */
function quantity(value, unit) {
  return `${+value.toPrecision(3)} ${unit}`.trim();
}

async function drawView(view) {
  if (!view) return;
  const shape = new Shape(view, await unpack(view));
  const slider = byId("load"), field = byId("field"), cut = byId("cut"), play = byId("play");
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
  };
  const show = (change) => {
    const drawn = shape.update(change);
    say();
    return drawn;
  };
  slider.addEventListener("input", () => show({ state: +slider.value }));
  field.addEventListener("change", () => show({ field: +field.value }));
  cut.addEventListener("change", () => show({ cut: cut.checked }));
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
  say();
  onTheme(() => shape.recolour());
}

whenReady((data) => drawView(data.view));
