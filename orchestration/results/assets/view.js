"use strict";
// The three-dimensional view of a page: the camera, what is seen at an instant, and the controls.
// The body and the Earth behind it are seen by one camera, in one frame; the way out leads from the body to the whole Earth.
// Longer than 250 lines: camera, instant and controls work on one scene.
(() => {
  const root = document.querySelector(".view");
  if (!root) return;
  const { Camera, Quat, Renderer, Vec3 } = ogl;
  const { page, array, figures, colour: ofPlots } = timeline, data = page.view;
  const { size, unit, apart } = motion;
  const part = (name) => root.querySelector(`[data-part="${name}"]`);
  const stage = part("stage"), slider = part("slider"), play = part("play");
  const dark = matchMedia("(prefers-color-scheme: dark)"), calm = matchMedia("(prefers-reduced-motion: reduce)");
  let flown = motion.read(data, array), former = data.former ? motion.read(data.former, array) : null; // or the flight before, on a live page

  let canvas = part("canvas"), slow = false, lower = false, renderer, gl, drawn, body, local, ghosts, arrows, light, earth;
  const labels = [];
  // Pixels of the canvas to one of the page. More smooth the edges; fewer where it moves and a processor draws.
  const resolution = () => (lower ? 0.5 : slow ? 1.5 : 2);
  function build() { // all that a context of WebGL holds
    renderer = new Renderer({ canvas, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true, autoClear: false });
    gl = renderer.gl;
    const masked = gl.getParameter(gl.RENDERER), named = masked === "WebKit WebGL" && gl.getExtension("WEBGL_debug_renderer_info");
    slow = /swiftshader|llvmpipe|software|basic render/i.test(named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : masked);
    renderer.dpr = resolution();
    for (const { it } of labels.splice(0)) it.remove();
    const shown = arrows;
    drawn = scene(gl, { data, coastlines: page.coastlines, slow }, flown, {
      wide: () => extent[0] > 480,
      label(text, where, arrow, far) {
        const it = document.createElement("span");
        it.textContent = text;
        it.className = "tag";
        stage.append(it);
        labels.push({ it, where, arrow, far });
        return it;
      },
    });
    ({ body, local, ghosts, arrows, light, earth } = drawn);
    shown?.forEach(({ on, value }, i) => Object.assign(arrows[i], { on, value }));
    canvas.addEventListener("webglcontextlost", renewed, { once: true });
  }
  function renewed() { // the browser took the context away, as it does where its graphics process ends: names without a view
    const fresh = canvas.cloneNode();
    canvas.replaceWith(fresh);
    canvas = fresh;
    build();
    resize();
    paint();
  }
  try {
    build();
  } catch (error) {
    stage.textContent = "This browser has no WebGL, which the three-dimensional view needs; the plots show the same motion.";
    return;
  }

  // ---------------------------------------------------------------- camera and frame

  const camera = new Camera(gl, { fov: 32, near: 0.1, far: 100 });
  const orbiting = Boolean(earth), shown = (name) => part(name).checked;
  const CLOSE = 15, WIDE = 300; // distances: up to here from the body, whose largest extent is 1; from here on of the whole Earth
  let azimuth = 0.7, height = 0.3, distance = 4.2, frame = orbiting ? "orbit" : "inertial", now = flown.first, printing = false, queued = false, drawnFrames = 0;
  let extent = [1, 1]; // of the stage, px: asked for once, since asking lays the page out
  function toward() { // from what is looked at to the camera, in the frame
    const c = Math.cos(height), [x, y, z] = [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(height)];
    return frame === "orbit" ? [x, -y, -z] : [x, y, z]; // its Z points down
  }
  function place(at, way, near, far) {
    Object.assign(camera, { near, far });
    camera.up.set(0, 0, frame === "orbit" ? -1 : 1);
    camera.position.set(...at);
    camera.lookAt(at.map((v, i) => v - way[i]));
    camera.perspective({ aspect: extent[0] / extent[1] });
    camera.updateMatrixWorld();
  }
  function paint() {
    drawn.paint(dark.matches && !printing ? "dark" : "light");
    marked();
    draw();
  }
  const PAPER = [640, 380]; // px
  function resize() {
    extent = printing ? PAPER : [stage.clientWidth, stage.clientHeight];
    const [wide, high] = extent;
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
  let painted = 0; // when, ms
  function render() {
    const at = flown.bracket(now), [wide, high] = extent;
    const q = flown.attitude(at), l = flown.lvlh(at), others = {};
    pose(body, q);
    pose(local, l, shown("lvlh"));
    for (const [name, it] of Object.entries(ghosts)) {
      others[name] = name === "before" ? former && former.attitude(former.bracket(now)) : flown[name](at);
      pose(it, others[name], shown(name));
    }
    const spin = orbiting && frame === "earth" ? new Quat().fromAxisAngle(new Vec3(0, 0, 1), earth.spin(now)) : null;
    const own = frame === "orbit" ? l : frame === "body" ? q : spin, base = own ? new Quat(...own).inverse() : new Quat();
    drawn.world.quaternion.copy(base);
    const vectors = flown.vectors.map(({ at: vector }) => vector(at)), largest = flown.vectors.map((vector) => vector.largest);
    const values = arrows.map((arrow, i) => {
      const v = vectors[i], long = size(v);
      arrow.reach(v, arrow.on && largest[i] ? 1.3 * Math.sqrt(long / largest[i]) : 0);
      return `${figures(long, 3)} ${arrow.unit}`.trim();
    });
    const clock = performance.now();
    drawn.drive(vectors, largest, playing ? Math.min(0.1, (clock - painted) / 1000) : 0);
    painted = clock;
    gl.clearColor(0, 0, 0, 0);
    renderer.setDepthMask(true); // else the depth is not cleared
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    renderer.width = wide;
    renderer.height = high;
    const way = toward(), narrow = Math.max(1, 1.15 * high / wide);
    const sun = flown.sun ? [...new Vec3(...flown.sun(at)).applyQuaternion(base)] : null;
    light.value.set(...unit(sun || way));
    let from = way, beyond = Math.min(distance, CLOSE) * narrow, hidden = false, far = null;
    if (orbiting) {
      const { here, shadow } = earth.set(now, flown.position(at), base, sun), r = size(here);
      const share = Math.max(0, Math.log(distance / CLOSE) / Math.log(WIDE / CLOSE));
      const out = 4.6 * r * narrow * share ** 2;
      let eye = here.map((v, i) => v * (1 - share ** 3) + way[i] * out);
      if (size(eye) < 1.02) eye = unit(eye).map((v) => 1.02 * v);
      far = [eye, way, 0.02, 100];
      place(...far);
      earth.see(eye, base);
      renderer.render({ scene: earth.space, camera });
      renderer.setDepthMask(true);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      drawn.sunlit.value = shadow ? 0.15 : 1;
      if (share > 0) {
        from = unit(eye.map((v, i) => v - here[i]));
        beyond *= 1 + 2.2 * share;
        hidden = earth.hidden(here);
      }
    }
    place(from.map((v) => beyond * v), way, 0.1, 100);
    if (!hidden) renderer.render({ scene: drawn.near, camera });
    tags(wide, high, hidden || beyond > 1.4 * CLOSE, far);
    if (!playing || telling) words(q, others, values);
    telling = false;
    root.dataset.frames = ++drawnFrames;
  }
  const ASIDE = [0, -13, 13, -26, 26].map((d) => [0, d]); // px, where a label would stand on another one
  const BESIDE = [[1, 0], [-1, 0], [1, 13], [-1, 13], [1, -13], [-1, -13]]; // its width and px, where it would stand on an arrow
  function tags(wide, high, hidden, far) { // the body's own names are hidden where it is small
    const taken = [], near = [...camera.position];
    for (const label of labels) {
      label.at = label.far || !hidden ? label.where() : null;
      label.it.hidden = !label.at;
    }

    for (const label of labels) if (label.at) label.half ||= label.it.offsetWidth / 2 + 2;
    const seen = (at) => {
      const p = new Vec3(...at);
      camera.project(p);
      return p;
    };
    const behind = (at) => new Vec3(...at).applyMatrix4(camera.viewMatrix)[2] > -camera.near;
    const points = labels.map((label) => (label.at && !label.far && !behind(label.at) ? seen(label.at) : null));
    if (far) {
      place(...far);
      labels.forEach((label, i) => { if (label.at && label.far && !behind(label.at)) points[i] = seen(label.at); });
      place(near, far[1], 0.1, 100);
    }
    labels.forEach((label, i) => { if (!points[i] || (label.far && Math.max(Math.abs(points[i][0]), Math.abs(points[i][1])) > 1)) label.it.hidden = !(label.at = null); });

    const shafts = labels.filter(({ at, arrow }) => at && arrow).flatMap(({ it, at }) => // the outer parts of arrows
      [0.4, 0.5, 0.6, 0.7, 0.8, 0.9].map((part) => {
        const p = seen(at.map((v) => part * v));
        return { it, x: (wide * (1 + p[0])) / 2, y: (high * (1 - p[1])) / 2 };
      }));
    for (const [i, { it, at, half }] of labels.entries()) {
      if (!at) continue;
      const p = points[i];
      const across = (p[0] * wide) / 2, down = (-p[1] * high) / 2, off = Math.hypot(across, down) || 1; // from the middle, outwards
      const x = Math.min(wide - half, Math.max(half, wide / 2 + across * (1 + half / off))), y = Math.min(high - 9, Math.max(9, high / 2 + down * (1 + 5 / off)));
      const places = [...ASIDE, ...BESIDE].map(([a, b]) => ({ it, x: x + 2 * a * half, y: y + b, half }))
        .filter((p) => p.x >= half - 1e-6 && p.x <= wide - half + 1e-6 && p.y >= 9 && p.y <= high - 9);
      const free = (p) => !taken.some((o) => Math.abs(o.x - p.x) < o.half + half && Math.abs(o.y - p.y) < 12);
      const clear = (p) => !shafts.some((o) => o.it !== it && Math.abs(o.x - p.x) < half + 4 && Math.abs(o.y - p.y) < 9);
      const place = places.find((p) => free(p) && clear(p)) ?? places.find(free);
      it.hidden = !place;
      if (it.hidden) continue;
      taken.push(place);
      const to = `translate(${Math.round(place.x)}px, ${Math.round(place.y)}px) translate(-50%, -50%)`;
      if (labels[i].to !== to) it.style.transform = labels[i].to = to; // what moves less than a pixel costs no layout
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

  // ---------------------------------------------------------------- small multiples

  const named = data.names || ["this flight", "flight before"], INSTANTS = 6, SMALL = 180; // px
  let later = 0;
  function multiples() { // a flight, or two at the same instants, as the camera stands
    clearTimeout(later);
    if (part("both").open) later = setTimeout(compared, 250);
  }
  function compared() {
    if (playing) return; // once it stands
    const kept = [flown, former, now], end = Math.min(flown.last, former?.last ?? Infinity);
    const instants = Array.from({ length: INSTANTS }, (_, i) => first + (i / (INSTANTS - 1)) * (end - first));
    const flights = former ? [[named[0], flown], [named[1], former]] : [["", flown]];
    const cells = flights.flatMap(([name, own]) => [name, ...instants.map((t) => {
      [flown, former, now] = [own, null, t];
      render();
      const cell = document.createElement("div"), small = Object.assign(document.createElement("canvas"), { width: SMALL, height: SMALL });
      const { width, height: high } = canvas, side = Math.min(width, high);
      small.getContext("2d").drawImage(canvas, (width - side) / 2, (high - side) / 2, side, side, 0, 0, SMALL, SMALL);
      small.setAttribute("role", "img");
      small.setAttribute("aria-label", `${name && `${name}: `}${part("words").textContent}`);
      const q = own.attitude(own.bracket(t)), desired = own.desired(own.bracket(t));
      cell.append(small, `${figures(t, 4)} s${q && desired ? `, ${figures(apart(q, desired), 3)} deg off` : ""}`);
      return cell;
    })]);
    [flown, former, now] = kept;
    part("strip").replaceChildren(...cells.filter(Boolean).map((cell) => (cell.append ? cell : Object.assign(document.createElement("b"), { textContent: cell }))));
    render();
  }
  part("both").addEventListener("toggle", multiples);

  // ---------------------------------------------------------------- controls

  let playing = 0, before = 0, told = 0, telling = true; // texts and the plots' cursors follow some times a second
  const { first, last } = flown; // those of the whole run; a part of a flight ends before
  const reached = () => Math.min(last, flown.last);
  function go(t, quiet) {
    now = Math.min(last, Math.max(first, t));
    draw();
    if (!quiet) timeline.set(now, follow);
  }
  timeline.go = (t) => { before = 0; go(t); };
  const follow = (t) => { if (t !== null && !playing) { now = Math.min(last, Math.max(first, t)); draw(); } };
  timeline.followers.push(follow);
  const speed = () => Number(part("speed").value) || (last - first) / 40;
  function step(stamp) {
    if (!playing) return;
    const passed = before ? (stamp - before) / 1000 : 0;
    if (calm.matches && before && passed < 1) { playing = requestAnimationFrame(step); return; } // a picture a second
    before = stamp;
    const next = Math.min(reached(), now + passed * speed()), tell = stamp - told > (slow ? 200 : 60);
    if (tell) [told, telling] = [stamp, true];
    pace(passed);
    go(next, !tell);
    if (next >= last) stop();
    else playing = requestAnimationFrame(step);
  }
  let late = 0;
  function pace(passed) { // fewer pixels where twelve pictures in a row took more than 1/28 s each
    late = passed > 1 / 28 && passed < 0.5 ? late + 1 : Math.max(0, late - 1);
    if (late > 12) sharpen(true);
  }
  function sharpen(low) {
    late = 0;
    if (low === lower) return;
    lower = low;
    renderer.dpr = resolution();
    resize();
  }
  function stop() {
    multiples();
    sharpen(false);
    cancelAnimationFrame(playing);
    playing = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }
  function start() {
    if (now >= last) now = first;
    before = 0;
    sharpen(slow);
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
    part(name).closest("label").hidden = name === "lvlh" ? !orbiting : name === "before" ? !former : data[name] == null;
  }
  part("before").nextSibling.textContent = `${named[1]} (grey)`;
  const strip = () => { part("both").firstChild.textContent = former ? "Both flights side by side" : `The flight at ${INSTANTS} instants`; };
  strip();
  if (!orbiting) for (const name of ["orbit", "earth"]) part("frame").querySelector(`[value=${name}]`).remove();
  part("field").closest("label").hidden = part("camera").closest("label").hidden = !orbiting;
  part("field").addEventListener("change", () => { earth.field.visible = shown("field"); draw(); });
  part("camera").addEventListener("change", (event) => { distance = event.target.value === "far" ? WIDE : 4.2; draw(); });
  for (const [i, arrow] of arrows.entries()) {
    const it = document.createElement("label"), box = document.createElement("input"), mark = document.createElement("i");
    box.type = "checkbox";
    box.checked = arrow.on;
    mark.style.background = arrow.colour;
    arrow.value = document.createElement("b");
    it.append(box, mark, `${arrow.name} `, arrow.value);
    box.addEventListener("change", () => { arrows[i].on = box.checked; draw(); });
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
  marks.addEventListener("click", (event) => { // goes there
    const { left, width } = marks.getBoundingClientRect();
    timeline.go(first + ((event.clientX - left) / width) * (last - first));
  });
  document.addEventListener("before", () => {
    former = flown;
    part("before").closest("label").hidden = false;
    strip();
  });
  document.addEventListener("flown", ({ detail }) => { // a live page has flown again, or a part of it
    flown = motion.read(detail.view, array);
    earth?.renew(flown);
    marked();
    draw();
    multiples();
  });

  const fingers = new Map();
  let reach = 0; // between two fingers
  stage.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    stage.setPointerCapture(event.pointerId);
    sharpen(lower || slow);
  });
  stage.addEventListener("pointermove", (event) => {
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
  for (const name of ["pointerup", "pointercancel"]) stage.addEventListener(name, (event) => {
    fingers.delete(event.pointerId);
    reach = 0;
    if (!playing && !fingers.size) sharpen(false);
    multiples();
  });
  function turn(aside, upward) {
    azimuth -= aside;
    height = Math.min(1.5, Math.max(-1.5, height + upward));
    draw();
  }
  function nearer(factor) {
    distance = Math.min(orbiting ? 1.6 * WIDE : CLOSE, Math.max(2, distance * factor ** (distance > CLOSE ? 2 : 1)));
    if (orbiting) part("camera").value = distance > WIDE / 3 ? "far" : "near";
    draw();
  }
  stage.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== canvas) return; // the page scrolls
    event.preventDefault();
    nearer(event.deltaY > 0 ? 1.12 : 0.89);
  }, { passive: false });
  stage.addEventListener("keydown", (event) => {
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
  if (page.live && !calm.matches) start(); // it moves at once
  resize();
  paint();
})();
