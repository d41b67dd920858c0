"use strict";
// Draws the three-dimensional view of a page: the body with its vectors, and in a corner the Earth with the orbit.
// Both are seen by one camera, in one frame, so that a direction is the same in both. One scene, so one file.
(() => {
  const root = document.querySelector(".view");
  if (!root) return;
  const { Camera, Cylinder, Geometry, Mesh, Program, Quat, Renderer, Sphere, Texture, Transform, Vec3 } = ogl;
  const { page, array, figures } = timeline, data = page.view;
  const part = (name) => root.querySelector(`[data-part="${name}"]`);
  const stage = part("stage"), canvas = part("canvas"), slider = part("slider"), play = part("play");
  const dark = matchMedia("(prefers-color-scheme: dark)"), calm = matchMedia("(prefers-reduced-motion: reduce)");
  const INK = { light: { body: [0.82, 0.84, 0.87], panel: [0.16, 0.25, 0.5], edge: "#1b1f24", axis: "#59636e", ghost: "#0a6b3d", orbit: "#b4540a", sea: "#c9dcec", land: "#8aa37c", coast: "#4c5f45" },
    dark: { body: [0.62, 0.65, 0.7], panel: [0.2, 0.33, 0.62], edge: "#e4e7eb", axis: "#9aa4af", ghost: "#6fd39b", orbit: "#f2a050", sea: "#1d3a56", land: "#4d6b48", coast: "#8fae86" } };
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8a5cd6", "#999999", "#b5651d", "#3aa6a0"];
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);

  // ---------------------------------------------------------------- the motion between samples

  const rows = (place, width) => {
    if (place == null) return null;
    const flat = array(place);
    return (i) => flat.slice(i * width, (i + 1) * width);
  };
  const time = array(data.time), n = time.length;
  const quaternions = (place) => (typeof place === "number" ? rows(place, 4) : null);
  const attitude = quaternions(data.attitude), desired = quaternions(data.desired), sun = rows(data.sun, 3), position = rows(data.position, 3);
  const vectors = data.vectors.filter((v) => v.largest > 0).map((v, i) => ({ ...v, rows: rows(v.values, 3), colour: COLOURS[i % COLOURS.length] }));
  function bracket(t) { // the sample before an instant, and the share of the way to the next one
    let low = 0, high = n - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (time[middle] <= t) low = middle;
      else high = middle;
    }
    return [low, Math.min(1, Math.max(0, (t - time[low]) / (time[high] - time[low])))];
  }
  const mixed = (f, [i, s]) => f(i).map((v, k) => v + s * (f(i + 1)[k] - v));
  function turned(f, [i, s]) { // the attitude as OGL's quaternion; null where there is none
    const [a, b] = [f(i), f(i + 1)].map(([w, x, y, z]) => new Quat(x, y, z, w));
    if (!a.some((v) => v) || !b.some((v) => v)) return null;
    return a.slerp(b, s).normalize();
  }
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const size = (v) => Math.hypot(...v);
  const unit = (v) => v.map((x) => x / (size(v) || 1));
  function fromAxes(x, y, z) { // the quaternion of the rotation with these columns
    const t = 1 + x[0] + y[1] + z[2];
    const q = t > 0.01 ? [y[2] - z[1], z[0] - x[2], x[1] - y[0], t]
      : x[0] > y[1] && x[0] > z[2] ? [1 + x[0] - y[1] - z[2], x[1] + y[0], z[0] + x[2], y[2] - z[1]]
        : y[1] > z[2] ? [x[1] + y[0], 1 - x[0] + y[1] - z[2], y[2] + z[1], z[0] - x[2]]
          : [z[0] + x[2], y[2] + z[1], 1 - x[0] - y[1] + z[2], x[1] - y[0]];
    return new Quat(...q).normalize();
  }
  function lvlh([i, s]) { // Z to the centre, Y against the orbit's normal
    const r = mixed(position, [i, s]), z = unit(r.map((v) => -v)), y = unit(cross(position(i + 1), position(i)));
    return fromAxes(cross(y, z), y, z);
  }
  const rotated = (v, q) => [...new Vec3(...v).applyQuaternion(q)];

  // ---------------------------------------------------------------- what is drawn

  let renderer;
  try {
    renderer = new Renderer({ canvas, alpha: true, antialias: true, preserveDrawingBuffer: true, dpr: Math.min(2, window.devicePixelRatio || 1), autoClear: false });
  } catch (error) {
    stage.textContent = "This browser has no WebGL, which the three-dimensional view needs; the plots show the same motion.";
    return;
  }
  const { gl } = renderer;
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
  function program(colour, { alpha = 1, flat = 0, cull = gl.BACK } = {}) {
    const made = new Program(gl, { ...SHADED, cullFace: cull, transparent: alpha < 1, depthWrite: alpha === 1,
      uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: alpha }, flatness: { value: flat }, light } });
    painted.push((ink) => { const c = ink[colour] || colour; made.uniforms.colour.value = typeof c === "string" ? rgb(c) : c; });
    return made;
  }
  const geometry = (points, normals) => new Geometry(gl, { position: { size: 3, data: new Float32Array(points.flat()) }, normal: { size: 3, data: new Float32Array((normals || points).flat()) } });
  function add(parent, form, look, mode) {
    const made = new Mesh(gl, { geometry: form, program: look, mode, frustumCulled: false });
    made.setParent(parent);
    return made;
  }
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
    return { faces, normals, edges };
  }
  const shape = prism(data.body);
  const scene = new Transform(), world = group(scene); // world: inertial axes in the chosen frame
  const body = group(world), ghost = group(world), local = group(world);
  for (const kind of ["body", "panel"]) add(body, geometry(shape.faces[kind], shape.normals[kind]), program(kind));
  add(body, geometry(shape.edges), program("edge", { flat: 1 }), gl.LINES);
  for (const kind of ["body", "panel"]) add(ghost, geometry(shape.faces[kind], shape.normals[kind]), program("ghost", { alpha: 0.13 }));
  add(ghost, geometry(shape.edges), program("ghost", { flat: 1 }), gl.LINES);

  const rod = new Cylinder(gl, { radiusTop: 0.5, radiusBottom: 0.5, height: 1, radialSegments: 12 });
  const cone = new Cylinder(gl, { radiusTop: 0, radiusBottom: 0.5, height: 1, radialSegments: 16 });
  const up = new Vec3(0, 1, 0);
  function bar(parent, p, thick, head) { // along its own Y from the origin; `reach` turns and stretches it
    const it = group(parent), shaft = add(it, rod, p), tip = head ? add(it, cone, p) : null;
    it.reach = (v, length = size(v)) => {
      it.visible = length > 0.02;
      if (!it.visible) return;
      const d = unit(v), a = cross([...up], d), w = 1 + d[1];
      it.quaternion.copy(w < 1e-6 ? new Quat(1, 0, 0, 0) : new Quat(...a, w).normalize());
      const end = tip ? Math.min(head, 0.6 * length) : 0;
      shaft.scale.set(thick, length - end, thick);
      shaft.position.set(0, (length - end) / 2, 0);
      if (tip) { tip.scale.set(2.6 * thick, end, 2.6 * thick); tip.position.set(0, length - end / 2, 0); }
    };
    return it;
  }
  const labels = [];
  function label(text, where, colour) { // where() gives a point of the scene, or null
    const it = document.createElement("span");
    it.textContent = text;
    it.className = "tag";
    stage.append(it);
    labels.push({ it, where });
    if (colour) painted.push((ink) => { it.style.color = ink[colour] || colour; });
  }
  const inWorld = (parent, v) => [...new Vec3(...v).applyMatrix4(parent.worldMatrix)];
  const AXES = ["#7d5ba6", "#e69f00", "#009e73", "#d55e00"], kinds = [...new Set(data.axes.map((axis) => axis.kind))];
  for (const { name, kind, direction } of data.axes) { // they show outside the body, at both ends
    const look = program(AXES[kinds.indexOf(kind) % AXES.length]);
    for (const side of [1, -1]) bar(body, look, 0.035, 0).reach(direction.map((v) => side * v), 0.66);
    label(name, () => (stage.clientWidth > 480 ? inWorld(body, direction.map((v) => 0.74 * v)) : null), "axis");
  }
  const triad = (parent, length, colour, names) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((v, i) => {
    bar(parent, program(colour), 0.012, 0.09).reach(v, length);
    label(names[i], () => (parent.visible ? inWorld(parent, v.map((x) => x * (length + 0.07))) : null), colour);
  });
  triad(body, 1.0, "edge", ["x", "y", "z"]);
  if (position) triad(local, 1.25, "ghost", ["X forward", "Y", "Z down"]);
  const arrows = vectors.map((v) => {
    const parent = v.frame === "body" ? body : world, it = bar(parent, program(v.colour, { flat: 0.6 }), 0.03, 0.13);
    const arrow = { ...v, it, on: v.shown, tip: null };
    label(v.name, () => (arrow.on && it.visible && arrow.tip ? inWorld(parent, arrow.tip) : null), v.colour);
    return arrow;
  });

  // The Earth and the orbit; 1 is the radius of the Earth.
  const EARTH = 6378137, SPIN = 7.2921158553e-5; // m, rad/s
  const space = new Transform(), sky = group(space);
  let globe = null, craft = null, map = null;
  if (position) {
    globe = group(sky);
    const tilt = group(globe); // OGL's sphere has its poles on Y
    tilt.rotation.x = Math.PI / 2;
    map = new Texture(gl, { generateMipmaps: false, minFilter: gl.LINEAR, wrapS: gl.REPEAT });
    add(tilt, new Sphere(gl, { radius: 1, widthSegments: 64, heightSegments: 40 }), new Program(gl, { vertex: SHADED.vertex, fragment: GLOBE, uniforms: { map: { value: map }, light, lit: { value: sun ? 1 : 0 } } }));
    const flown = Array.from({ length: n }, (_, i) => position(i).map((v) => v / EARTH));
    add(sky, geometry(flown), program("orbit", { flat: 1 }), gl.LINE_STRIP);
    const r = flown[0], normal = cross(r, flown[Math.min(n - 1, 1)]), b = cross(unit(normal), r);
    add(sky, geometry(Array.from({ length: 181 }, (_, i) => r.map((v, k) => v * Math.cos((i * Math.PI) / 90) + b[k] * Math.sin((i * Math.PI) / 90)))), program("axis", { flat: 1, alpha: 0.6 }), gl.LINE_STRIP);
    craft = add(group(sky), new Sphere(gl, { radius: 0.06 }), program("orbit", { flat: 1 }));
  }
  function chart(ink) { // land on the sphere, as a picture of longitude and latitude
    const it = new OffscreenCanvas(1024, 512), c = it.getContext("2d");
    c.fillStyle = ink.sea;
    c.fillRect(0, 0, 1024, 512);
    if (data.earth !== null && page.coastlines) {
      const bytes = Uint8Array.from(atob(page.coastlines.data), (x) => x.charCodeAt(0)), points = new DataView(bytes.buffer);
      c.fillStyle = ink.land;
      c.strokeStyle = ink.coast;
      c.lineWidth = 1.5;
      let at = 0;
      for (const length of page.coastlines.rings) { // outlines cross 180 deg: their longitudes go on there, and each is drawn three times
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

  // ---------------------------------------------------------------- camera and frame

  const camera = new Camera(gl, { fov: 32, near: 0.1, far: 100 });
  let azimuth = 0.7, height = 0.45, distance = 5, frame = position ? "orbit" : "inertial", now = time[0], printing = false, queued = false, drawnFrames = 0;
  function place(far) {
    const c = Math.cos(height), [x, y, z] = [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(height)].map((v) => far * v);
    // In the orbit's frame up is away from the Earth: its Z points down.
    camera.up.set(0, 0, frame === "orbit" ? -1 : 1);
    camera.position.set(x, frame === "orbit" ? -y : y, frame === "orbit" ? -z : z);
    camera.lookAt([0, 0, 0]);
  }
  const ink = () => (dark.matches && !printing ? INK.dark : INK.light);
  function paint() {
    const colours = ink();
    for (const p of painted) p(colours);
    if (map) chart(colours);
    draw();
  }
  function resize() {
    const wide = stage.clientWidth, high = stage.clientHeight;
    if (!wide || !high) return;
    renderer.setSize(wide, high);
    draw();
  }
  function draw() {
    if (queued) return;
    queued = true;
    requestAnimationFrame(() => { queued = false; render(); });
  }
  function render() {
    const at = bracket(now), wide = stage.clientWidth, high = stage.clientHeight;
    const q = turned(attitude, at), l = position ? lvlh(at) : null, d = desired ? turned(desired, at) : data.desired === "lvlh" ? l : null;
    body.visible = Boolean(q);
    ghost.visible = Boolean(d) && part("ghost").checked;
    if (q) body.quaternion.copy(q);
    if (d) ghost.quaternion.copy(d);
    local.visible = Boolean(l) && part("lvlh").checked;
    if (l) local.quaternion.copy(l);
    const base = frame === "orbit" && l ? new Quat(...l).inverse() : frame === "body" && q ? new Quat(...q).inverse() : new Quat();
    world.quaternion.copy(base);
    sky.quaternion.copy(base);
    const values = [];
    for (const arrow of arrows) {
      const v = mixed(arrow.rows, at), share = size(v) / arrow.largest;
      values.push(`${figures(size(v), 3)} ${arrow.unit}`.trim());
      arrow.length = arrow.on ? 1.3 * Math.sqrt(share) : 0;
      arrow.it.reach(v, arrow.length);
      arrow.tip = unit(v).map((x) => x * (arrow.length + 0.08));
    }
    const s = sun ? unit(rotated(mixed(sun, at), base)) : null;
    gl.clearColor(0, 0, 0, 0);
    gl.disable(gl.SCISSOR_TEST);
    renderer.setDepthMask(true); // else the depth is not cleared
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    camera.perspective({ aspect: wide / high });
    place(distance * Math.max(1, 1.15 * high / wide));
    light.value.set(...(s || unit([...camera.position])));
    renderer.width = wide;
    renderer.height = high;
    renderer.render({ scene, camera });
    tags(wide, high);
    if (position) {
      const inset = Math.round(Math.min(0.36 * wide, 0.42 * high)), r = mixed(position, at).map((v) => v / EARTH);
      globe.quaternion.copy(new Quat().fromAxisAngle(new Vec3(0, 0, 1), (data.earth || 0) + SPIN * now));
      craft.position.set(...r);
      camera.perspective({ aspect: 1 });
      place(4.2 * size(r));
      renderer.width = renderer.height = inset;
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(0, 0, inset * renderer.dpr, inset * renderer.dpr);
      renderer.setDepthMask(true);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      renderer.render({ scene: space, camera });
      gl.disable(gl.SCISSOR_TEST);
    }
    words(at, q, d, values);
    root.dataset.frames = ++drawnFrames;
  }
  function tags(wide, high) {
    camera.updateMatrixWorld();
    for (const { it, where } of labels) {
      const at = where();
      it.hidden = !at;
      if (!at) continue;
      const p = new Vec3(...at);
      camera.project(p);
      it.style.transform = `translate(${((p[0] + 1) / 2) * wide}px, ${((1 - p[1]) / 2) * high}px) translate(-50%, -50%)`;
    }
  }
  function words(at, q, d, values) {
    const angle = q && d ? (2 * Math.acos(Math.min(1, Math.abs(q.dot(d)))) * 180) / Math.PI : null;
    const cycles = page.cycle ? `, ${figures(now / page.cycle.period, 3)} ${page.cycle.name}` : "";
    const phase = data.phases.filter((p) => p.colour >= 0 && p.from <= now && now <= p.to).pop();
    const text = `${figures(now, 5)} s${cycles}${phase ? `; ${phase.name}` : ""}${angle === null ? "" : `; ${figures(angle, 3)} deg from the desired attitude`}`;
    part("words").textContent = text;
    slider.value = now;
    slider.setAttribute("aria-valuetext", text);
    arrows.forEach((arrow, i) => { arrow.value.textContent = values[i]; });
    canvas.setAttribute("aria-label", `The body ${data.name} in three dimensions at ${text}`);
  }

  // ---------------------------------------------------------------- controls

  let playing = 0, before = 0, told = 0;
  const first = time[0], last = time[n - 1];
  function go(t, quiet) {
    now = Math.min(last, Math.max(first, t));
    draw();
    if (!quiet) timeline.set(now, follow);
  }
  const follow = (t) => { if (t !== null && !playing) { now = Math.min(last, Math.max(first, t)); draw(); } };
  timeline.followers.push(follow);
  const speed = () => Number(part("speed").value) || (last - first) / 40;
  function step(stamp) {
    if (!playing) return;
    const passed = before ? (stamp - before) / 1000 : 0;
    if (calm.matches && before && passed < 1) { playing = requestAnimationFrame(step); return; } // a picture a second
    before = stamp;
    const next = now + passed * speed(), tell = stamp - told > 60;
    if (tell) told = stamp;
    go(next, !tell);
    if (next >= last) stop();
    else playing = requestAnimationFrame(step);
  }
  function stop() {
    cancelAnimationFrame(playing);
    playing = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }
  function start() {
    if (now >= last) now = first;
    before = 0;
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    playing = requestAnimationFrame(step);
  }
  const toggle = () => (playing ? stop() : start());
  play.addEventListener("click", toggle);
  Object.assign(slider, { min: first, max: last, step: (last - first) / 5000, value: first });
  slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
  part("frame").addEventListener("change", (event) => { frame = event.target.value; draw(); });
  for (const name of ["ghost", "lvlh"]) part(name).addEventListener("change", draw);
  if (!position) { part("lvlh").closest("label").hidden = true; part("frame").querySelector('[value="orbit"]').remove(); }
  if (data.desired == null) part("ghost").closest("label").hidden = true;
  for (const arrow of arrows) {
    const it = document.createElement("label"), box = document.createElement("input"), mark = document.createElement("i");
    box.type = "checkbox";
    box.checked = arrow.on;
    mark.style.background = arrow.colour;
    arrow.value = document.createElement("b");
    it.append(box, mark, `${arrow.name} `, arrow.value);
    box.addEventListener("change", () => { arrow.on = box.checked; draw(); });
    part("vectors").append(it);
  }
  const marks = part("marks"), share = (t) => (100 * (t - first)) / (last - first);
  function mark(from, to, kind, name, colour) {
    const it = document.createElement("span");
    it.className = kind;
    it.style.left = `${share(from)}%`;
    it.style.width = `max(3px, ${share(to) - share(from)}%)`;
    if (colour) it.style.background = colour;
    it.title = `${name}, ${figures(from, 4)} to ${figures(to, 4)} s`;
    if (share(to) - share(from) > 9) it.textContent = name;
    marks.append(it);
  }
  for (const p of data.phases) mark(p.from, p.to, p.colour < 0 ? "held" : "phase", p.name, p.colour < 0 ? "" : ["#56b4e955", "#e69f0055", "#009e7355", "#cc79a755", "#0072b255"][p.colour % 5]);
  for (const [from, to] of page.faults) mark(from, to, "fault", "fault");
  marks.hidden = !marks.children.length;

  const fingers = new Map();
  let apart = 0;
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const from = fingers.get(event.pointerId);
    if (!from) return;
    const to = [event.clientX, event.clientY];
    fingers.set(event.pointerId, to);
    if (fingers.size === 2) {
      const [a, b] = [...fingers.values()], gap = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (apart) nearer(apart / gap);
      apart = gap;
    } else {
      turn((to[0] - from[0]) / 150, (to[1] - from[1]) / 150);
    }
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => { fingers.delete(event.pointerId); apart = 0; });
  function turn(aside, upward) {
    azimuth -= aside;
    height = Math.min(1.5, Math.max(-1.5, height + upward));
    draw();
  }
  function nearer(factor) {
    distance = Math.min(15, Math.max(2, distance * factor));
    draw();
  }
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== canvas) return; // the page scrolls
    event.preventDefault();
    nearer(event.deltaY > 0 ? 1.12 : 0.89);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const keys = { ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1), "+": () => nearer(0.89), "-": () => nearer(1.12), " ": toggle };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  dark.addEventListener("change", paint);
  addEventListener("beforeprint", () => { printing = true; stop(); paint(); render(); });
  addEventListener("afterprint", () => { printing = false; paint(); });
  new ResizeObserver(resize).observe(stage);
  resize();
  paint();
})();
