"use strict";
// What a three-dimensional view draws: the body with its axes, ghosts and vectors, and the Earth with the orbit.
// `flown` is the motion, `ask.label(text, where, arrow)` puts a text at a point of the scene.
const scene = (gl, { data, coastlines }, flown, ask) => {
  const { Cylinder, Geometry, Mesh, Program, Quat, Sphere, Texture, Transform, Vec3 } = ogl;
  const { cross, size, unit } = motion;
  const INK = { light: { label: "100%", body: [0.82, 0.84, 0.87], panel: [0.16, 0.25, 0.5], edge: "#1b1f24", axis: "#2f3740", desired: "#0a6b3d", planned: "#8a5cd6", estimated: "#b4540a", orbit: "#b4540a", sea: "#c9dcec", land: "#8aa37c", coast: "#4c5f45" },
    dark: { label: "60%", body: [0.62, 0.65, 0.7], panel: [0.2, 0.33, 0.62], edge: "#e4e7eb", axis: "#d3d9df", desired: "#6fd39b", planned: "#b79af0", estimated: "#f2a050", orbit: "#f2a050", sea: "#1d3a56", land: "#4d6b48", coast: "#8fae86" } };
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8a5cd6", "#999999", "#b5651d", "#3aa6a0"];
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  const SHADED = {
    vertex: `attribute vec3 position, normal; uniform mat4 modelMatrix, viewMatrix, projectionMatrix; varying vec3 n, p;
      void main() { n = mat3(modelMatrix) * normal; p = position; gl_Position = projectionMatrix * viewMatrix * modelMatrix * vec4(position, 1.0); }`,
    fragment: `precision highp float; uniform vec3 colour, light; uniform float alpha, flatness; varying vec3 n, p;
      void main() { float d = max(dot(normalize(n), light), 0.0); gl_FragColor = vec4(colour * mix(0.5 + 0.5 * d, 1.0, flatness) * alpha, alpha); }`,
  };
  const GLOBE = `precision highp float; uniform sampler2D map; uniform vec3 light; uniform float lit; varying vec3 n, p;
    void main() {
      vec3 q = normalize(p);
      vec3 c = texture2D(map, vec2(atan(-q.z, q.x) / 6.2831853 + 0.5, asin(clamp(q.y, -1.0, 1.0)) / 3.1415927 + 0.5)).rgb;
      float day = smoothstep(-0.08, 0.08, dot(normalize(n), light));
      gl_FragColor = vec4(c * mix(1.0, mix(0.3, 1.0, day), lit), 1.0);
    }`;
  const light = { value: new Vec3(0, 0, 1) };
  const painted = []; // what changes its colour with the theme
  // Two programs for all but the globe: to compile one takes longer than to draw the scene.
  const shared = [false, true].map((transparent) => new Program(gl, { ...SHADED, transparent, depthWrite: !transparent,
    uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: 1 }, flatness: { value: 0 }, light } }));
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
  const ghosts = Object.fromEntries(["desired", "planned", "estimated"].map((name) => {
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
      const d = unit(v), w = 1 + d[1];
      it.quaternion.copy(w < 1e-6 ? new Quat(1, 0, 0, 0) : new Quat(...cross([0, 1, 0], d), w).normalize());
      const end = tip ? Math.min(head, 0.6 * length) : 0;
      shaft.scale.set(thick, length - end, thick);
      shaft.position.set(0, (length - end) / 2, 0);
      if (tip) { tip.scale.set(2.6 * thick, end, 2.6 * thick); tip.position.set(0, length - end / 2, 0); }
    };
    return it;
  }
  function label(text, where, colour, arrow = false) { // where() gives a point of the scene, or null; the end of an arrow
    const it = ask.label(text, where, arrow);
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
    label(v.name, () => (arrow.tip && inWorld(parent, arrow.tip)), colour, true);
    return arrow;
  });
  const triad = (parent, length, colour, names) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((v, i) => {
    bar(parent, look(colour), 0.012, 0.09).reach(v, length);
    label(names[i], () => (parent.visible ? inWorld(parent, v.map((x) => x * (length + 0.07))) : null), colour);
  });
  triad(body, 1.0, "edge", ["x", "y", "z"]);
  if (flown.position) triad(local, 1.25, "desired", ["X forward", "Y", "Z down"]);
  const AXES = ["#7d5ba6", "#e69f00", "#009e73", "#d55e00"], kinds = [...new Set(data.axes.map((axis) => axis.kind))];
  for (const { name, kind, direction } of data.axes) { // they show outside the body, at both ends
    const p = look(AXES[kinds.indexOf(kind) % AXES.length]);
    for (const side of [1, -1]) bar(body, p, 0.035, 0).reach(direction.map((v) => side * v), 0.66);
    label(name, () => (ask.wide() ? inWorld(body, direction.map((v) => 0.74 * v)) : null), "axis");
  }

  // The Earth and the orbit; 1 is the radius of the Earth.
  const EARTH = 6378137, SPIN = 7.2921158553e-5; // m, rad/s
  const space = new Transform(), sky = group(space);
  let globe = null, craft = null, map = null, lines = null;
  const path = (m) => { // what is flown, and the whole orbit
    const points = Array.from({ length: m.n }, (_, i) => m.sample(i).map((v) => v / EARTH));
    const r = points[0], b = cross(unit(cross(r, points[Math.min(m.n - 1, 1)])), r);
    return [points, Array.from({ length: 181 }, (_, i) => r.map((v, k) => v * Math.cos((i * Math.PI) / 90) + b[k] * Math.sin((i * Math.PI) / 90)))];
  };
  if (flown.position) {
    globe = group(sky);
    const tilt = group(globe); // OGL's sphere has its poles on Y
    tilt.rotation.x = Math.PI / 2;
    map = new Texture(gl, { generateMipmaps: false, minFilter: gl.LINEAR, wrapS: gl.REPEAT });
    const earth = new Program(gl, { vertex: SHADED.vertex, fragment: GLOBE, uniforms: { map: { value: map }, light, lit: { value: flown.sun ? 1 : 0 } } });
    add(tilt, new Sphere(gl, { radius: 1, widthSegments: 64, heightSegments: 40 }), { program: earth });
    lines = path(flown).map((points) => geometry(points));
    add(sky, lines[0], look("orbit", { flat: 1 }), gl.LINE_STRIP);
    add(sky, lines[1], look("axis", { flat: 1, alpha: 0.6 }), gl.LINE_STRIP);
    craft = add(group(sky), new Sphere(gl, { radius: 0.06 }), look("orbit", { flat: 1 }));
  }
  function renew(m) { // another flight over the same instants
    if (!lines) return;
    path(m).forEach((points, i) => {
      const { position } = lines[i].attributes;
      position.data.set(points.flat());
      position.needsUpdate = true;
    });
  }
  function chart(ink) { // land on the sphere, as a picture of longitude and latitude
    const it = new OffscreenCanvas(1024, 512), c = it.getContext("2d", { willReadFrequently: true }); // it is read as a texture
    c.fillStyle = ink.sea;
    c.fillRect(0, 0, 1024, 512);
    if (data.earth !== null) {
      const bytes = Uint8Array.from(atob(coastlines.data), (x) => x.charCodeAt(0)), points = new DataView(bytes.buffer);
      c.fillStyle = ink.land;
      c.strokeStyle = ink.coast;
      c.lineWidth = 1.5;
      let at = 0;
      for (const length of coastlines.rings) { // outlines cross 180 deg: their longitudes go on there, and each is drawn three times
        const ring = [];
        for (let i = 0, lon = 0; i < length; i++, at += 4) {
          const own = points.getInt16(at, true) / 100;
          lon = i ? own + 360 * Math.round((lon - own) / 360) : own;
          ring.push([lon, points.getInt16(at + 2, true) / 100]);
        }
        const [from, to] = [ring[0][0], ring[length - 1][0]];
        const round = Math.abs(to - from) > 180; // Antarctica goes round the pole
        for (const turn of [-360, 0, 360]) {
          const line = ([lon, lat]) => c.lineTo(((lon + turn) / 360 + 0.5) * 1024, (0.5 - lat / 180) * 512);
          c.beginPath();
          ring.forEach(line);
          if (!round) c.closePath();
          c.stroke();
          if (round) [[to, -90], [from, -90]].forEach(line);
          c.fill();
        }
      }
    }
    map.image = it;
    map.needsUpdate = true;
  }
  function paint(theme) {
    for (const p of painted) p(INK[theme]);
    if (map) chart(INK[theme]);
  }
  function orbit(r, t) { // the Earth and the body over it, r in m
    globe.quaternion.copy(new Quat().fromAxisAngle(new Vec3(0, 0, 1), (data.earth || 0) + SPIN * t));
    craft.position.set(...r.map((v) => v / EARTH));
    return size(r) / EARTH;
  }
  return { near, world, body, local, ghosts, arrows, space, sky, light, paint, renew, orbit };
};
