// The controls of a live page: what they stand at goes to the worker, what it has flown to the plots.
(() => {
  const { live } = JSON.parse(document.getElementById("data").textContent);
  const at = (id) => document.getElementById(id);
  const inputs = [...document.querySelectorAll("[data-control]")];
  const buttons = [...document.querySelectorAll("[data-fault]")];
  const moved = new Set(); // the others have the scenario's own values, to the last bit
  const on = () => buttons.map((button) => Number(button.getAttribute("aria-pressed") === "true"));

  // ---------------------------------------------------------------- start values

  function turned([x, y, z], angle) {
    const n = Math.hypot(x, y, z), c = Math.cos(angle), s = Math.sin(angle);
    const [a, b, d] = [x / n, y / n, z / n], v = 1 - c;
    return [a * a * v + c, a * b * v - d * s, a * d * v + b * s, a * b * v + d * s, b * b * v + c, b * d * v - a * s,
      a * d * v - b * s, b * d * v + a * s, d * d * v + c];
  }
  function starts() {
    const values = Float64Array.from(live.starts);
    for (const number of moved) {
      const { measure, axis, factor, offset, places } = live.controls[number];
      const value = (Number(inputs[number].value) - offset) / factor;
      for (const own of places) {
        const norm = Math.hypot(...own.map((place) => live.starts[place]));
        const given = measure === "rotation" ? turned(axis, value) : own.map((place) => (measure === "norm" ? live.starts[place] * (value / norm) : value));
        own.forEach((place, i) => { values[place] = given[i]; });
      }
    }
    return values;
  }
  function nested(values, [size, ...rest]) {
    if (size === undefined) return values[0];
    const part = values.length / size;
    return Array.from({ length: size }, (_, i) => nested(values.slice(i * part, (i + 1) * part), rest));
  }
  function scenario(values, faults) {
    const blocks = {};
    for (const number of moved) {
      for (const { block, name, shape, places } of live.controls[number].names) {
        blocks[block] = { start: { ...blocks[block]?.start, [name]: nested(places.map((place) => values[place]), shape) } };
      }
    }
    const lines = [`name: ${live.name}_live`, `extends: ${JSON.stringify(live.file)}`, `step: ${live.step} s`, `duration: ${live.duration} s`];
    if (moved.size) lines.push("blocks:");
    for (const [block, { start }] of Object.entries(blocks)) {
      lines.push(`  ${block}:`, "    start:", ...Object.entries(start).map(([name, value]) => `      ${JSON.stringify(name)}: ${JSON.stringify(value)}`));
    }
    const acting = live.faults.filter((_, i) => faults[i]);
    if (live.faults.length) lines.push(acting.length ? "faults:" : "faults: []", ...acting.map((fault) => `  - ${JSON.stringify(fault.data)}`));
    return `${lines.join("\n")}\n`;
  }

  // ---------------------------------------------------------------- flights

  const worker = new Worker(URL.createObjectURL(new Blob([live.worker], { type: "text/javascript" })));
  let number = 0, busy = false, wanted = false;
  let file = null, soon = null;
  const state = (name) => { document.documentElement.dataset.state = name; }; // dims what is of the flight before
  function badge(kind, text) {
    at("verdict").textContent = text;
    at("verdict").className = `badge ${kind}`;
  }
  let first = { wasm: Uint8Array.from(atob(live.wasm), (c) => c.charCodeAt(0)), given: live.given };
  function fly() {
    wanted = busy;
    if (busy) return;
    busy = true;
    state("flying"); // a short flight shows nothing of it
    soon = setTimeout(() => badge("plain", "flying"), 200);
    const values = starts(), faults = on();
    const text = scenario(values, faults);
    at("scenario").textContent = text;
    if (file) URL.revokeObjectURL(file);
    file = at("save").href = URL.createObjectURL(new Blob([text], { type: "text/yaml" }));
    worker.postMessage({ ...first, number: ++number, starts: values, faults });
    first = {};
  }
  worker.onmessage = ({ data }) => {
    busy = false;
    clearTimeout(soon);
    state(data.failure ? "failed" : "shown");
    at("failure").textContent = data.failure || "";
    const own = !moved.size && on().every((acts, i) => Boolean(acts) === live.faults[i].own);
    at("hash").textContent = data.hash || (data.failure ? "none, since the run failed" : "none: this browser gives it over https only");
    const same = own && data.hash ? data.hash === live.hash : null;
    at("same").textContent = same === null ? "" : same ? "the same as of the native run" : "not that of the native run";
    at("same").className = `badge ${same ? "good" : "bad"}`;
    if (data.failure) badge("bad", `failed${data.reached === undefined ? "" : ` after ${data.reached} s`}; the curves are of the flight before`);
    else badge(own ? "good" : "warn", own ? "the scenario's own values" : "changed values");
    if (!data.failure) {
      at("speed").textContent = `${live.duration} s flown in ${data.flown.toFixed(0)} ms`;
      const spans = live.faults.filter((_, i) => on()[i]).map((fault) => fault.span);
      document.dispatchEvent(new CustomEvent("flown", { detail: { plots: data.plots, phases: data.phases, view: data.view, faults: spans } }));
    }
    Object.assign(document.documentElement.dataset, { flown: data.number, hash: data.hash || "", ms: data.flown || "", all: data.all || "" });
    if (wanted) fly();
  };

  // ---------------------------------------------------------------- controls

  function say(i) {
    const { unit } = live.controls[i], output = inputs[i].parentElement.querySelector("output");
    output.textContent = `${Number(Number(inputs[i].value).toPrecision(4))}${unit === "1" ? "" : ` ${unit}`}`.replace("-", "\u2212");
    inputs[i].setAttribute("aria-valuetext", output.textContent);
  }
  inputs.forEach((input, i) => {
    say(i);
    input.addEventListener("input", () => { moved.add(i); say(i); fly(); });
  });
  buttons.forEach((button) => button.addEventListener("click", () => {
    button.setAttribute("aria-pressed", button.getAttribute("aria-pressed") !== "true");
    fly();
  }));
  at("reset").addEventListener("click", (event) => {
    event.preventDefault();
    for (const input of inputs) input.value = input.defaultValue;
    moved.clear();
    buttons.forEach((button, i) => button.setAttribute("aria-pressed", live.faults[i].own));
    inputs.forEach((_, i) => say(i));
    fly();
  });
  fly();
})();
