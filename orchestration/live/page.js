// The controls of a live page: what they stand at goes to the worker, what it has flown to plots, view and verdicts.
(() => {
  const { live } = timeline.page;
  const { numerator, denominator, expect } = live.given;
  const at = (id) => document.getElementById(id);
  const all = (name) => [...document.querySelectorAll(`[data-${name}]`)];
  const [inputs, typed, buttons, times] = ["control", "typed", "fault", "at"].map(all);
  const instant = (count) => (count * numerator) / denominator;
  const counted = (time) => Math.ceil((time * denominator) / numerator - 1e-9 * Math.max(1, time));
  const bounded = (v, least, most) => Math.min(most, Math.max(least, v));

  // What differs from the scenario: positions of sliders by number (the others have its values to the last bit), whether
  // each fault is injected, and by how many base steps later than the scenario has it.
  const own = () => ({ moved: {}, on: live.faults.map((fault) => Number(fault.own)), shifts: live.faults.map(() => 0) });
  let now = own(), dragging = false, whole = null;
  const past = [];
  const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
  const begins = (i) => counted(live.faults[i].data.at) + now.shifts[i];
  const acting = () => live.faults.flatMap((_, i) => (now.on[i] ? [faultOf(i)] : []));

  // ---------------------------------------------------------------- start values

  function turned([x, y, z], angle) {
    const n = Math.hypot(x, y, z), c = Math.cos(angle), s = Math.sin(angle);
    const [a, b, d] = [x / n, y / n, z / n], v = 1 - c;
    return [a * a * v + c, a * b * v - d * s, a * d * v + b * s, a * b * v + d * s, b * b * v + c, b * d * v - a * s,
      a * d * v - b * s, b * d * v + a * s, d * d * v + c];
  }
  function starts() {
    const values = Float64Array.from(live.starts);
    for (const [number, position] of Object.entries(now.moved)) {
      const { measure, axis, factor, offset, places } = live.controls[number];
      const value = (position - offset) / factor;
      for (const mine of places) {
        const norm = Math.hypot(...mine.map((place) => live.starts[place]));
        const given = measure === "rotation" ? turned(axis, value) : mine.map((place) => (measure === "norm" ? live.starts[place] * (value / norm) : value));
        mine.forEach((place, i) => { values[place] = given[i]; });
      }
    }
    return values;
  }
  function nested(values, [size, ...rest]) {
    if (size === undefined) return values[0];
    const part = values.length / size;
    return Array.from({ length: size }, (_, i) => nested(values.slice(i * part, (i + 1) * part), rest));
  }
  function faultOf(i) { // as a scenario has it
    const { data } = live.faults[i], later = (time) => instant(counted(time) + now.shifts[i]);
    if (!now.shifts[i]) return data;
    return { ...data, at: later(data.at), ...(data.until === undefined ? {} : { until: later(data.until) }) };
  }
  function scenario(values) {
    const blocks = {};
    for (const number of Object.keys(now.moved)) {
      for (const { block, name, shape, places } of live.controls[number].names) {
        blocks[block] = { start: { ...blocks[block]?.start, [name]: nested(places.map((place) => values[place]), shape) } };
      }
    }
    const lines = [`name: ${live.name}_live`, `extends: ${JSON.stringify(live.file)}`, `step: ${live.step} s`, `duration: ${live.duration} s`];
    if (Object.keys(blocks).length) lines.push("blocks:");
    for (const [block, { start }] of Object.entries(blocks)) {
      lines.push(`  ${block}:`, "    start:", ...Object.entries(start).map(([name, value]) => `      ${JSON.stringify(name)}: ${JSON.stringify(value)}`));
    }
    const faults = acting().map((fault) => `  - ${JSON.stringify(fault)}`);
    if (live.faults.length) lines.push(faults.length ? "faults:" : "faults: []", ...faults);
    return `${lines.join("\n")}\n`;
  }

  // ---------------------------------------------------------------- the address

  const named = (i) => `fault${i + 1}`;
  function address() { // the changed values, so that a link shows the same flight
    const first = own(), parts = Object.entries(now.moved).map(([i, value]) => [live.controls[i].start, value]);
    live.faults.forEach((_, i) => {
      if (now.on[i] !== first.on[i] || now.shifts[i]) parts.push([named(i), now.on[i] ? instant(begins(i)) : "off"]);
    });
    return new URLSearchParams(parts).toString();
  }
  function ofAddress() { // and what of it cannot be taken as it is, in words
    const read = own(), other = [];
    for (const [name, text] of new URLSearchParams(location.hash.slice(1))) {
      const i = live.controls.findIndex(({ start }) => start === name), k = live.faults.findIndex((_, n) => named(n) === name);
      const value = text.trim() ? Number(text) : NaN, finite = Number.isFinite(value);
      let taken = null;
      if (i >= 0 && finite) {
        taken = read.moved[i] = bounded(value, Number(inputs[i].min), Number(inputs[i].max));
      } else if (k >= 0 && (finite || text === "off")) {
        const { data, most } = live.faults[k], at = finite ? bounded(counted(value), 0, most) : counted(data.at);
        [read.on[k], read.shifts[k]] = [Number(finite), at - counted(data.at)];
        taken = finite && Math.abs(instant(at) - value) < live.step ? value : finite ? instant(at) : NaN;
      }
      if (taken === null || (finite && taken !== value)) other.push(`${name}=${text}${taken === null ? "" : ` (${taken} is taken)`}`);
    }
    return [read, other.length ? `The address has what this page does not take: ${other.join(", ").slice(0, 200)}` : ""];
  }

  // ---------------------------------------------------------------- flights

  const worker = new Worker(URL.createObjectURL(new Blob([live.worker], { type: "text/javascript" })));
  let number = 0, busy = false, wanted = false, opening = true;
  let file = null, soon = null;
  const state = (name) => { document.documentElement.dataset.state = name; };
  function badge(kind, text) {
    at("verdict").textContent = text;
    at("verdict").className = `badge ${kind}`;
  }
  let first = { wasm: live.wasm, given: live.given };
  function fly() {
    wanted = busy;
    if (busy) return;
    busy = true;
    state("flying");
    soon ??= setTimeout(() => { at("speed").textContent = "flying"; }, 200); // a short flight shows nothing of it
    const values = starts(), text = scenario(values);
    at("scenario").textContent = text;
    if (file) URL.revokeObjectURL(file);
    file = at("save").href = URL.createObjectURL(new Blob([text], { type: "text/yaml" }));
    worker.postMessage({ ...first, number: ++number, starts: values, faults: now.on, shifts: now.shifts });
    first = {};
  }
  function found({ unit, expected }, { value, time }) {
    if (value === null) return "";
    const shown = typeof value === "string" ? value : / (true|false)$/.test(expected) ? String(Boolean(value)) : `${timeline.figures(value, 4)} ${unit}`.trim();
    return time === null ? shown : `${shown} at ${timeline.figures(time, 5)} s`;
  }
  let before = []; // the verdicts of the flight before
  function judge(verdicts, part) {
    all("expect").forEach((row, i) => {
      const { status } = verdicts[i], [word, , value] = row.cells;
      word.firstChild.textContent = status;
      word.firstChild.className = { met: "good", failed: "bad" }[status] || "warn";
      value.textContent = found(expect[i], verdicts[i]);
      row.classList.toggle("changed", Boolean(before[i]) && before[i].status !== status && !part);
    });
    const unmet = verdicts.filter(({ status }) => status !== "met").length, n = verdicts.length;
    if (!n) badge("plain", same(now, own()) ? "the scenario's own values" : "changed values");
    else if (part) badge("plain", `${n - unmet} of ${n} expectations met up to here`);
    else badge(unmet ? "bad" : "good", unmet ? `${unmet} of ${n} expectations not met` : `all ${n} expectations met`);
  }
  worker.onmessage = ({ data }) => {
    if (data.number !== number) return;
    busy = false;
    const { part, failure } = data, mine = same(now, own());
    if (part && opening && mine) return; // the page has this flight already
    if (!part) {
      clearTimeout(soon);
      soon = null;
      opening = false;
      state(failure ? "failed" : "shown");
      at("failure").textContent = failure || "";
      at("hash").textContent = data.hash || (failure ? "none, since the run failed" : "none: this browser gives it over https only");
      const equal = mine && data.hash ? data.hash === live.hash : null;
      at("same").textContent = equal === null ? "" : equal ? "the same as of the native run" : "not that of the native run";
      at("same").className = `badge ${equal ? "good" : "bad"}`;
    }
    if (failure) {
      badge("bad", `failed${data.reached === undefined ? "" : ` after ${data.reached} s`}; the curves are of the flight before`);
      at("speed").textContent = "";
    } else {
      const reached = timeline.figures(part ? data.reached : live.duration, 5);
      at("speed").textContent = part ? `${Math.round((100 * data.reached) / live.duration)} % flown` : `${reached} s flown in ${timeline.figures(data.flown / 1000, 2)} s`;
      const spans = acting().map(({ at: begin, until }) => [begin, until ?? live.duration].map((t) => Math.min(live.duration, t)));
      document.dispatchEvent(new CustomEvent("flown", { detail: { plots: data.plots, phases: data.phases, view: data.view, faults: spans } }));
      judge(data.verdicts, part);
      if (!part) whole = data.verdicts;
    }
    Object.assign(document.documentElement.dataset, part ? { reached: data.reached } : { flown: data.number, hash: data.hash || "", ms: data.flown || "", all: data.all || "", memory: data.memory || "", verdicts: JSON.stringify(data.verdicts || []) });
    if (wanted) fly();
  };

  // ---------------------------------------------------------------- controls

  let later = 0;
  const write = () => history.replaceState(null, "", [location.href.split("#")[0], address()].filter(Boolean).join("#"));
  function show(drag = false) {
    inputs.forEach((input, i) => {
      const value = now.moved[i] ?? input.defaultValue, { unit } = live.controls[i];
      input.value = value;
      if (document.activeElement !== typed[i]) typed[i].value = Number(Number(value).toPrecision(6));
      input.setAttribute("aria-valuetext", `${timeline.figures(Number(value), 4)}${unit === "1" ? "" : ` ${unit}`}`);
    });
    buttons.forEach((button, i) => {
      button.setAttribute("aria-pressed", String(Boolean(now.on[i])));
      if (document.activeElement !== times[i]) times[i].value = instant(begins(i));
    });
    at("undo").disabled = !past.length;
    clearTimeout(later);
    if (drag) later = setTimeout(write, 150); // browsers refuse hundreds of addresses in some seconds
    else write();
  }
  function take(to, keep = true, drag = false) { // with `keep` the flight up to now stays as the one before
    if (keep) {
      before = whole || [];
      document.dispatchEvent(new CustomEvent("before"));
    }
    now = to;
    show(drag);
    fly();
  }
  function change(to, drag = false, said = "") {
    at("address").textContent = said;
    if (same(to, now)) return;
    if (!dragging) past.push(now);
    take(to, !dragging, drag);
    dragging = drag;
  }
  const moved = (i, value) => ({ ...now, moved: { ...now.moved, [i]: bounded(value, Number(inputs[i].min), Number(inputs[i].max)) } });
  const put = (list, i, value) => list.map((old, k) => (k === i ? value : old));
  inputs.forEach((input, i) => {
    input.addEventListener("input", () => change(moved(i, Number(input.value)), true));
    input.addEventListener("change", () => { dragging = false; });
    typed[i].addEventListener("change", () => {
      if (typed[i].value.trim() && Number.isFinite(Number(typed[i].value))) change(moved(i, Number(typed[i].value)));
      typed[i].value = now.moved[i] ?? Number(input.defaultValue);
    });
  });
  function inject(i, time) {
    const shift = bounded(counted(time), 0, live.faults[i].most) - counted(live.faults[i].data.at);
    change({ ...now, on: put(now.on, i, 1), shifts: put(now.shifts, i, shift) });
  }
  buttons.forEach((button, i) => {
    button.addEventListener("click", () => change({ ...now, on: put(now.on, i, Number(!now.on[i])) }));
    times[i].addEventListener("change", () => {
      if (times[i].value.trim() && Number.isFinite(Number(times[i].value))) inject(i, Number(times[i].value));
      times[i].value = instant(begins(i));
    });
    all("now")[i].addEventListener("click", () => inject(i, timeline.at ?? 0));
  });
  function undo() {
    if (past.length) take(past.pop());
  }
  at("undo").addEventListener("click", undo);
  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === "z" && event.target.type !== "number") { event.preventDefault(); undo(); }
  });
  at("reset").addEventListener("click", (event) => {
    event.preventDefault();
    change(own());
  });
  addEventListener("hashchange", () => {
    const [read, said] = ofAddress();
    change(read, false, said);
    show();
  });
  addEventListener("submit", (event) => event.preventDefault());
  [now, at("address").textContent] = ofAddress();
  show();
  judge(live.verdicts);
  fly();
})();
