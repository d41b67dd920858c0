"use strict";
// The three-dimensional view of a page: the camera, what is seen at an instant, and the controls.
// The body and the Earth in the corner are seen by one camera, in one frame, so that a direction is the same in both.
// Longer than 250 lines: camera, instant and controls work on one scene.
(() => {
  const root = document.querySelector(".view");
  if (!root) return;
  const { Camera, Quat, Renderer, Vec3 } = ogl;
  const { page, array, figures, colour: ofPlots } = timeline, data = page.view;
  const { size, unit, apart } = motion;
  const part = (name) => root.querySelector(`[data-part="${name}"]`);
  const stage = part("stage"), canvas = part("canvas"), slider = part("slider"), play = part("play");
  const dark = matchMedia("(prefers-color-scheme: dark)"), calm = matchMedia("(prefers-reduced-motion: reduce)");
  let flown = motion.read(data, array);

  let renderer;
  try {
    renderer = new Renderer({ canvas, alpha: true, antialias: true, preserveDrawingBuffer: true, dpr: Math.min(2, window.devicePixelRatio || 1), autoClear: false });
  } catch (error) {
    stage.textContent = "This browser has no WebGL, which the three-dimensional view needs; the plots show the same motion.";
    return;
  }
  const { gl } = renderer;
  const labels = [];
  const drawn = scene(gl, { data, coastlines: page.coastlines }, flown, {
    wide: () => stage.clientWidth > 480,
    label(text, where, arrow) {
      const it = document.createElement("span");
      it.textContent = text;
      it.className = "tag";
      stage.append(it);
      labels.push({ it, where, arrow });
      return it;
    },
  });
  const { body, local, ghosts, arrows, light } = drawn;

  // ---------------------------------------------------------------- camera and frame

  const camera = new Camera(gl, { fov: 32, near: 0.1, far: 100 });
  const orbiting = Boolean(flown.position), shown = (name) => part(name).checked;
  let azimuth = 0.7, height = 0.45, distance = 5, frame = orbiting ? "orbit" : "inertial", now = flown.first, printing = false, queued = false, drawnFrames = 0;
  function place(far) {
    const c = Math.cos(height), [x, y, z] = [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(height)].map((v) => far * v);
    // In the orbit's frame up is away from the Earth: its Z points down.
    camera.up.set(0, 0, frame === "orbit" ? -1 : 1);
    camera.position.set(x, frame === "orbit" ? -y : y, frame === "orbit" ? -z : z);
    camera.lookAt([0, 0, 0]);
  }
  function paint() {
    drawn.paint(dark.matches && !printing ? "dark" : "light");
    marked();
    draw();
  }
  const PAPER = [640, 380]; // px
  const extent = () => (printing ? PAPER : [stage.clientWidth, stage.clientHeight]);
  function resize() {
    const [wide, high] = extent();
    if (!wide || !high) return;
    renderer.setSize(wide, high);
    fit();
    draw();
  }
  function draw() {
    if (queued) return;
    queued = true;
    requestAnimationFrame(() => { queued = false; render(); });
  }
  function pose(it, q, visible = true) {
    it.visible = Boolean(q) && visible;
    if (q) it.quaternion.copy(q);
  }
  function render() {
    const at = flown.bracket(now), [wide, high] = extent();
    const q = flown.attitude(at), l = flown.lvlh(at), others = {};
    pose(body, q);
    pose(local, l, shown("lvlh"));
    for (const [name, it] of Object.entries(ghosts)) pose(it, (others[name] = flown[name](at)), shown(name));
    const own = frame === "orbit" ? l : frame === "body" ? q : null, base = own ? new Quat(...own).inverse() : new Quat();
    drawn.world.quaternion.copy(base);
    drawn.sky.quaternion.copy(base);
    const values = arrows.map((arrow, i) => {
      const { at: vector, largest } = flown.vectors[i], v = vector(at), long = size(v);
      arrow.reach(v, arrow.on && largest ? 1.3 * Math.sqrt(long / largest) : 0);
      return `${figures(long, 3)} ${arrow.unit}`.trim();
    });
    gl.clearColor(0, 0, 0, 0);
    gl.disable(gl.SCISSOR_TEST);
    renderer.setDepthMask(true); // else the depth is not cleared
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    camera.perspective({ aspect: wide / high });
    place(distance * Math.max(1, 1.15 * high / wide));
    light.value.set(...unit(flown.sun ? [...new Vec3(...flown.sun(at)).applyQuaternion(base)] : [...camera.position]));
    renderer.width = wide;
    renderer.height = high;
    renderer.render({ scene: drawn.near, camera });
    tags(wide, high);
    if (orbiting) {
      const inset = Math.round(Math.min(0.36 * wide, 0.42 * high)), radius = drawn.orbit(flown.position(at), now);
      camera.perspective({ aspect: 1 });
      place(4.2 * radius);
      renderer.width = renderer.height = inset;
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(0, 0, inset * renderer.dpr, inset * renderer.dpr);
      renderer.setDepthMask(true);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      renderer.render({ scene: drawn.space, camera });
      gl.disable(gl.SCISSOR_TEST);
    }
    words(q, others, values);
    root.dataset.frames = ++drawnFrames;
  }
  const ASIDE = [0, -13, 13, -26, 26].map((d) => [0, d]); // px, where a label would stand on another one
  const BESIDE = [[1, 0], [-1, 0], [1, 13], [-1, 13], [1, -13], [-1, -13]]; // its width and px, where it would stand on an arrow
  function tags(wide, high) {
    camera.updateMatrixWorld();
    const taken = [];
    for (const label of labels) {
      label.at = label.where();
      label.it.hidden = !label.at;
    }
    for (const label of labels) if (label.at) label.half ||= label.it.offsetWidth / 2 + 2;
    const seen = (at) => {
      const p = new Vec3(...at);
      camera.project(p);
      return p;
    };
    const shafts = labels.filter(({ at, arrow }) => at && arrow).flatMap(({ it, at }) => // the outer parts of arrows
      [0.4, 0.5, 0.6, 0.7, 0.8, 0.9].map((part) => {
        const p = seen(at.map((v) => part * v));
        return { it, x: (wide * (1 + p[0])) / 2, y: (high * (1 - p[1])) / 2 };
      }));
    for (const { it, at, half } of labels) {
      if (!at) continue;
      const p = seen(at);
      const across = (p[0] * wide) / 2, down = (-p[1] * high) / 2, far = Math.hypot(across, down) || 1; // from the middle, outwards
      const x = Math.min(wide - half, Math.max(half, wide / 2 + across * (1 + half / far))), y = high / 2 + down * (1 + 5 / far);
      const places = [...ASIDE, ...BESIDE].map(([a, b]) => ({ it, x: x + 2 * a * half, y: y + b, half }))
        .filter((p) => p.x >= half - 1e-6 && p.x <= wide - half + 1e-6);
      const free = (p) => !taken.some((o) => Math.abs(o.x - p.x) < o.half + half && Math.abs(o.y - p.y) < 12);
      const clear = (p) => !shafts.some((o) => o.it !== it && Math.abs(o.x - p.x) < half + 4 && Math.abs(o.y - p.y) < 9);
      const place = places.find((p) => free(p) && clear(p)) ?? places.find(free);
      it.hidden = !place;
      if (it.hidden) continue;
      taken.push(place);
      it.style.transform = `translate(${place.x}px, ${place.y}px) translate(-50%, -50%)`;
    }
  }
  function words(q, { desired, estimated }, values) {
    const cycles = page.cycle ? `, ${figures(now / page.cycle.period, 3)} ${page.cycle.name}` : "";
    const phase = flown.phases.findLast(([, from, to, colour]) => colour >= 0 && from <= now && now <= to);
    const text = `${figures(now, 5)} s${cycles}${phase ? `; ${phase[0]}` : ""}${q && desired ? `; ${figures(apart(q, desired), 3)} deg from the desired attitude` : ""}${
      q && estimated ? `; estimate ${figures(apart(q, estimated), 3)} deg off` : ""}`;
    part("words").textContent = text;
    slider.value = now;
    slider.setAttribute("aria-valuetext", text);
    arrows.forEach((arrow, i) => { arrow.value.textContent = values[i]; });
    canvas.setAttribute("aria-label", `The body ${data.name} in three dimensions at ${text}`);
  }

  // ---------------------------------------------------------------- controls

  let playing = 0, before = 0, told = 0;
  const { first, last } = flown; // every flight has the same instants
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
  for (const name of ["lvlh", ...Object.keys(ghosts)]) {
    part(name).addEventListener("change", draw);
    part(name).closest("label").hidden = name === "lvlh" ? !orbiting : data[name] == null;
  }
  if (!orbiting) part("frame").querySelector('[value="orbit"]').remove();
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
    if (kind === "phase") it.dataset.name = name;
    marks.append(it);
  }
  function fit() { // a name stands where it has room
    for (const it of marks.querySelectorAll(".phase")) {
      it.textContent = it.dataset.name;
      if (it.scrollWidth > it.clientWidth) it.textContent = "";
    }
  }
  function marked() {
    marks.replaceChildren();
    for (const [name, from, to, colour] of flown.phases) mark(from, to, colour < 0 ? "held" : "phase", name, colour < 0 ? "" : `${ofPlots(colour)}55`);
    for (const [from, to] of page.faults) mark(from, to, "fault", "fault");
    marks.hidden = !marks.children.length;
    fit();
  }
  document.addEventListener("flown", ({ detail }) => { // a live page has flown again
    flown = motion.read(detail.view, array);
    drawn.renew(flown);
    marked();
    draw();
  });

  const fingers = new Map();
  let reach = 0; // between two fingers
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
      if (reach) nearer(reach / gap);
      reach = gap;
    } else {
      turn((to[0] - from[0]) / 150, (to[1] - from[1]) / 150);
    }
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => { fingers.delete(event.pointerId); reach = 0; });
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
  let still = null; // on paper: a picture of this instant
  addEventListener("beforeprint", () => {
    if (printing) return;
    printing = true;
    stop();
    resize();
    paint();
    render();
    still = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height, className: "still" });
    still.getContext("2d").drawImage(canvas, 0, 0);
    stage.prepend(still);
  });
  addEventListener("afterprint", () => {
    printing = false;
    still?.remove();
    resize();
    paint();
  });
  new ResizeObserver(() => { // a new size clears the canvas, so it is drawn at once: the next frame shows it
    if (printing) return;
    resize();
    render();
  }).observe(stage);
  resize();
  paint();
})();
