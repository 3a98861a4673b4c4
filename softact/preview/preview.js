/* The 3-D view of a preview; what it rests on is in base/base.js. */

class Model {
  constructor(view, raw) {
    this.view = view;
    this.points = new Float32Array(raw, 0, 3 * view.points);
    let at = 12 * view.points;
    this.corners = view.patches.map(({ count, corners }) => {
      const found = new Uint32Array(raw, at, count * corners);
      at += 4 * count * corners;
      return found;
    });
    this.hidden = new Set();
    this.whole = false;
    this.edges = view.edges;
    this.names = true;
  }

  /* Coordinates of the points of a patch, which alone go to the picture. */
  axes(ids) {
    return [0, 1, 2].map((axis) => Float32Array.from(ids, (id) => this.points[3 * id + axis]));
  }

  shows(patch) {
    const other = this.whole ? "open" : "whole";
    return patch.seen !== other && !this.hidden.has(patch.name);
  }

  surface(patch, ids) {
    const number = new Map();
    for (const id of ids) if (!number.has(id)) number.set(id, number.size);
    const [x, y, z] = this.axes([...number.keys()]);
    const corner = (n) => {
      const found = new Int32Array(patch.count);
      for (let k = 0; k < patch.count; k++) found[k] = number.get(ids[3 * k + n]);
      return found;
    };
    return {
      type: "mesh3d", x, y, z, i: corner(0), j: corner(1), k: corner(2), color: patch.colour,
      opacity: patch.opacity, flatshading: true, name: patch.name, hoverinfo: "name",
      hoverlabel: { namelength: -1 },
      lighting: { ambient: 0.6, diffuse: 0.55, specular: 0.05, facenormalsepsilon: 0,
        vertexnormalsepsilon: 0 },
      lightposition: { x: 3e4, y: 6e4, z: -1e5 },
    };
  }

  /* Lines along the sides of triangles, or the edges themselves; a gap after each. */
  lines(patch, ids, look) {
    const each = patch.corners, ends = each === 2 ? [[0, 1]] : [[0, 1], [1, 2], [2, 0]];
    const done = new Set(), x = [], y = [], z = [];
    for (let k = 0; k < patch.count; k++) {
      for (const [a, b] of ends) {
        const p = ids[each * k + a], q = ids[each * k + b];
        const key = Math.min(p, q) * this.view.points + Math.max(p, q);
        if (done.has(key)) continue;
        done.add(key);
        x.push(this.points[3 * p], this.points[3 * q], null);
        y.push(this.points[3 * p + 1], this.points[3 * q + 1], null);
        z.push(this.points[3 * p + 2], this.points[3 * q + 2], null);
      }
    }
    return { type: "scatter3d", mode: "lines", x, y, z, hoverinfo: "skip", showlegend: false,
      line: look };
  }

  /* Names that stand before everything, each in a box with the colour of its part. */
  labels() {
    if (!this.names) return [];
    return this.view.patches.filter((patch) => patch.label && this.shows(patch)).map((patch) => ({
      x: patch.label[0], y: patch.label[1], z: patch.label[2], text: plain(patch.name),
      showarrow: false, bgcolor: "@paper", opacity: 0.85, bordercolor: patch.colour, borderpad: 2,
      font: { color: "@ink", size: narrow() ? 10 : 12 },
    }));
  }

  traces() {
    const found = [];
    this.view.patches.forEach((patch, n) => {
      if (!this.shows(patch)) return;
      if (patch.corners === 3) found.push(this.surface(patch, this.corners[n]));
      else found.push(this.lines(patch, this.corners[n], { color: patch.colour, width: 6 }));
      if (this.edges && patch.corners === 3 && patch.opacity === 1) {
        found.push(this.lines(patch, this.corners[n], { color: "#33424d", width: 1 }));
      }
    });
    return found;
  }

  layout() {
    const { box, camera } = this.view;
    const axis = (n) => ({ range: box[n], title: { text: "xyz"[n] }, showbackground: false,
      gridcolor: "@line", zeroline: false, showspikes: false });
    const area = byId("scene").getBoundingClientRect();
    const [x, y, z] = fittedSides(box, camera, area, narrow() ? 0.95 : 0.8, 0.85);
    const place = (values) => ({ x: values[0], y: values[1], z: values[2] });
    return {
      font: fonts(), margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "@paper",
      showlegend: false, uirevision: "kept",
      scene: {
        aspectmode: "manual", aspectratio: { x, y, z }, dragmode: "turntable",
        camera: { eye: place(camera.eye.map((part) => 2 * part)), up: place(camera.up),
          projection: { type: "orthographic" } },
        xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), annotations: this.labels(),
      },
    };
  }

  draw() {
    return Plotly.react("scene", themed(this.traces()), themed(this.layout()), {
      displaylogo: false, responsive: true,
      modeBarButtons: [["toImage", "zoom3d", "pan3d", "resetCameraDefault3d"]],
    });
  }
}

/* A name as text: plotly reads tags. */
function plain(name) {
  return name.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
}

function legend(model) {
  const known = new Map(model.view.patches.map((patch) => [patch.name, patch]));
  for (const patch of known.values()) {
    const item = document.createElement("li"), button = document.createElement("button");
    const swatch = document.createElement("i"), name = document.createElement("span");
    swatch.style.background = patch.colour;
    name.textContent = patch.name;
    button.type = "button";
    button.title = patch.said;
    button.setAttribute("aria-pressed", "true");
    button.append(swatch, name);
    button.addEventListener("click", () => {
      const gone = model.hidden.delete(patch.name);
      if (!gone) model.hidden.add(patch.name);
      button.setAttribute("aria-pressed", String(gone));
      model.draw();
    });
    item.append(button);
    byId("legend").append(item);
  }
}

whenReady(async ({ view }) => {
  const model = new Model(view, await inflated(view.data));
  for (const name of ["whole", "edges", "names"]) {
    const box = byId(name);
    box.checked = model[name];
    box.addEventListener("change", () => {
      model[name] = box.checked;
      model.draw();
    });
  }
  byId("wholelabel").hidden = !view.both;
  legend(model);
  await model.draw();
  onTheme(() => model.draw());
});
