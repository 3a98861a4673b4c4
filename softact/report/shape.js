/* The data of the 3-D view: surfaces and values of any state, whole or cut; see viewer.py. */

const NONE = 255;
/* Of a tet: its edges, and the corners of eight smaller ones among its corners and their middles. */
const EDGES = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
const EIGHT = [[0, 4, 6, 7], [1, 5, 4, 8], [2, 6, 5, 9], [3, 7, 8, 9],
  [6, 8, 4, 5], [6, 8, 5, 9], [6, 8, 9, 7], [6, 8, 7, 4]];
const ONE = [[0, 1, 2, 3]];

function undelta(values, length) {
  for (let k = 0; k < values.length; k++) {
    if (k % length) values[k] += values[k - 1];
  }
  return values;
}

async function unpack(view) {
  const raw = await inflated(view.data);
  const n = view.vertices, count = view.states.length, faces = view.outer + view.inner;
  let at = 0;
  const take = (Kind, length) => {
    const part = new Kind(raw, at, length);
    at += part.byteLength;
    return part;
  };
  const triangles = undelta(take(Uint32Array, 3 * faces), faces);
  const tets = undelta(take(Uint32Array, 4 * view.tets), view.tets);
  const above = take(Uint32Array, view.peaks), values = take(Float32Array, view.peaks);
  const peaks = new Map(Array.from(above, (place, k) => [place, values[k]]));
  const size = 3 * n * count, low = take(Uint8Array, size), high = take(Uint8Array, size);
  const steps = new Uint16Array(size);
  for (let k = 0; k < size; k++) {
    const signed = low[k] | (high[k] << 8);
    steps[k] = (signed >> 1) ^ -(signed & 1);
  }
  undelta(steps, n);
  for (let k = 3 * n; k < size; k++) steps[k] += steps[k - 3 * n];
  const shades = take(Uint8Array, view.fields.length * count * n);
  for (let k = 0; k < shades.length; k++) {
    if (k % (n * count) >= n) shades[k] += shades[k - n];
  }
  const region = take(Uint8Array, n), surface = take(Uint8Array, n), copied = take(Uint8Array, n);
  return { triangles, tets, peaks, steps, shades, region, surface, ...linked(view, triangles, copied) };
}

/* same: of each vertex the last of those at its node; middles: the vertex halfway between two, by
   the key of the two, of quadratic faces; sides: pairs of vertices along the elements' edges, those
   of outer faces first, of which there are so many numbers in ``outerSides``. */
function linked(view, triangles, copied) {
  const n = view.vertices, faces = view.outer + view.inner, same = new Uint32Array(n);
  for (let k = n - 1; k >= 0; k--) same[k] = copied[k] ? same[k + 1] : k;
  const middles = new Map(), seen = new Set(), sides = [];
  const corner = (face, nth) => triangles[nth * faces + face];
  const join = (a, b, middle) => {
    const key = keyOf(n, same[a], same[b]);
    if (middle !== undefined) middles.set(key, same[middle]);
    if (seen.has(key)) return;
    seen.add(key);
    sides.push(...(middle === undefined ? [a, b] : [a, middle, middle, b]));
  };
  let outerSides = 0;
  for (let face = 0; face < faces; face += view.pieces) {
    if (face === view.outer) outerSides = sides.length;
    if (view.pieces === 1) {
      const [a, b, c] = [0, 1, 2].map((nth) => corner(face, nth));
      join(a, b), join(b, c), join(c, a);
    } else {  // the first three of the four pieces stand at the corners
      const [a, ab, ca] = [0, 1, 2].map((nth) => corner(face, nth));
      const [b, bc, c] = [corner(face + 1, 1), corner(face + 1, 2), corner(face + 2, 2)];
      join(a, b, ab), join(b, c, bc), join(c, a, ca);
    }
  }
  return { same, middles, sides, outerSides: view.inner ? outerSides : sides.length };
}

function keyOf(n, a, b) {
  return a < b ? a * n + b : b * n + a;
}

/* Vertices between vertices: of the copies of the mesh first, then those that a cut adds. */
class Cut {
  constructor(shape, axis, at, below) {
    this.shape = shape;
    this.size = shape.view.vertices * shape.copies;
    this.parents = [];  // [a, b, part] of each vertex that was added
    this.known = new Map();
    this.undeformed = [0, 1, 2].map((each) => Array.from(shape.undeformed(each)));
    const sign = below ? 1 : -1;
    this.height = Array.from(this.undeformed[axis], (place) => sign * (at - place) || 1e-12);
  }

  /* The vertex at a part of the way from a to b, which is made once for each pair of its group. */
  between(a, b, part, group) {
    const key = `${group}:${a < b ? `${a},${b}` : `${b},${a}`}`;
    let found = group === null ? undefined : this.known.get(key);
    if (found === undefined) {
      found = this.size + this.parents.length;
      this.parents.push([a, b, part]);
      this.height.push((1 - part) * this.height[a] + part * this.height[b] || 1e-12);
      this.undeformed.forEach((all) => all.push((1 - part) * all[a] + part * all[b]));
      if (group !== null) this.known.set(key, found);
    }
    return found;
  }

  crossing(a, b, group) {
    return this.between(a, b, this.height[a] / (this.height[a] - this.height[b]), group);
  }

  kept(vertex) {
    return this.height[vertex] > 0;
  }

  /* What is left of triangles [i, j, k]. */
  triangles([i, j, k]) {
    const left = [[], [], []];
    const add = (a, b, c) => [a, b, c].forEach((vertex, nth) => left[nth].push(vertex));
    for (let face = 0; face < i.length; face++) {
      const ids = [i[face], j[face], k[face]], count = ids.filter((v) => this.kept(v)).length;
      if (count === 3) add(...ids);
      if (count === 0 || count === 3) continue;
      const odd = ids.findIndex((v) => this.kept(v) === (count === 1));
      const [a, b, c] = [0, 1, 2].map((nth) => ids[(odd + nth) % 3]);
      const ab = this.crossing(a, b, "s"), ac = this.crossing(a, c, "s");
      if (count === 1) add(a, ab, ac);
      else add(ab, b, c), add(ab, c, ac);
    }
    return left;
  }

  /* The face of the cut through the tets: triangles [i, j, k]. */
  face() {
    const { view, raw, copies } = this.shape, n = view.vertices, count = view.tets;
    const left = [[], [], []];
    for (let copy = 0; copy < copies; copy++) {
      for (let tet = 0; tet < count; tet++) {
        const corners = [0, 1, 2, 3].map((nth) => raw.tets[nth * count + tet]);
        const above = corners.filter((v) => this.kept(v + copy * n)).length;
        // A face that is curved may cross where no corner does; it is seen from its neighbour.
        if (above > 0 && above < 4) this.through(corners, copy * n, left);
      }
    }
    return left;
  }

  through(corners, start, left) {
    const { view, raw } = this.shape, n = view.vertices;
    const ids = corners.map((v) => v + start);
    if (view.pieces === 4) {
      EDGES.forEach(([a, b]) => {
        const middle = raw.middles.get(keyOf(n, raw.same[corners[a]], raw.same[corners[b]]));
        ids.push(middle === undefined ? this.between(ids[a], ids[b], 0.5, "m") : middle + start);
      });
    }
    (view.pieces === 4 ? EIGHT : ONE).forEach((four) => {
      const own = four.map((nth) => ids[nth]);
      const above = own.filter((v) => this.kept(v)), below = own.filter((v) => !this.kept(v));
      if (!above.length || !below.length) return;
      const [few, many] = above.length < below.length ? [above, below] : [below, above];
      const at = few.flatMap((a) => many.map((b) => this.crossing(a, b, "f")));
      const add = (...three) => this.outward(three.map((nth) => at[nth]), above[0]).forEach(
        (vertex, k) => left[k].push(vertex));
      add(0, 1, 2);
      if (few.length === 2) add(1, 2, 3);  // at: a1-b1, a1-b2, a2-b1, a2-b2
    });
  }

  /* A triangle of the face turned such that its normal points away from a vertex that is kept. */
  outward([a, b, c], kept) {
    const [p, q, r] = [b, c, kept].map((v) => this.undeformed.map((all) => all[v] - all[a]));
    const volume = [0, 1, 2].reduce((sum, n) =>
      sum + p[n] * (q[(n + 1) % 3] * r[(n + 2) % 3] - q[(n + 2) % 3] * r[(n + 1) % 3]), 0);
    return volume > 0 ? [a, c, b] : [a, b, c];
  }

  /* A quantity of all vertices from that of the mesh's. */
  extended(values) {
    const all = new Float32Array(this.size + this.parents.length);
    all.set(values);
    this.parents.forEach(([a, b, part], nth) => {
      all[this.size + nth] = (1 - part) * all[a] + part * all[b];
    });
    return all;
  }

  /* Of the pairs of vertices, what is left, one after the other. */
  lines(pairs) {
    const left = [];
    for (let k = 0; k < pairs.length; k += 2) {
      const [a, b] = [pairs[k], pairs[k + 1]], [inside, outside] = [a, b].map((v) => this.kept(v));
      if (inside && outside) left.push(a, b);
      else if (inside) left.push(a, this.crossing(a, b, "s"));
      else if (outside) left.push(this.crossing(a, b, "s"), b);
    }
    return left;
  }
}

/* One state of the actuator as it is seen. */
class Shape {
  constructor(view, raw) {
    this.view = view;
    this.raw = raw;
    this.state = view.states.length - 1;
    this.field = 0;
    this.cut = false;
    this.section = null;  // {axis, at, below}
  }

  get mirrors() {
    return this.cut ? [] : this.view.mirrors;
  }

  get copies() {
    return 2 ** this.mirrors.length;
  }

  /* Coordinates of the vertices of the mesh in a state, the mirrored parts after the computed one. */
  coordinates(axis, state) {
    const { vertices: n, low, scale } = this.view, values = new Float32Array(n * this.copies);
    const start = 3 * n * state + axis * n;
    for (let k = 0; k < n; k++) values[k] = low[axis] + scale * this.raw.steps[start + k];
    this.mirrors.forEach((mirror, nth) => {
      const sign = mirror === axis ? -1 : 1, size = n * 2 ** nth;
      for (let k = 0; k < size; k++) values[size + k] = sign * values[k];
    });
    return values;
  }

  undeformed(axis) {
    return this.coordinates(axis, 0);
  }

  /* Values of a field in a state. whole: with what is above the colour range. */
  values(field, state, whole) {
    const { vertices: n, states, fields } = this.view, { low, high } = fields[field];
    const start = n * (states.length * field + state), values = new Float32Array(n * this.copies);
    for (let k = 0; k < n; k++) {
      const peak = whole ? this.raw.peaks.get(start + k) : undefined;
      values[k] = peak ?? low + (high - low) * this.raw.shades[start + k] / 255;
    }
    for (let k = n; k < values.length; k++) values[k] = values[k % n];
    return values;
  }

  allTriangles(inner) {
    const n = this.view.vertices, faces = this.view.outer + this.view.inner;
    const drawn = inner ? faces : this.view.outer;
    return [0, 1, 2].map((corner) => {
      const ids = new Int32Array(drawn * this.copies);
      for (let k = 0; k < ids.length; k++) {
        const copy = Math.floor(k / drawn);
        ids[k] = copy * n + this.raw.triangles[corner * faces + k % drawn];
      }
      return ids;
    });
  }

  /* Pairs of vertices of all copies. */
  copied(pairs) {
    const n = this.view.vertices;
    return Array.from({ length: this.copies }, (_, copy) => copy * n).
      flatMap((start) => Array.from(pairs, (vertex) => start + vertex));
  }

  /* What is drawn: {x, y, z, i, j, k, intensity}. */
  geometry() {
    const field = this.view.fields[this.field];
    const own = [0, 1, 2].map((axis) => this.coordinates(axis, this.state));
    const shades = field ? this.values(this.field, this.state, false) : null;
    if (!this.section) {
      this.knife = null;
      const [i, j, k] = this.allTriangles(this.cut);
      this.skinFaces = i.length;
      return { x: own[0], y: own[1], z: own[2], i, j, k, ...(field ? { intensity: shades } : {}) };
    }
    const knife = this.knife = new Cut(this, this.section.axis, this.section.at, this.section.below);
    const skin = knife.triangles(this.visible()), face = knife.face();
    this.skinFaces = skin[0].length;
    this.lineEnds = knife.lines(this.edges());
    const [x, y, z] = own.map((values) => knife.extended(values));
    const [i, j, k] = skin.map((ids, nth) => Int32Array.from([...ids, ...face[nth]]));
    return { x, y, z, i, j, k, ...(field ? { intensity: knife.extended(shades) } : {}) };
  }

  /* Triangles that a cut may show: without the symmetry planes where the other half stands there. */
  visible() {
    const all = this.allTriangles(true);
    if (!this.mirrors.length) return all;
    const flat = this.mirrors.map((axis) => this.undeformed(axis));
    const size = Math.max(...this.view.box.map(([low, high]) => high - low));
    const keep = [];
    for (let face = 0; face < all[0].length; face++) {
      const inPlane = flat.some((place) => all.every((ids) => Math.abs(place[ids[face]]) < 1e-4 * size));
      if (!inPlane) keep.push(face);
    }
    return all.map((ids) => keep.map((face) => ids[face]));
  }

  edges() {
    const { sides, outerSides } = this.raw;
    const inner = this.cut || this.section;
    return this.copied(inner ? sides : sides.slice(0, outerSides));
  }

  /* Coordinates of the mesh's vertices a little above the surface, so that lines are seen on it. */
  raised() {
    const own = [0, 1, 2].map((axis) => this.coordinates(axis, this.state));
    const normal = own.map((values) => new Float32Array(values.length));
    const [i, j, k] = this.allTriangles(true), n = this.view.vertices;
    for (let face = 0; face < i.length; face++) {
      const ids = [i[face], j[face], k[face]], [a, b, c] = ids.map((v) => own.map((all) => all[v]));
      const [p, q] = [b, c].map((end) => end.map((value, axis) => value - a[axis]));
      // A mirrored copy has its triangles the wrong way round.
      const turns = Math.floor(ids[0] / n).toString(2).split("1").length % 2 ? 1 : -1;
      normal.forEach((all, axis) => {
        const [one, two] = [(axis + 1) % 3, (axis + 2) % 3];
        const part = turns * (p[one] * q[two] - p[two] * q[one]);
        ids.forEach((v) => { all[v] += part; });
      });
    }
    const lift = 2e-3 * Math.max(...this.view.box.map(([low, high]) => high - low));
    for (let v = 0; v < own[0].length; v++) {
      const length = Math.hypot(...normal.map((all) => all[v])) || 1;
      own.forEach((values, axis) => { values[v] += lift * normal[axis][v] / length; });
    }
    return own;
  }

  /* Coordinates {x, y, z} of lines through pairs of vertices, with gaps. */
  lines(pairs, own = [0, 1, 2].map((axis) => this.coordinates(axis, this.state))) {
    const all = this.knife ? own.map((values) => this.knife.extended(values)) : own;
    const [x, y, z] = all.map((values) => {
      const line = [];
      for (let k = 0; k < pairs.length; k += 2) line.push(values[pairs[k]], values[pairs[k + 1]], null);
      return line;
    });
    return { x, y, z };
  }

  meshLines() {
    return this.lines(this.section ? this.lineEnds : this.edges(), this.raised());
  }

  /* [low, high] of x, y and z of this state. */
  extent() {
    return [0, 1, 2].map((axis) => {
      const values = this.coordinates(axis, this.state);
      return values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)],
        [Infinity, -Infinity]);
    });
  }

  /* The vertex nearest to a place of the undeformed actuator. */
  nearestTo(place) {
    const own = [0, 1, 2].map((axis) => this.undeformed(axis));
    let best = 0, least = Infinity;
    for (let k = 0; k < own[0].length; k++) {
      const far = own.reduce((sum, values, axis) => sum + (values[k] - place[axis]) ** 2, 0);
      if (far < least) [best, least] = [k, far];
    }
    return best;
  }

  /* What is known of a place between three vertices: its coordinates, values, surface and region. */
  told(ids, weights, onSkin) {
    const n = this.view.vertices, own = ids.filter((id) => id < n * this.copies);
    const of = (values) => {
      const all = this.knife ? this.knife.extended(values) : values;
      return ids.reduce((sum, id, nth) => sum + weights[nth] * all[id], 0);
    };
    const common = (numbers) => {
      const found = new Set(own.map((id) => numbers[id % n]));
      return found.size === 1 ? [...found][0] : NONE;
    };
    return {
      before: [0, 1, 2].map((axis) => of(this.coordinates(axis, 0))),
      now: [0, 1, 2].map((axis) => of(this.coordinates(axis, this.state))),
      values: this.view.fields.map((_, field) => of(this.values(field, this.state, true))),
      surface: onSkin ? this.view.surfaces[common(this.raw.surface)] : undefined,
      region: this.view.regions[common(this.raw.region)],
    };
  }
}
