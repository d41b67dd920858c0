"use strict";
// Draws the plots of a page from the JSON in its element #data.
// Longer than 250 lines: all kinds of plots share the page's data, scales and cursor.

// What plots and the three-dimensional view share: the instant that is looked at, and who wants to know of it.
const timeline = {
  at: null,
  followers: [],
  go(at) { this.set(at); }, // also while it plays
  set(at, from) {
    this.at = at;
    for (const follow of this.followers) if (follow !== from) follow(at);
  },
};
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const drawn = new Map(); // the plot in each place
  const PAPER = { one: 680, many: 330 }; // widths in print, px
  let printing = false;

  // ---------------------------------------------------------------- data

  const unpacked = new Map();
  function array(place) {
    if (!unpacked.has(place)) {
      const { type, data, scale } = page.arrays[place] ?? place; // or the array itself
      const text = atob(data), bytes = new Uint8Array(text.length);
      for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
      const read = new { u1: Uint8Array, i2: Int16Array, f4: Float32Array, f8: Float64Array }[type](bytes.buffer), values = new Array(read.length);
      for (let i = 0; i < values.length; i++) values[i] = Number.isFinite(read[i]) ? (type === "i2" ? read[i] * scale : read[i]) : null; // null is a gap
      unpacked.set(place, values);
    }
    return unpacked.get(place);
  }

  // ---------------------------------------------------------------- numbers

  const sign = (text) => text.replace(/-/g, "\u2212");
  const plain = (v) => (v === 0 || (Math.abs(v) >= 1e-4 && Math.abs(v) < 1e7));
  function figures(v, n) {
    if (v == null) return "\u2013";
    const rounded = Number(v.toPrecision(n));
    return sign(plain(rounded) ? String(rounded) : rounded.toExponential());
  }
  // Labels of ticks: as many decimals as their distance wants.
  function labels(ticks) {
    const distance = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : 1;
    const largest = Math.max(...ticks.map(Math.abs));
    if (largest >= 1e6 || (largest > 0 && largest < 1e-4)) {
      const decimals = Math.max(0, Math.floor(Math.log10(largest)) - Math.floor(Math.log10(distance) + 1e-9));
      return ticks.map((v) => (v === 0 ? "0" : sign(v.toExponential(Math.min(decimals, 12)))));
    }
    const decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(distance) + 1e-9)));
    return ticks.map((v) => sign((Object.is(v, -0) ? 0 : v).toFixed(decimals)));
  }
  function ticks(low, high, count, least = 1) { // about so many, and `least` at least
    const rough = (high - low) / Math.max(1, count);
    if (!(rough > 0)) return [low];
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= rough * (1 - 1e-9));
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
    return found.length < least && count < 20 ? ticks(low, high, count + 1, least) : found;
  }


  // ---------------------------------------------------------------- a plot

  let span = null; // the times to which the linked plots are zoomed
  let passing = false; // whether a plot is told what another one did
  const visible = new Set();
  const within = (range) => (span && span[0] < range[1] && span[1] > range[0] ? [Math.max(span[0], range[0]), Math.min(span[1], range[1])] : range);
  function zoom(low, high, from) { // one plot's zoom, which the others follow as far as they reach
    const [first, last] = from.ends, [from0, to0] = within(from.ends);
    if (low === from0 && high === to0) return; // it follows itself
    span = high - low < (last - first) * (1 - 1e-6) ? [low, high] : null;
    for (const other of drawn.values()) {
      if (other === from || !other.linked) continue;
      const [min, max] = within(other.ends);
      other.setScale("x", { min, max });
    }
  }
  function limit(u, low, high) { // a span of that width within the plot's ends
    const [first, last] = u.ends, width = Math.min(high - low, last - first);
    const from = Math.min(Math.max(low, first), last - width);
    u.setScale("x", { min: from, max: from + width });
  }
  const scaled = (u, factor, at) => {
    const { min, max } = u.scales.x;
    limit(u, at - (at - min) * factor, at + (max - at) * factor);
  };
  const shifted = (u, by) => limit(u, u.scales.x.min + by, u.scales.x.max + by);
  const whole = (u) => u.setScale("x", { min: u.ends[0], max: u.ends[1] });
  function point(u, at) { // the cursor at an instant; none where the plot does not show it
    const { min, max } = u.scales.x;
    u.setCursor(at === null || at < min || at > max ? { left: -10, top: -10 } : { left: u.valToPos(at, "x"), top: 4 });
  }
  let looked = null; // the instant at which the cursors stand
  function pass(at, to) { // the others' cursor to one that is linked
    passing = true;
    for (const u of to) if (u.linked) point(u, at);
    passing = false;
  }
  function follow(at, from) {
    looked = at;
    pass(at, [...visible].map((place) => drawn.get(place)).filter((u) => u && u !== from));
  }
  timeline.followers.push(follow);
  function told(u, plot, curves) { // the values under the cursor, with units
    const { idx, left } = u.cursor, box = u.readout;
    box.hidden = idx == null || left < 0;
    if (box.hidden) return;
    const rows = u.series.flatMap((s, i) => (i && !s.show ? [] : [[i ? curves[i - 1] : "", s.label, i ? s.value(u, u.data[i][idx], i, idx) : s.value(u, u.data[0][idx], i, idx)]]));
    box.replaceChildren(...rows.map(([swatch, name, value]) => {
      const row = document.createElement("div"), mark = document.createElement("i"), cell = document.createElement("b");
      mark.style.background = swatch || "none";
      cell.textContent = value;
      row.append(mark, `${name} `, cell);
      return row;
    }));
  }
  function handled(u, plot) { // mouse, fingers and keys beyond what uPlot does itself
    const { over } = u, fingers = new Map();
    let held = null;
    const at = (event) => u.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
    over.addEventListener("pointerdown", (event) => {
      if (event.pointerType !== "mouse") fingers.set(event.pointerId, event.clientX);
      else if (event.shiftKey) held = event.clientX;
      if (held !== null) over.setPointerCapture(event.pointerId);
    });
    over.addEventListener("pointermove", (event) => {
      const perPixel = (u.scales.x.max - u.scales.x.min) / over.clientWidth;
      if (held !== null) {
        shifted(u, (held - event.clientX) * perPixel);
        held = event.clientX;
      } else if (fingers.size === 1 && fingers.has(event.pointerId)) {
        point(u, at(event));
      } else if (fingers.size === 2 && fingers.has(event.pointerId)) {
        const [a, b] = [...fingers.values()];
        fingers.set(event.pointerId, event.clientX);
        const [c, d] = [...fingers.values()];
        const factor = Math.abs(a - b) / Math.max(20, Math.abs(c - d));
        const box = over.getBoundingClientRect().left;
        scaled(u, factor, u.posToVal((c + d) / 2 - box, "x"));
        shifted(u, ((a + b) / 2 - (c + d) / 2) * perPixel);
      }
    });
    for (const name of ["pointerup", "pointercancel"]) {
      over.addEventListener(name, (event) => { held = null; fingers.delete(event.pointerId); });
    }
    over.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      scaled(u, event.deltaY > 0 ? 1.25 : 0.8, at(event));
    }, { passive: false });
    over.addEventListener("dblclick", () => whole(u));
    let pressed = 0;
    over.addEventListener("pointerdown", (event) => { pressed = event.clientX; });
    over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - pressed) > 3) return;
      if (u.linked) timeline.go(at(event));
      else visit(u, plot);
    });
    over.tabIndex = 0;
    over.setAttribute("role", "application");
    over.setAttribute("aria-label", `${plot.label} over ${plot.xlabel || "time"}: arrow keys move the cursor, with Shift the plot, + and - zoom, 0 shows all`);
    over.addEventListener("keydown", (event) => {
      const { min, max } = u.scales.x, step = (max - min) / 100;
      const now = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : min;
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (way && event.shiftKey) shifted(u, 10 * way * step);
      else if (way) point(u, Math.min(max, Math.max(min, now + way * step)));
      else if (event.key === "+") scaled(u, 0.8, now);
      else if (event.key === "-") scaled(u, 1.25, now);
      else if (event.key === "Enter" && plot.runs) visit(u, plot);
      else if (event.key === "0" || event.key === "Escape") whole(u);
      else return;
      event.preventDefault();
    });
  }

  function visit(u, plot) { // the run of a campaign under the cursor as a flight, or how to have it
    if (!plot.runs || u.cursor.idx == null) return;
    const run = array(plot.runs)[u.cursor.idx], flight = page.flights?.[run];
    if (flight) { location.assign(flight); return; }
    u.told ||= u.root.parentElement.appendChild(Object.assign(document.createElement("p"), { className: "hint" }));
    u.told.setAttribute("role", "status");
    u.told.textContent = `Run ${run} as a flight: ${page.replay.replace("RUN", run)}`;
  }

  function theme() {
    const style = getComputedStyle(document.documentElement);
    const paper = { "--text": "#1b1f24", "--quiet": "#59636e", "--grid": "#e9ecef", "--limit": "#5b6570", "--page": "#fff",
      "--shade": "rgba(90, 100, 115, .2)", "--fault": "rgba(200, 40, 30, .08)" };
    return (name) => (printing ? paper[name] : style.getPropertyValue(name).trim());
  }
  const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3]];
  const onDark = { "#000000": "#f0f0f0", "#0072b2": "#4aa3df", "#999999": "#b5b5b5" };
  function swatch(curve, colour) { // as the curve is drawn
    const c = colour(curve.colour) + (curve.pale ? "66" : "");
    return curve.dashed || curve.layer ? `repeating-linear-gradient(90deg, ${c} 0 38%, transparent 38% 62%)` : c;
  }
  function colour(i) {
    const own = page.colours[i % page.colours.length];
    return (!printing && dark.matches && onDark[own]) || own;
  }

  Object.assign(timeline, { page, array, figures, colour });
  function columns(plot) { // times and curves; what a logarithmic scale does not show is a gap
    const [x, ...ys] = plot.flown || [array(plot.x), ...plot.curves.map((curve) => array(curve.y))];
    return [x, ...(plot.scale === "log" ? ys.map((y) => Array.from(y, (v) => (v > 0 ? v : null))) : ys)];
  }
  function renew(place) { // other values in the same plot
    const u = drawn.get(place), { min, max } = u.scales.x;
    u.setData(columns(page.plots[place.dataset.plot]), false);
    u.setScale("x", { min, max });
  }
  function draw(place) {
    const plot = page.plots[place.dataset.plot];
    const before = drawn.get(place);
    const css = theme();
    const log = plot.scale === "log";
    const [x, ...ys] = columns(plot);
    const [first, last] = plot.range[0] < plot.range[1] ? plot.range : [plot.range[0], plot.range[0] + 1];
    let view = [first, last]; // what the scale of time is about to show, known before the others are laid out
    const zoomed = () => view[1] - view[0] < (last - first) * (1 - 1e-6);
    const font = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'Liberation Sans', sans-serif";
    const axis = { font, labelFont: font, stroke: css("--quiet"), labelSize: 18, ticks: { show: false }, grid: { stroke: css("--grid"), width: 1 },
      border: { show: true, stroke: css("--limit"), width: 1 } };
    // As many ticks of time as have room for their labels.
    const splits = (period) => (u, i, low, high) => {
      const wide = u.bbox.width / uPlot.pxRatio || 400;
      for (let count = Math.floor(wide / 55); ; count--) {
        const at = ticks(low / period, high / period, count);
        const room = at.length > 1 ? ((at[1] - at[0]) * period * wide) / (high - low) : wide;
        if (count <= 1 || room >= 7 * Math.max(...labels(at).map((t) => t.length)) + 14) return at.map((v) => v * period);
      }
    };
    const named = (at) => at.map((v) => plot.items[v] ?? ""); // names in place of numbers
    const axes = [
      { ...axis, ...(above(place) ? {} : { label: plot.xlabel || "time, s" }), size: 28, gap: 4,
        splits: plot.items ? () => plot.items.map((_, i) => i) : splits(1), values: (u, at) => (plot.items ? named(at) : labels(at)) },
      { ...axis, gap: 4, ...(log ? { values: powers } : { values: (u, at) => labels(at),
        splits: (u, i, low, high) => ticks(low, high, Math.floor((u.bbox.height / uPlot.pxRatio || 200) / 34), 2) }),
        size: (u, texts) => 10 + 7 * Math.max(page.cycle ? 4 : 3, ...(texts || []).map((t) => t.length)) },
    ];
    if (page.cycle && !plot.xlabel) {
      axes.push({ ...axis, side: 0, scale: "x", size: 24, gap: 5, grid: { show: false }, splits: splits(page.cycle.period),
        values: (u, at) => labels(at.map((t) => t / page.cycle.period)).map((text, i) => (i ? text : `${text} ${page.cycle.name}`)) });
    }
    const time = (u, v) => (v == null ? "\u2013" : `${figures(v, 7)} s` + (page.cycle ? `, ${figures(v / page.cycle.period, 4)} ${page.cycle.name}` : ""));
    const place0 = (u, v, i, at) => (v == null ? "\u2013" : (plot.items ? named([Math.round(v)])[0] : figures(v, 5))
      + (plot.runs && at != null ? `, run ${array(plot.runs)[at]}` : ""));
    const swatches = plot.curves.map((curve) => swatch(curve, colour));
    const dots = plot.curves.some((curve) => curve.dots);
    const options = {
      width: width(place), height: height(place), axes,
      scales: {
        x: { time: false, range: (u, low, high) => (view = Number.isFinite(low) && low < high ? [low, high] : [first, last]) },
        y: log ? { distr: 3 } : { range: (u, low, high) => {
          if (!Number.isFinite(low)) [low, high] = plot.lines.length && !zoomed() ? [Infinity, -Infinity] : [0, 1];
          if (!zoomed()) for (const line of [...plot.lines, ...(plot.before?.ends || [])]) { low = Math.min(low, line); high = Math.max(high, line); }
          const least = Math.max(plot.least || 0, 1e-9 * Math.max(Math.abs(low), Math.abs(high))); // rounding is no signal
          if (low < high && high - low < 2 * least) [low, high] = [(low + high) / 2 - least, (low + high) / 2 + least];
          const pad = low < high ? 0.06 * (high - low) : 0.1 * Math.abs(low) || 1;
          return [low - pad, high + pad];
        } },
      },
      series: [
        plot.xlabel ? { label: plot.xname || "value", value: place0 } : { label: "time", value: time },
        ...plot.curves.map((curve, i) => ({
          label: curve.name, stroke: colour(curve.colour), width: curve.pale ? 4 : curve.layer === 0 ? 2.6 : 1.6, alpha: curve.pale ? 0.4 : 1, pxAlign: 0,
          dash: curve.pale ? (curve.dashed ? [7, 5] : []) : curve.layer ? [6, 4] : DASHES[Math.floor(curve.colour / page.colours.length) % DASHES.length],
          value: (u, v) => (v == null ? "\u2013" : figures(v, 5) + (plot.unit ? ` ${plot.unit}` : "")), paths: curve.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
          ...(curve.dots ? { paths: () => null, points: { show: true, space: 0, size: 4.5, width: 0.5, fill: colour(curve.colour), stroke: css("--page") } }
            : { points: { show: x.length < 40 && !curve.bare } }), show: before ? before.series[i + 1].show : true,
        })),
      ],
      legend: { live: false, show: plot.curves.length > 1, markers: { width: 0, fill: (u, i) => (i ? swatches[i - 1] : "") } },
      cursor: { y: Boolean(plot.xlabel), drag: { x: true, y: false }, points: { size: 7 }, ...(dots ? { dataIdx: (u) => nearest(u, x, ys) } : {}),
        bind: { mousedown: (u, target, handler) => (event) => { if (!event.shiftKey) handler(event); }, dblclick: () => null } },
      hooks: {
        init: [(u) => Object.assign(u, { ends: [first, last], linked: !plot.xlabel, readout: readout(u) })],
        drawClear: [(u) => { spans(u, plot, css); former(u, plot); }], draw: [(u) => { lines(u, plot, css); names(u, plot, css); }],
        setScale: [(u, key) => { if (key === "x" && u.linked && u.root.isConnected) zoom(u.scales.x.min, u.scales.x.max, u); }],
        setCursor: [(u) => {
          const { left } = u.cursor, shown = !u.readout.hidden;
          told(u, plot, swatches);
          if (passing || !u.linked || (left < 0 && !shown)) return; // one that has just been drawn takes no cursor away
          follow(left < 0 ? null : u.posToVal(left, "x"), u);
          if (left >= 0) timeline.set(u.posToVal(left, "x"), follow);
        }],
      },
    };
    let range = null;
    if (before) {
      range = { min: before.scales.x.min, max: before.scales.x.max };
      before.destroy();
    }
    place.style.minHeight = "";
    const u = new uPlot(options, [x, ...ys], place);
    drawn.set(place, u);
    const [min, max] = plot.xlabel ? [first, last] : within([first, last]);
    u.setScale("x", range || { min, max });
    handled(u, plot);
    u.root.querySelectorAll(".u-series th").forEach((th, i) => {
      th.tabIndex = 0;
      th.setAttribute("role", "button");
      const say = () => th.setAttribute("aria-pressed", u.series[i + 1].show);
      th.addEventListener("click", () => queueMicrotask(say));
      th.addEventListener("keydown", (event) => {
        if (event.key === "Enter" || event.key === " ") { event.preventDefault(); th.click(); }
      });
      say();
    });
  }

  function readout(u) {
    const box = document.createElement("div");
    box.className = "readout";
    box.hidden = true;
    u.over.append(box);
    return box;
  }
  const powers = (u, at) => at.map((v) => (v && Math.abs(Math.log10(v) % 1) < 1e-9 ? sign(v >= 1e-3 && v < 1e4 ? String(v) : v.toExponential(0)) : ""));

  // The dot nearest to the mouse, of all curves.
  function nearest(u, x, ys) {
    const { left, top } = u.cursor;
    let best = null, least = 30 ** 2;
    if (left < 0) return best;
    const [from, to] = [left - 30, left + 30].map((at) => u.valToIdx(u.posToVal(at, "x")));
    for (let i = from; i <= to; i++) {
      for (const [k, y] of ys.entries()) {
        if (y[i] == null || !u.series[k + 1].show) continue;
        const d = (u.valToPos(x[i], "x") - left) ** 2 + (u.valToPos(y[i], "y") - top) ** 2;
        if (d < least) [best, least] = [i, d];
      }
    }
    return best;
  }

  function clipped(u, paint) {
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    u.ctx.clip();
    paint(u.ctx, uPlot.pxRatio);
    u.ctx.restore();
  }
  const phases = (plot) => (plot.xlabel ? [] : page.phases || []);
  function names(u, plot, css) { // of phases, over grid and curves
    clipped(u, (ctx, ratio) => {
      ctx.font = `${11 * ratio}px system-ui, sans-serif`;
      ctx.fillStyle = css("--quiet");
      ctx.strokeStyle = css("--page");
      ctx.lineWidth = 3 * ratio;
      ctx.lineJoin = "round";
      ctx.textBaseline = "middle";
      for (const [name, from, to] of phases(plot)) {
        const left = Math.max(u.valToPos(from, "x", true), u.bbox.left), right = Math.min(u.valToPos(to, "x", true), u.bbox.left + u.bbox.width);
        const wide = right - left, long = ctx.measureText(name).width, across = long + 6 * ratio < wide;
        if (!across && (wide < 13 * ratio || long + 8 * ratio > u.bbox.height)) continue; // no room for it
        ctx.save();
        ctx.translate((left + right) / 2, u.bbox.top + (across ? 10 : 5) * ratio);
        if (!across) ctx.rotate(Math.PI / 2);
        ctx.textAlign = across ? "center" : "left";
        ctx.strokeText(name, 0, 0);
        ctx.fillText(name, 0, 0);
        ctx.restore();
      }
    });
  }
  function spans(u, plot, css) {
    clipped(u, (ctx, ratio) => {
      for (const [, from, to, place] of phases(plot)) {
        const a = u.valToPos(from, "x", true), b = u.valToPos(to, "x", true);
        ctx.globalAlpha = 0.12;
        ctx.fillStyle = colour(place);
        ctx.fillRect(a, u.bbox.top, b - a, u.bbox.height);
        ctx.globalAlpha = 1;
      }
      for (const [list, name] of [[plot.xlabel ? [] : page.faults, "--fault"], [plot.shade, "--shade"]]) {
        ctx.fillStyle = css(name);
        for (const [from, to] of list) {
          const a = u.valToPos(from, "x", true), b = u.valToPos(to, "x", true);
          ctx.fillRect(a, u.bbox.top, Math.max(b - a, 1.5 * ratio), u.bbox.height); // the shortest stays visible
        }
      }
    });
  }
  function former(u, { before, curves }) { // the flight before, pale below the curves
    if (!before) return;
    clipped(u, (ctx, ratio) => {
      ctx.globalAlpha = 0.35;
      ctx.lineWidth = 3 * ratio;
      const [x, ...ys] = before.columns, { min, max } = u.scales.x;
      ys.forEach((y, k) => {
        if (!u.series[k + 1].show) return;
        ctx.strokeStyle = colour(curves[k].colour);
        ctx.beginPath();
        for (let i = 0, last = 0, pen = false; i < y.length; i++) {
          if (y[i] === null || x[i] < min || x[i] > max) { pen = false; continue; }
          const at = u.valToPos(x[i], "x", true);
          if (pen && at - last < 0.5 * ratio && i < y.length - 1) continue; // no finer than the screen
          ctx[pen ? "lineTo" : "moveTo"](at, u.valToPos(y[i], "y", true));
          [pen, last] = [true, at];
        }
        ctx.stroke();
      });
      ctx.globalAlpha = 1;
    });
  }
  function lines(u, plot, css) {
    clipped(u, (ctx, ratio) => {
      ctx.strokeStyle = css("--limit");
      ctx.lineWidth = 1.1 * ratio;
      const stroke = (dash, x0, y0, x1, y1) => {
        ctx.setLineDash(dash.map((d) => d * ratio));
        ctx.beginPath();
        ctx.moveTo(x0, y0);
        ctx.lineTo(x1, y1);
        ctx.stroke();
      };
      for (const line of plot.lines) {
        const y = u.valToPos(line, "y", true);
        stroke([6, 4], u.bbox.left, y, u.bbox.left + u.bbox.width, y);
      }
      for (const mark of plot.marks) {
        const x = u.valToPos(mark, "x", true);
        stroke([1.5, 3], x, u.bbox.top, x, u.bbox.top + u.bbox.height);
      }
    });
  }

  // ---------------------------------------------------------------- the page

  const single = (place) => place.parentElement.classList.contains("n1");
  function width(place) {
    return printing ? (single(place) ? PAPER.one : PAPER.many) : Math.max(200, place.clientWidth);
  }
  const beside = (place) => place.closest(".first.both");
  const above = (place) => !printing && Boolean(beside(place)?.matches(":not(.live)")) && place !== place.parentElement.lastElementChild; // another one stands below
  const height = (place) => (printing ? 205 : beside(place) ? Math.max(190, Math.min(300, 430 / place.parentElement.children.length)) : single(place) ? 320 : 280);
  const open = (place) => !place.closest("details:not([open])"); // what is folded has a size all the same
  function show(place) { // draws it, or draws it again where a flight has passed over it
    if (!open(place) || (drawn.has(place) && !stale.has(place))) return;
    try {
      if (drawn.has(place)) renew(place);
      else draw(place);
      stale.delete(place);
    } catch (error) {
      place.textContent = `This plot cannot be drawn: ${error.message}`;
      place.classList.add("problem");
      throw error;
    }
  }
  const places = [...document.querySelectorAll(".plot")];
  const stale = new Set();
  const resized = new ResizeObserver((entries) => {
    if (printing) return;
    for (const { target } of entries) {
      const u = drawn.get(target);
      if (u && open(target) && u.width !== width(target)) u.setSize({ width: width(target), height: height(target) });
    }
  });
  // Drawn is what is near the screen; the others when they come near it.
  const near = (place) => open(place) && place.getBoundingClientRect().top < 1.3 * innerHeight;
  const seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      visible[isIntersecting ? "add" : "delete"](target);
      if (!isIntersecting || printing) continue;
      show(target);
      if (drawn.has(target)) pass(looked, [drawn.get(target)]); // it has come after the others
    }
  }, { rootMargin: "30% 0px" });
  const again = () => drawn.forEach((_, place) => draw(place));
  dark.addEventListener("change", again);
  document.addEventListener("before", () => { // what is shown now stays, pale
    for (const plot of page.plots) {
      const shown = columns(plot), known = shown.slice(1).map((y) => y.filter((v) => v !== null));
      const ends = known.flatMap((y) => (y.length ? [y.reduce((a, b) => Math.min(a, b)), y.reduce((a, b) => Math.max(a, b))] : []));
      plot.before = { columns: shown, ends };
    }
  });
  document.addEventListener("flown", ({ detail }) => { // a live page has flown again
    page.faults = detail.faults;
    page.phases = detail.phases || page.phases; // those of the timeline stay
    page.plots.forEach((plot, i) => Object.assign(plot, detail.plots[i]));
    drawn.forEach((_, place) => stale.add(place));
    visible.forEach(show);
  });
  let opened = [];
  addEventListener("beforeprint", () => {
    if (printing) return;
    printing = true;
    opened = [...document.querySelectorAll("details.paper:not([open])")];
    opened.forEach((details) => { details.open = true; });
    uPlot.resolution(2); // paper shows more than a screen
    drawn.forEach((_, place) => draw(place));
    places.forEach(show);
  });
  addEventListener("afterprint", () => {
    printing = false;
    opened.forEach((details) => { details.open = false; });
    uPlot.resolution(window.devicePixelRatio || 1);
    again();
  });
  addEventListener("resize", () => { // a change of the browser's magnification, too
    if (!printing) uPlot.resolution(window.devicePixelRatio || 1);
  });
  for (const place of places) {
    place.style.minHeight = `${height(place)}px`; // nothing moves when it is drawn
    const label = document.createElement("div");
    label.className = "ylabel";
    label.textContent = page.plots[place.dataset.plot].label;
    place.prepend(label);
  }
  places.forEach((place) => { resized.observe(place); seen.observe(place); });
})();
