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

// When a flag is true, as spans of time.
function spans(column, rows, count, width, time) {
  const found = [];
  for (let i = 0; i < count; i++) {
    if (!rows[i * width + column]) continue;
    const first = i;
    while (i < count && rows[i * width + column]) i++;
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
    shade: plot.shade == null ? [] : spans(plot.shade, rows, count, width, time),
    marks: plot.mark == null ? [] : crossings(plot.mark, rows, count, width, time, plot.window),
  }));
  // Only a secure context has the hash; a page from a file, from this machine or over https is one.
  const digest = self.crypto.subtle && new Uint8Array(await crypto.subtle.digest("SHA-256", rows));
  const hash = digest && Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
  return { plots, hash, flown, all: performance.now() - began };
}

onmessage = async ({ data }) => {
  try {
    if (data.wasm) {
      given = data.given;
      wasm = (await WebAssembly.instantiate(data.wasm)).instance.exports;
    }
    postMessage({ number: data.number, ...(await fly(data)) });
  } catch (error) {
    postMessage({ number: data.number, failure: `${error.name}: ${error.message}` });
  }
};
