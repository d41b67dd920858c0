"use strict";
// Flies in a worker: start values and faults in; the plots' curves, the verdicts and the hash of the recorded values out.
// What is flown goes out in parts while the rest is computed; a flight that is asked for meanwhile ends this one.
let wasm, given, latest = 0;

const text = (place) => {
  const bytes = new Uint8Array(wasm.memory.buffer, place);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
};

function magnitude(columns, rows, at) {
  let sum = 0;
  for (const column of columns) sum += rows[at + column] * rows[at + column];
  return Math.sqrt(sum);
}

function curve({ columns, norm, factor, offset }, rows, count, width) {
  const values = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    const value = norm ? magnitude(columns, rows, i * width) : rows[i * width + columns[0]];
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
function seen({ rows: all, signals, vectors, marks, still }, rows, count, width, time) {
  const chosen = all.filter((row) => row < count);
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

// Expectations as outcomes.py has them: every base step counts, recorded or not; a sample is as good as its worst element.
const slack = (time) => 1e-9 * Math.max(1, Math.abs(time));
function watcher({ items, columns, norm, factor, offset, low, high, strict, how, zeros, after, before, when, phases }, width) {
  const state = { samples: 0, margin: null, value: null, time: null, sign: 0, changes: 0 };
  const first = after === null ? -Infinity : after - slack(after), last = before === null ? Infinity : before + slack(before);
  const least = low ?? -Infinity, most = high ?? Infinity, always = how === "always", same = factor === 1 && offset === 0;
  function within(rows, at, time) {
    if (time < first || time > last || (when !== null && !rows[at + when])) return false;
    if (!phases.length) return true;
    const early = time + slack(time);
    return phases.some(({ signal, value, spans }) => (signal === null ? spans.some(([from, to]) => from <= early && early < (to ?? Infinity)) : rows[at + signal] === value));
  }
  function see(rows, row, time) {
    const at = row * width;
    if (!within(rows, at, time)) return;
    state.samples++;
    let margin = Infinity, value = 0;
    for (let k = 0; k < (norm ? 1 : columns.length); k++) {
      let v = norm ? magnitude(columns, rows, at) : rows[at + columns[k]];
      if (!same) v = v * factor + offset;
      const own = Math.min(v - least, most - v);
      if (k === 0 || own < margin) [margin, value] = [own, v];
    }
    if (how === "zeros") {
      const sign = Math.sign(value);
      if (sign * state.sign < 0 && state.changes++ === 0) state.time = time;
      if (sign) state.sign = sign;
    } else if (state.margin === null || (always ? margin < state.margin : margin > state.margin)) {
      [state.margin, state.value, state.time] = [margin, value, time];
    }
  }
  function verdict() { // of what is flown up to now
    const { samples, margin, value, time, sign, changes } = state;
    if (!samples) return { status: "not reached", value: null, time: null };
    if (how === "zeros") return { status: sign && changes === zeros ? "met" : "failed", value: sign ? changes : null, time };
    return { status: (strict ? margin > 0 : margin >= 0) ? "met" : "failed", value: items[String(value)] ?? value, time };
  }
  return { see, verdict };
}

const instant = (count) => (count * given.numerator) / given.denominator;
function drawn(steps) { // what plots and view show of the first steps
  const width = given.columns, ended = steps === given.steps && steps % given.interval ? 1 : 0; // a last sample between two
  const count = Math.floor(steps / given.interval) + 1 + ended;
  const rows = new Float64Array(wasm.memory.buffer, wasm.rows(), count * width);
  const time = Float64Array.from({ length: count }, (_, i) => instant(Math.min(i * given.interval, given.steps)));
  const plots = given.plots.map((plot) => ({
    flown: [time, ...plot.curves.map((each) => curve(each, rows, count, width))],
    shade: plot.shade == null ? [] : spans((i) => rows[i * width + plot.shade], count, time),
    marks: plot.mark == null ? [] : crossings(plot.mark, rows, count, width, time, plot.window),
  }));
  const phases = given.phases && bands(given.phases, rows, count, width, time);
  return { rows, plots, phases, view: given.view && seen(given.view, rows, count, width, time) };
}

function post(number, { rows, ...flown }, more) {
  const arrays = [...flown.plots.flatMap((plot) => plot.flown), ...(flown.view ? viewed(flown.view) : [])];
  postMessage({ number, ...flown, ...more }, [...new Set(arrays.map((array) => array.buffer))]); // given away, not copied
}

const pause = new MessageChannel(); // lets the messages come in that wait; a timer would wait for 4 ms
const others = () => new Promise((done) => { pause.port1.onmessage = done; pause.port2.postMessage(0); });

async function fly({ number, starts, faults, shifts }) {
  const began = performance.now();
  new Float64Array(wasm.memory.buffer, wasm.starts(), starts.length).set(starts);
  new Int32Array(wasm.memory.buffer, wasm.faults(), faults.length).set(faults);
  new Int32Array(wasm.memory.buffer, wasm.shifts(), shifts.length).set(shifts);
  const watched = given.expect.map((check) => watcher(check, given.observed));
  const verdicts = () => watched.map((one) => one.verdict());
  const look = (from, to) => { // the base steps of the rows
    const rows = new Float64Array(wasm.memory.buffer, wasm.observed(), (to - from + 1) * given.observed);
    for (const { see } of watched) for (let i = from; i <= to; i++) see(rows, i - from, instant(i));
  };
  let failed = wasm.begin(), now = began, asked = began, part = began;
  if (!failed) look(0, 0);
  for (let done = 0; !failed && done < given.steps; now = performance.now()) {
    failed = wasm.advance(done + given.stretch);
    const reached = wasm.done();
    if (!failed) look(done + 1, reached);
    done = reached;
    if (now - asked > 25) {
      await others();
      if (number !== latest) return;
      asked = performance.now();
    }
    // Each part is computed from the start on, so the next one waits for a share of what is flown.
    if (!failed && now - part > Math.max(60, (now - began) / 4) && done >= 2 * given.interval && done < given.steps) {
      const shown = drawn(done);
      if (!shown.view || shown.view.time.length > 1) post(number, shown, { part: true, reached: instant(done), verdicts: verdicts() });
      part = performance.now();
    }
  }
  const flown = performance.now() - began;
  if (failed) {
    postMessage({ number, failure: text(wasm.message()), reached: instant(wasm.done()) });
    return;
  }
  const whole = drawn(given.steps);
  // Only a secure context has the hash; a page from a file, from this machine or over https is one.
  const digest = self.crypto.subtle && new Uint8Array(await crypto.subtle.digest("SHA-256", whole.rows));
  const hash = digest && Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
  if (number === latest) post(number, whole, { hash, flown, verdicts: verdicts(), all: performance.now() - began, memory: wasm.memory.buffer.byteLength });
}

let ready = null;
onmessage = async ({ data }) => {
  latest = data.number;
  try {
    if (data.wasm) {
      given = data.given;
      const packed = atob(data.wasm), bytes = new Uint8Array(packed.length); // here, so that the page moves meanwhile
      for (let i = 0; i < bytes.length; i++) bytes[i] = packed.charCodeAt(i);
      ready = WebAssembly.instantiate(bytes);
    }
    wasm ||= (await ready).instance.exports;
    if (data.number === latest) await fly(data);
  } catch (error) {
    postMessage({ number: data.number, failure: `${error.name}: ${error.message}` });
  }
};
