"use strict";
// The Earth as it is seen from the orbit or from afar, with the orbit, the track below it, field lines, Sun and stations.
// 1 is the radius of a spherical Earth; `turned` are the axes that a point is given in, of the frame that is looked at.
const globe = (gl, { data, coastlines, slow }, flown, { look, add, group, geometry, label, light, painted, rgb }) => {
  const { Geometry, Mesh, Program, Quat, Sphere, Texture, Transform, Vec3 } = ogl;
  const { cross, size, toward, unit } = motion;
  const EARTH = 6378137, SPIN = 7.2921158553e-5; // m, rad/s
  const POLE = [80.7, -72.7]; // of the geomagnetic dipole of 2020, deg north and east (IGRF-13)
  const rad = Math.PI / 180, at = ([north, east], r = 1) => [Math.cos(north * rad) * Math.cos(east * rad), Math.cos(north * rad) * Math.sin(east * rad), Math.sin(north * rad)].map((v) => r * v);
  const eye = { value: new Vec3() }, now = { value: 0 };

  // Disc and ring in the plane of the limb, so it is round at any distance; each point of the disc is a ray to the ground.
  // Where a processor draws, inverse functions are dear: the map's height is the sine of the latitude, `east` a polynomial
  // (Abramowitz and Stegun 4.4.48, within 0.001 deg).
  const map = new Texture(gl, { generateMipmaps: false, minFilter: gl.LINEAR, wrapS: gl.REPEAT });
  const air0 = { value: [0, 0, 0] }, fixed = { value: new Float32Array(9) }, night = { value: 0.2 }, outer = { value: 1 }, lit = { value: flown.sun ? 1 : 0 };
  const limb = (fragment, transparent) => new Program(gl, { depthTest: false, depthWrite: false, cullFace: false, transparent,
    uniforms: { map: { value: map }, eye, light, lit, turn: fixed, air0, night, outer },
    vertex: `attribute vec3 position; uniform mat4 modelMatrix, viewMatrix, projectionMatrix; uniform float outer; varying vec3 p;
      void main() { vec4 q = modelMatrix * vec4(position.xy * mix(1.0, outer, position.z), 0.0, 1.0); p = q.xyz; gl_Position = projectionMatrix * viewMatrix * q; }`,
    fragment: `precision highp float; uniform sampler2D map; uniform vec3 eye, light, air0; uniform mat3 turn; uniform float lit, night; varying vec3 p;
      vec3 air(float d) { return mix(air0, vec3(1.0), 0.25 * d); }
      float day(vec3 n, float from, float to) { return mix(1.0, smoothstep(from, to, dot(n, light)), lit); }
      float east(vec2 q) { // turns
        vec2 a = abs(q);
        float t = min(a.x, a.y) / max(a.x, a.y), s = t * t;
        float r = t * (0.1591336 + s * (-0.0525688 + s * (0.0286703 + s * (-0.0135493 + s * 0.0033160))));
        if (a.y > a.x) r = 0.25 - r;
        if (q.x < 0.0) r = 0.5 - r;
        return q.y < 0.0 ? -r : r;
      }
      void main() {
        vec3 d = normalize(p - eye);
        float b = dot(eye, d), c = dot(eye, eye);
        ${fragment}
      }` });
  const face = limb(`vec3 n = eye - (b + sqrt(max(b * b - c + 1.0, 0.0))) * d, q = turn * n;
        vec3 own = texture2D(map, vec2(east(q.xy) + 0.5, 0.5 + 0.5 * q.z)).rgb;
        float sun = day(n, -0.1, 0.12), up = 1.0 + dot(n, d), haze = up * up * up * up * up;
        gl_FragColor = vec4(mix(own, air(sun), 0.65 * haze) * mix(night, 1.0, sun), 1.0);`, false);
  const rim = limb(`float far = sqrt(max(c - b * b, 0.0)) - 1.0, sun = day(normalize(eye - b * d), -0.25, 0.15), a = exp(-far / 0.009) * (0.1 + 0.75 * sun);
        gl_FragColor = vec4(air(sun) * a, a);`, true); // beside it, brighter by day
  const space = new Transform(), sky = group(space), ground = group(sky), limbs = group(space);
  const AROUND = Array.from({ length: 257 }, (_, i) => [Math.cos((i * Math.PI) / 128), Math.sin((i * Math.PI) / 128)]);
  const around = (corners) => new Geometry(gl, { position: { size: 3, data: new Float32Array(AROUND.flatMap(corners).flat()) } });
  for (const [program, corners] of [[face, (a) => [[0, 0, 0], [...a, 0]]], [rim, (a) => [[...a, 0], [...a, 1]]]]) {
    const made = new Mesh(gl, { geometry: around(corners), program, mode: gl.TRIANGLE_STRIP, frustumCulled: false });
    made.renderOrder = -1;
    made.setParent(limbs);
  }

  // Lines and marks behind the Earth are not drawn; what lies in its shadow is dim.
  const drawn = (fades) => new Program(gl, { transparent: true, depthTest: false, depthWrite: false,
    uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: 1 }, eye, light, now, lit },
    vertex: `attribute vec3 position, normal; uniform mat4 modelMatrix, viewMatrix, projectionMatrix; varying vec3 p; varying float age;
      void main() { vec4 q = modelMatrix * vec4(position, 1.0); p = q.xyz; age = normal.x; gl_Position = projectionMatrix * viewMatrix * q; }`,
    fragment: `precision highp float; uniform vec3 colour, eye, light; uniform float alpha, now, lit; varying vec3 p; varying float age;
      void main() {
        vec3 d = normalize(p - eye);
        float b = dot(eye, d), h = b * b - dot(eye, eye) + 0.998;
        if (h > 0.0 && b < 0.0 && -b - sqrt(h) < length(p - eye) - 0.001) discard;
        float s = dot(p, light), a = alpha;
        if (lit > 0.0 && s < 0.0 && length(p - s * light) < 1.0) a *= 0.4;
        ${fades ? "if (age > now) discard; a *= 0.35 + 0.65 * exp((age - now) / 0.5);" : ""}
        gl_FragColor = vec4(colour * a, a);
      }` });
  const programs = [false, true].map(drawn);
  function put(parent, shape, colour, { program = programs[0], alpha = 1, mode } = {}) {
    const made = add(parent, shape, { program }, mode);
    let own = [0, 0, 0];
    painted.push((ink) => { own = rgb(ink[colour] || colour); });
    made.onBeforeRender(() => { [program.uniforms.colour.value, program.uniforms.alpha.value] = [own, alpha]; });
    return made;
  }
  const line = (parent, points, colour, alpha, ages = null, mode = gl.LINE_STRIP) =>
    put(parent, geometry(points, ages?.map((age) => [age, 0, 0])), colour, { program: programs[Number(Boolean(ages))], alpha, mode });
  const move = (made, points) => {
    const { position } = made.geometry.attributes;
    position.data.set(points.flat());
    position.needsUpdate = true;
  };

  // ---------------------------------------------------------------- orbit, track, field

  const angle = (t) => (data.earth || 0) + SPIN * t;
  const spun = ([x, y, z], a) => [x * Math.cos(a) + y * Math.sin(a), y * Math.cos(a) - x * Math.sin(a), z];
  const MOST = Math.min(flown.n, 2000);
  function path(m) { // what is flown, the track below it and the whole orbit
    const points = Array.from({ length: MOST }, (_, i) => m.sample(Math.min(i, m.n - 1)).map((v) => v / EARTH));
    const r = points[0], b = cross(unit(cross(r, points[Math.min(m.n - 1, 1)])), r);
    const track = points.map((p, i) => unit(spun(p, angle(m.times[Math.min(i, m.n - 1)]))).map((v) => 1.002 * v));
    return [points, track, Array.from({ length: 181 }, (_, i) => r.map((v, k) => v * Math.cos((i * Math.PI) / 90) + b[k] * Math.sin((i * Math.PI) / 90)))];
  }
  const paths = path(flown), period = 2 * Math.PI * Math.sqrt((size(paths[0][0]) * EARTH) ** 3 / 3.986004418e14); // s
  const ages = Array.from({ length: MOST }, (_, i) => flown.times[i] / period);
  const lines = [line(sky, paths[0], "orbit", 1, ages), line(ground, paths[1], "orbit", 0.8, ages), line(sky, paths[2], "axis", 0.45)];
  function renew(m) { path(m).forEach((points, i) => move(lines[i], points)); }

  const FIELD = [-24, -12, 0, 12, 24], NODES = 49, field = group(ground);
  const bundle = FIELD.map(() => line(field, Array(NODES).fill([0, 0, 0]), "#0072b2", 0.75));
  const axis = at(POLE);
  function magnetic(r) { // lines of the dipole through the satellite's height, r in the Earth's axes
    const up = axis, out = unit(r.map((v, k) => v - up[k] * r.reduce((s, w, j) => s + w * up[j], 0))), aside = cross(up, out);
    const sine = unit(r).reduce((s, w, j) => s + w * up[j], 0), shell = size(r) / Math.max(0.05, 1 - sine * sine);
    FIELD.forEach((turn, n) => {
      const c = Math.cos(turn * rad), s = Math.sin(turn * rad), radial = out.map((v, k) => c * v + s * aside[k]);
      const end = Math.acos(Math.sqrt(Math.min(1, 0.99 / shell)));
      move(bundle[n], Array.from({ length: NODES }, (_, i) => {
        const l = end * ((2 * i) / (NODES - 1) - 1), far = shell * Math.cos(l) ** 2;
        return radial.map((v, k) => far * (Math.cos(l) * v + Math.sin(l) * up[k]));
      }));
    });
  }

  // ---------------------------------------------------------------- Sun and stations

  const sun = group(space), FAR = 60;
  let sunward = null;
  if (flown.sun) {
    put(sun, new Sphere(gl, { radius: 0.9 }), "#ffc726");
    label("Sun", () => sunward && sunward.map((v) => FAR * v), "#b07a00", { far: true });
  }
  const world = new Vec3();
  for (const { name, latitude, longitude, elevation } of data.stations) {
    const place = [latitude / rad, longitude / rad], here = at(place, 1.003), r = size(paths[0][0]);
    const wide = Math.acos(Math.cos(elevation) / r) - elevation; // from the Earth's centre, to where the satellite rises
    const north = at([place[0] + 90, place[1]]), east = cross(north, at(place));
    const ring = Array.from({ length: 73 }, (_, i) => unit(at(place)).map((v, k) => r * (Math.cos(wide) * v + Math.sin(wide) * (Math.cos((i * Math.PI) / 36) * north[k] + Math.sin((i * Math.PI) / 36) * east[k]))));
    line(ground, ring, "desired", 0.9);
    line(ground, ring.filter((_, i) => i % 6 === 0).flatMap((p) => [here, p]), "desired", 0.4, null, gl.LINES);
    put(ground, new Sphere(gl, { radius: 0.012 }), "desired").position.set(...here);
    label(name, () => {
      world.set(...here).applyMatrix4(ground.worldMatrix);
      return hidden([...world]) ? null : [...world];
    }, "desired", { far: true });
  }
  function hidden(p) { // whether the Earth stands before a point
    const from = [...eye.value], d = unit(p.map((v, i) => v - from[i])), b = from.reduce((s, v, i) => s + v * d[i], 0);
    const h = b * b - size(from) ** 2 + 0.998;
    return h > 0 && b < 0 && -b - Math.sqrt(h) < size(p.map((v, i) => v - from[i])) - 0.01;
  }

  // ---------------------------------------------------------------- the map

  const row = (latitude, high) => (0.5 - Math.sin(latitude * rad) / 2) * high;
  function paint(ink) { // land, as a picture of longitude and the sine of latitude
    const W = slow ? 1024 : 2048, H = W / 2, it = new OffscreenCanvas(W, H), c = it.getContext("2d", { willReadFrequently: true }); // it is read as a texture
    c.fillStyle = ink.sea;
    c.fillRect(0, 0, W, H);
    if (data.earth !== null) {
      const bytes = Uint8Array.from(atob(coastlines.data), (x) => x.charCodeAt(0)), points = new DataView(bytes.buffer);
      c.strokeStyle = `color-mix(in srgb, ${ink.coast} 35%, ${ink.sea})`;
      c.lineWidth = 1;
      for (let a = 30; a < 360; a += 30) c.strokeRect(-5, -5, (a / 360) * W + 5, H + 10);
      for (let a = -60; a < 90; a += 30) c.strokeRect(-5, -5, W + 10, row(a, H) + 5);
      c.fillStyle = ink.land;
      c.strokeStyle = ink.coast;
      c.lineWidth = W / 820;
      let place = 0;
      for (const length of coastlines.rings) { // outlines cross 180 deg: their longitudes go on there, and each is drawn three times
        const ring = [];
        for (let i = 0, lon = 0; i < length; i++, place += 4) {
          const own = points.getInt16(place, true) / 100;
          lon = i ? own + 360 * Math.round((lon - own) / 360) : own;
          ring.push([lon, points.getInt16(place + 2, true) / 100]);
        }
        const [from, to] = [ring[0][0], ring[length - 1][0]];
        const round = Math.abs(to - from) > 180; // Antarctica goes round the pole
        for (const turn of [-360, 0, 360]) {
          const corner = ([lon, lat]) => c.lineTo(((lon + turn) / 360 + 0.5) * W, row(lat, H));
          c.beginPath();
          ring.forEach(corner);
          if (!round) c.closePath();
          c.stroke();
          if (round) [[to, -90], [from, -90]].forEach(corner);
          c.fill();
        }
      }
    }
    map.image = it;
    map.needsUpdate = true;
    air0.value = rgb(ink.air);
    night.value = ink.night;
  }

  const turn = new Quat(), back = new Quat(), v = new Vec3();
  // The instant, the satellite's position (m, inertial), the rotation to the frame that is seen, and the Sun there.
  function set(t, r, base, sunAxis) {
    sky.quaternion.copy(base);
    ground.quaternion.copy(turn.fromAxisAngle(new Vec3(0, 0, 1), angle(t)));
    now.value = t / period;
    if (field.visible) magnetic(spun(r.map((x) => x / EARTH), angle(t)));
    sunward = sunAxis;
    if (sunAxis) sun.position.set(...sunAxis.map((x) => FAR * x));
    const here = [...v.set(...r.map((x) => x / EARTH)).applyQuaternion(base)], s = sunAxis ? here.reduce((sum, x, i) => sum + x * sunAxis[i], 0) : 1;
    return { here, shadow: s < 0 && size(here.map((x, i) => x - s * sunAxis[i])) < 1 };
  }
  function see(from, base) { // before each picture
    const far = size(from), way = unit(from), edge = Math.asin(Math.min(0.98, 1.048 / far)); // to where the air ends
    eye.value.set(...from);
    limbs.position.set(...way.map((x) => x / far));
    limbs.quaternion.copy(toward([0, 0, 1], way));
    limbs.scale.set(Math.sqrt(1 - 1 / far ** 2));
    outer.value = ((far - 1 / far) * Math.tan(edge)) / limbs.scale[0];
    back.copy(base).multiply(turn).inverse(); // from the frame to the Earth's axes
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((e, i) => fixed.value.set([...v.set(...e).applyQuaternion(back)], 3 * i));
  }
  return { space, paint, renew, set, see, hidden, field, spin: angle };
};
