"use strict";
// Flies in a worker: start values and faults in, the plots' curves and the hash of the recorded values out.
let wasm, given;

const text = (place) => {
  const bytes = new Uint8Array(wasm.memory.buffer, place);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
};

function curve({ columns, norm, factor, offset }, rows, count, width) {
  const values = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    let value = rows[i * width + columns[0]];
    if (norm) {
      let sum = 0;
      for (const column of columns) sum += rows[i * width + column] ** 2;
      value = Math.sqrt(sum);
    }
    values[i] = factor * value + offset;
  }
  return values;
}

// When something is true of a sample, as spans of time.
function spans(holds, count, time) {
  const found = [];
  for (let i = 0; i < count; i++) {
    if (!holds(i)) continue;
    const first = i;
    while (i < count && holds(i)) i++;
    found.push([time[first], time[Math.min(i, count - 1)]]);
  }
  return found;
}

// When a signal changes its sign, linear between samples.
function crossings(column, rows, count, width, time, [low, high]) {
  const found = [];
  for (let i = 1; i < count; i++) {
    const a = rows[(i - 1) * width + column], b = rows[i * width + column];
    if (a * b < 0 && time[i - 1] >= low && time[i] <= high) found.push(time[i - 1] + (a / (a - b)) * (time[i] - time[i - 1]));
  }
  return found;
}

// The bands of phases: while a column has a value, from when to when.
function bands(conditions, rows, count, width, time) {
  const found = conditions.flatMap(({ name, column, value, colour }) =>
    spans((i) => rows[i * width + column] === value, count, time).filter(([from, to]) => from < to).map(([from, to]) => [name, from, to, colour]));
  return found.sort((a, b) => a[1] - b[1]);
}

// What the three-dimensional view shows, at fewer instants: as the report's, but attitudes stay matrices where they are.
function seen({ rows: chosen, signals, vectors, marks, still }, rows, count, width, time) {
  const pick = (columns) => Float64Array.from({ length: chosen.length * columns.length },
    (_, i) => rows[chosen[Math.floor(i / columns.length)] * width + columns[i % columns.length]]);
  const arrow = ({ columns, factor, along }) => {
    const axes = along || [[1, 0, 0], [0, 1, 0], [0, 0, 1]], n = columns.length, raw = pick(columns);
    const values = Float64Array.from({ length: 3 * chosen.length }, (_, i) => {
      let sum = 0;
      for (let k = 0; k < n; k++) sum += raw[Math.floor(i / 3) * n + k] * axes[k][i % 3];
      return factor * sum;
    });
    let largest = 0;
    for (let i = 0; i < values.length; i += 3) largest = Math.max(largest, Math.hypot(values[i], values[i + 1], values[i + 2]));
    return { values, largest };
  };
  const taken = Object.entries(signals).map(([name, columns]) => [name, Array.isArray(columns) ? pick(columns) : columns]);
  return { ...Object.fromEntries(taken), time: Float64Array.from(chosen, (row) => time[row]), vectors: vectors.map(arrow),
    phases: [...still, ...bands(marks, rows, count, width, time)] };
}

const viewed = ({ vectors, ...view }) => [...Object.values(view).filter(ArrayBuffer.isView), ...vectors.map((arrow) => arrow.values)];

async function fly({ starts, faults }) {
  const began = performance.now();
  new Float64Array(wasm.memory.buffer, wasm.starts(), starts.length).set(starts);
  new Int32Array(wasm.memory.buffer, wasm.faults(), faults.length).set(faults);
  const failed = wasm.begin() || wasm.advance(given.steps);
  const flown = performance.now() - began;
  if (failed) return { failure: text(wasm.message()), reached: (wasm.done() * given.numerator) / given.denominator };
  const width = given.columns, whole = Math.floor(given.steps / given.interval);
  const count = whole + 1 + (given.steps % given.interval ? 1 : 0);
  const rows = new Float64Array(wasm.memory.buffer, wasm.rows(), count * width);
  const time = Float64Array.from({ length: count }, (_, i) => (Math.min(i * given.interval, given.steps) * given.numerator) / given.denominator);
  const plots = given.plots.map((plot) => ({
    flown: [time, ...plot.curves.map((each) => curve(each, rows, count, width))],
    shade: plot.shade == null ? [] : spans((i) => rows[i * width + plot.shade], count, time),
    marks: plot.mark == null ? [] : crossings(plot.mark, rows, count, width, time, plot.window),
  }));
  // Only a secure context has the hash; a page from a file, from this machine or over https is one.
  const digest = self.crypto.subtle && new Uint8Array(await crypto.subtle.digest("SHA-256", rows));
  const hash = digest && Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
  const phases = given.phases && bands(given.phases, rows, count, width, time);
  const view = given.view && seen(given.view, rows, count, width, time);
  return { plots, phases, view, hash, flown, all: performance.now() - began };
}

onmessage = async ({ data }) => {
  try {
    if (data.wasm) {
      given = data.given;
      wasm = (await WebAssembly.instantiate(data.wasm)).instance.exports;
    }
    const flown = await fly(data);
    const arrays = [...(flown.plots || []).flatMap((plot) => plot.flown), ...(flown.view ? viewed(flown.view) : [])];
    postMessage({ number: data.number, ...flown }, [...new Set(arrays.map((array) => array.buffer))]); // given away, not copied
  } catch (error) {
    postMessage({ number: data.number, failure: `${error.name}: ${error.message}` });
  }
};
