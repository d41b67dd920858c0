"use strict";
// What a three-dimensional view draws: the body with its axes, ghosts and vectors; earth.js has the Earth and the orbit.
// `flown` is the motion, `ask.label(text, where, arrow)` puts a text at a point of the scene.
const scene = (gl, { data, coastlines, slow }, flown, ask) => {
  const { Cylinder, Geometry, Mesh, Program, Transform, Vec3 } = ogl;
  const { cross, size, toward, unit } = motion;
  const INK = { light: { label: "100%", body: [0.82, 0.84, 0.87], panel: [0.16, 0.25, 0.5], edge: "#1b1f24", axis: "#2f3740", desired: "#0a6b3d", planned: "#8a5cd6", estimated: "#b4540a", before: "#7a828c", orbit: "#b4540a", sea: "#a9c9e4", land: "#8fa878", coast: "#4c5f45", air: "#6ea8dd", night: 0.42 },
    dark: { label: "60%", body: [0.62, 0.65, 0.7], panel: [0.2, 0.33, 0.62], edge: "#e4e7eb", axis: "#d3d9df", desired: "#6fd39b", planned: "#b79af0", estimated: "#f2a050", before: "#9aa4af", orbit: "#f2a050", sea: "#2a5f92", land: "#5f8a55", coast: "#a5c79a", air: "#7fc0ff", night: 0.14 } };
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8a5cd6", "#999999", "#b5651d", "#3aa6a0"];
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  const SHADED = {
    vertex: `attribute vec3 position, normal; uniform mat4 modelMatrix, viewMatrix, projectionMatrix; varying vec3 n, p;
      void main() { n = mat3(modelMatrix) * normal; p = position; gl_Position = projectionMatrix * viewMatrix * modelMatrix * vec4(position, 1.0); }`,
    fragment: `precision highp float; uniform vec3 colour, light; uniform float alpha, flatness, sunlit; varying vec3 n, p;
      void main() { float d = sunlit * max(dot(normalize(n), light), 0.0); gl_FragColor = vec4(colour * mix(0.45 + 0.55 * d, 1.0, flatness) * alpha, alpha); }`,
  };
  const light = { value: new Vec3(0, 0, 1) }, sunlit = { value: 1 };
  const painted = []; // what changes its colour with the theme
  // Two programs for all but the globe: to compile one takes longer than to draw the scene.
  const shared = [false, true].map((transparent) => new Program(gl, { ...SHADED, transparent, depthWrite: !transparent,
    uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: 1 }, flatness: { value: 0 }, light, sunlit } }));
  function look(colour, { alpha = 1, flat = 0 } = {}) {
    const made = { program: shared[Number(alpha < 1)], colour: [0, 0, 0], alpha, flat };
    painted.push((ink) => { const c = ink[colour] || colour; made.colour = typeof c === "string" ? rgb(c) : c; });
    return made;
  }
  function add(parent, geometry, own, mode) {
    const { program } = own, made = new Mesh(gl, { geometry, program, mode, frustumCulled: false });
    if (own.colour) {
      made.onBeforeRender(() => {
        const { colour, alpha, flatness } = program.uniforms;
        [colour.value, alpha.value, flatness.value] = [own.colour, own.alpha, own.flat];
      });
    }
    made.setParent(parent);
    return made;
  }
  const geometry = (points, normals) => new Geometry(gl, { position: { size: 3, data: new Float32Array(points.flat()) }, normal: { size: 3, data: new Float32Array((normals || points).flat()) } });
  const group = (parent) => { const made = new Transform(); made.setParent(parent); return made; };

  function prism({ length, width, axis, sides }) { // faces by kind, and edges
    const radius = width / 2 / Math.cos(Math.PI / sides);
    const at = (k, end) => { // flats face along the other two axes
      const a = ((k + 0.5) * 2 * Math.PI) / sides, v = [(end * length) / 2, radius * Math.cos(a), radius * Math.sin(a)];
      return axis === 0 ? v : axis === 1 ? [v[2], v[0], v[1]] : [v[1], v[2], v[0]];
    };
    const faces = { body: [], panel: [] }, normals = { body: [], panel: [] }, edges = [];
    const triangle = (kind, a, b, c) => {
      const d = unit(cross(b.map((v, i) => v - a[i]), c.map((v, i) => v - a[i])));
      faces[kind].push(a, b, c);
      normals[kind].push(d, d, d);
    };
    for (let k = 0; k < sides; k++) {
      const [a, b, c, d] = [at(k, -1), at(k + 1, -1), at(k + 1, 1), at(k, 1)];
      const kind = k % 2 ? "body" : "panel";
      triangle(kind, a, b, c);
      triangle(kind, a, c, d);
      triangle("body", at(0, 1), d, c);
      triangle("body", at(0, -1), b, a);
      edges.push(a, b, c, d, a, d);
    }
    const kinds = ["body", "panel"];
    return { edges: geometry(edges), faces: kinds.map((kind) => [kind, geometry(faces[kind], normals[kind])]) };
  }
  const shape = prism(data.body);
  const near = new Transform(), world = group(near); // world: inertial axes in the chosen frame
  const body = group(world), local = group(world);
  for (const [kind, faces] of shape.faces) add(body, faces, look(kind));
  add(body, shape.edges, look("edge", { flat: 1 }), gl.LINES);
  const ghosts = Object.fromEntries(["desired", "planned", "estimated", "before"].map((name) => {
    const it = group(world);
    for (const [, faces] of shape.faces) add(it, faces, look(name, { alpha: 0.13 }));
    add(it, shape.edges, look(name, { flat: 1 }), gl.LINES);
    return [name, it];
  }));

  const rod = new Cylinder(gl, { radiusTop: 0.5, radiusBottom: 0.5, height: 1, radialSegments: 12 });
  const cone = new Cylinder(gl, { radiusTop: 0, radiusBottom: 0.5, height: 1, radialSegments: 16 });
  function bar(parent, p, thick, head) { // along its own Y from the origin; `reach` turns and stretches it
    const it = group(parent), shaft = add(it, rod, p), tip = head ? add(it, cone, p) : null;
    it.reach = (v, length = size(v)) => {
      it.visible = length > 0.02;
      if (!it.visible) return;
      it.quaternion.copy(toward([0, 1, 0], unit(v)));
      const end = tip ? Math.min(head, 0.6 * length) : 0;
      shaft.scale.set(thick, length - end, thick);
      shaft.position.set(0, (length - end) / 2, 0);
      if (tip) { tip.scale.set(2.6 * thick, end, 2.6 * thick); tip.position.set(0, length - end / 2, 0); }
    };
    return it;
  }
  function label(text, where, colour, { arrow = false, far = false } = {}) { // where() gives a point of the scene, or null
    const it = ask.label(text, where, arrow, far);
    painted.push((ink) => { it.style.color = ink[colour] || `color-mix(in srgb, ${colour} ${ink.label}, white)`; });
  }
  const inWorld = (parent, v) => [...new Vec3(...v).applyMatrix4(parent.worldMatrix)];
  const arrows = data.vectors.map((v, i) => {
    const colour = COLOURS[i % COLOURS.length], parent = v.frame === "body" ? body : world;
    const it = bar(parent, look(colour, { flat: 0.6 }), 0.03, 0.13), arrow = { ...v, colour, on: v.shown, tip: null };
    arrow.reach = (value, length) => {
      it.reach(value, length);
      arrow.tip = it.visible ? unit(value).map((x) => x * (length + 0.08)) : null;
    };
    label(v.name, () => (arrow.tip && inWorld(parent, arrow.tip)), colour, { arrow: true });
    return arrow;
  });
  const triad = (parent, length, colour, names) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((v, i) => {
    bar(parent, look(colour), 0.012, 0.09).reach(v, length);
    label(names[i], () => (parent.visible ? inWorld(parent, v.map((x) => x * (length + 0.07))) : null), colour);
  });
  triad(body, 1.0, "edge", ["x", "y", "z"]);
  if (flown.position) triad(local, 1.25, "desired", ["X forward", "Y", "Z down"]);
  const AXES = ["#7d5ba6", "#e69f00", "#009e73", "#d55e00"], kinds = [...new Set(data.axes.map((axis) => axis.kind))];
  const HOT = [1, 0.45, 0.05];
  // A vector's parts along its axes: what each rod or wheel gives. Unique for one axis, or three that are independent.
  function along(v, axes) {
    if (axes.length !== 3) return axes.map((a) => v[0] * a[0] + v[1] * a[1] + v[2] * a[2]);
    const [a, b, c] = axes, n = [cross(b, c), cross(c, a), cross(a, b)], det = a[0] * n[0][0] + a[1] * n[0][1] + a[2] * n[0][2];
    return Math.abs(det) < 0.05 ? along(v, []) : n.map((m) => (v[0] * m[0] + v[1] * m[1] + v[2] * m[2]) / det);
  }
  const disc = new Cylinder(gl, { radiusTop: 0.5, radiusBottom: 0.5, height: 1, radialSegments: 6 }); // one sees it turn
  const driven = kinds.map((kind) => { // by the vector that has these axes
    const axes = data.axes.filter((axis) => axis.kind === kind), colour = AXES[kinds.indexOf(kind) % AXES.length], wheel = kind.startsWith("wheel");
    const parts = axes.map(({ name, direction }) => { // they show outside the body, at both ends
      const own = look(colour), bars = [1, -1].map((side) => {
        const it = bar(body, own, 0.035, 0);
        it.reach(direction.map((v) => side * v), 0.66);
        return it;
      });
      label(name, () => (ask.wide() ? inWorld(body, direction.map((v) => 0.74 * v)) : null), "axis");
      const turning = wheel ? add(bars[0], disc, own) : null;
      turning?.scale.set(0.26, 0.05, 0.26);
      turning?.position.set(0, 0.6, 0);
      return { own, cold: rgb(colour), turning };
    });
    return { of: data.vectors.findIndex((vector) => vector.of === kind), parts, directions: axes.map((axis) => axis.direction) };
  }).filter(({ of }) => of >= 0);
  function drive(values, largest, passed) { // values of the vectors; `passed` s of the clock on the wall since the last picture
    for (const { of, parts, directions } of driven) {
      along(values[of], directions).forEach((value, i) => {
        const { own, cold, turning } = parts[i], share = Math.min(1, Math.abs(value) / (largest[of] || 1));
        if (turning) turning.rotation.y += Math.sign(value) * share * 9 * passed;
        else own.colour = cold.map((c, k) => c + (HOT[k] - c) * share);
        own.flat = turning ? 0 : share;
      });
    }
  }
  for (const { name, direction, angle } of data.cones) {
    const long = 1.5, it = group(body), own = look("desired", { alpha: 0.12 }), made = add(it, cone, own); // its tip is in the body
    it.quaternion.copy(toward([0, -1, 0], direction));
    made.scale.set(2 * long * Math.tan(angle), long, 2 * long * Math.tan(angle));
    made.position.set(0, -long / 2, 0);
    label(name, () => (ask.wide() ? inWorld(body, direction.map((v) => 1.3 * v)) : null), "desired");
  }
  const earth = flown.position ? globe(gl, { data, coastlines, slow }, flown, { look, add, group, geometry, label, light, painted, rgb }) : null;
  function paint(theme) {
    for (const p of painted) p(INK[theme]);
    earth?.paint(INK[theme]);
  }
  return { near, world, body, local, ghosts, arrows, earth, light, sunlit, paint, drive };
};
