"use strict";
// The motion of a three-dimensional view at any instant: between its samples attitudes turn on the sphere, all else is linear.
const motion = (() => {
  const { Quat } = ogl;
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
  const oriented = (row) => { // four numbers are a quaternion, scalar first, nine a matrix row by row; zeros are no attitude
    if (!row.some((v) => v)) return null;
    if (row.length === 4) return new Quat(row[1], row[2], row[3], row[0]);
    return fromAxes(...[0, 1, 2].map((k) => [row[k], row[3 + k], row[6 + k]]));
  };

  // Of the data of a page: an array is one that the page has packed, or the numbers themselves.
  function read(data, array) {
    const numbers = (place) => (ArrayBuffer.isView(place) ? place : array(place));
    const time = numbers(data.time), n = time.length;
    const rows = (place) => {
      if (place == null) return null;
      const flat = numbers(place), width = flat.length / n;
      return (i) => Array.from(flat.slice(i * width, (i + 1) * width));
    };
    const mixed = (f) => ([i, s]) => f(i).map((v, k) => v + s * (f(i + 1)[k] - v));
    const position = rows(data.position), sun = rows(data.sun);
    function lvlh([i, s]) { // Z to the centre, Y against the orbit's normal
      const z = unit(mixed(position)([i, s]).map((v) => -v)), y = unit(cross(position(i + 1), position(i)));
      return fromAxes(cross(y, z), y, z);
    }
    function turned(place) {
      if (place == null) return () => null;
      if (place === "lvlh") return position ? lvlh : () => null;
      const f = rows(place);
      return ([i, s]) => {
        const [a, b] = [oriented(f(i)), oriented(f(i + 1))];
        return a && b && a.slerp(b, s).normalize();
      };
    }
    return {
      n, times: time, first: time[0], last: time[n - 1], phases: data.phases, position: position && mixed(position), sample: position,
      sun: sun && mixed(sun), lvlh: position ? lvlh : () => null, attitude: turned(data.attitude),
      desired: turned(data.desired), planned: turned(data.planned), estimated: turned(data.estimated),
      vectors: data.vectors.map((v) => ({ at: mixed(rows(v.values)), largest: v.largest })),
      bracket(t) { // the sample before an instant, and the share of the way to the next one
        let low = 0, high = n - 1;
        while (high - low > 1) {
          const middle = (low + high) >> 1;
          if (time[middle] <= t) low = middle;
          else high = middle;
        }
        return [low, Math.min(1, Math.max(0, (t - time[low]) / (time[high] - time[low])))];
      },
    };
  }
  const toward = (from, to) => { // the shortest rotation from one unit vector to another
    const w = 1 + from.reduce((sum, v, i) => sum + v * to[i], 0);
    return w < 1e-6 ? new Quat(...unit(cross(from, Math.abs(from[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0])), 0) : new Quat(...cross(from, to), w).normalize();
  };
  const apart = (a, b) => (2 * Math.acos(Math.min(1, Math.abs(a.dot(b)))) * 180) / Math.PI; // deg
  return { read, cross, size, unit, toward, apart };
})();
