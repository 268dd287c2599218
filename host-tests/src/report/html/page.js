// Draws every plot of the page anew with uPlot, so that it can be zoomed; all share one span of time.
(() => {
"use strict";
const page = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement;
root.classList.add("scripted");
const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
const whole = { min: page.span[0], max: Math.max(page.span[1], page.span[0] + 1e-3) };
let shown = { ...whole };
const plots = [];
const times = page.times.map(() => null);
const unpackedTimes = k => times[k] ||= Float64Array.from(new Int32Array(bytes(page.times[k])), t => page.span[0] + t * 1e-4);

// Values of a series; no value is NaN.
const unpacked = ([middle, step, text]) =>
  Float64Array.from(new Int16Array(bytes(text)), n => n === -32768 ? NaN : middle + step * n);

// Times of a thinned line: a quarter and three quarters of each stretch.
const even = count => Float64Array.from({ length: count }, (_, k) =>
  page.span[0] + (page.span[1] - page.span[0]) * ((k >> 1) + (k & 1 ? 0.75 : 0.25)) / (count / 2));

// A line as [times, values, deviations], with an empty value wherever it is broken.
function line(series, isAngle) {
  const y = unpacked(series.y), s = series.s && unpacked(series.s);
  const isEven = series.t === null;
  const x = isEven ? even(y.length) : unpackedTimes(series.t);
  const out = [[], [], []];
  const put = (t, value, sigma) => { out[0].push(t); out[1].push(value); out[2].push(sigma); };
  let last = -1;
  for (let k = 0; k < y.length; k++) {
    if (Number.isNaN(y[k])) {
      if (isEven || last === k - 1) put(x[k], null, null);
      continue;
    }
    if (last >= 0) {
      const wraps = isAngle && Math.abs(y[k] - y[last]) > 180 && !(isEven && (k & 1));
      if (wraps || x[k] - x[last] > series.bridged) put((x[k] + x[last]) / 2, null, null);
    }
    put(x[k], y[k], s ? s[k] : null);
    last = k;
  }
  return out;
}

const colour = name => getComputedStyle(root).getPropertyValue(name).trim();
const faint = (hex, share) => hex + Math.round(255 * share).toString(16).padStart(2, "0");

const digits = x => {
  if (x === null || x === undefined || Number.isNaN(x)) return "";
  if (x === 0) return "0";
  const decimals = Math.min(6, Math.max(0, 3 - Math.floor(Math.log10(Math.abs(x)))));
  return x.toFixed(decimals);
};

// A place on the axis that all plots share: a day since 1970 as its date, else a number with its unit.
const place = page.over === "date"
  ? day => new Date(day * 864e5).toISOString().slice(0, 10) : x => +x.toPrecision(8) + " " + page.over;
const placeRead = page.over === "date" ? place : x => digits(x) + " " + page.over;

function build(plot) {
  const { chart } = plot;
  plot.lines ||= chart.series.map(series => line(series, chart.angle));
  // Columns of uPlot: for each series its values and, with deviations, the edges of two bands.
  const tables = [], series = [{ label: page.over }], bands = [];
  plot.columns = [];
  chart.series.forEach((one, k) => {
    const [x, y, s] = plot.lines[k];
    const stroke = colour("--" + one.class);
    const table = [x, y];
    const at = series.length;
    plot.columns.push(at);
    series.push({
      label: one.name, stroke, width: 1.4, spanGaps: false,
      points: { show: one.marked, size: 6, fill: stroke, stroke },
    });
    if (one.s && !one.marked) {
      for (const wide of [1, -1, 2, -2]) {
        table.push(y.map((value, i) => value === null ? null : value + wide * s[i]));
        series.push({ label: one.name + " band", width: 0, points: { show: false }, spanGaps: false });
      }
      bands.push({ series: [at + 3, at + 4], fill: faint(stroke, 0.12) });
      bands.push({ series: [at + 1, at + 2], fill: faint(stroke, 0.22) });
    }
    tables.push(table);
  });
  const sameTimes = tables.every(table => table[0] === tables[0][0] || same(table[0], tables[0][0]));
  const data = tables.length === 1 || sameTimes
    ? [tables[0][0], ...tables.flatMap(table => table.slice(1))] : uPlot.join(tables);
  const axis = { stroke: colour("--quiet"), font: "12px system-ui, sans-serif", grid: { stroke: colour("--grid"), width: 1 }, ticks: { stroke: colour("--grid"), width: 1, size: 4 } };
  const options = {
    width: plot.place.clientWidth, height: window.innerWidth < 600 ? 200 : 240,
    legend: { show: false }, series, bands,
    scales: { x: { time: false, range: (_, min, max) => [min, max] }, y: { range: plot.zoomedY || (() => chart.range) } },
    axes: [
      { ...axis, size: 34, space: page.over === "date" ? 100 : 70, ...(page.over === "date" ? { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000] } : {}), values: (_, ticks) => ticks.map(place) },
      { ...axis, size: 58, space: 36, ...(chart.angle ? { incrs: [1, 2, 5, 10, 30, 90] } : {}), values: (_, ticks) => ticks.map(tick => String(+tick.toPrecision(8))) },
    ],
    cursor: {
      drag: { x: true, y: false, setScale: false }, points: { size: 6 }, focus: { prox: -1 },
      // The time that one plot points at is pointed at in all; what is dragged is one plot's own.
      sync: { key: "report", filters: { pub: type => type === "mousemove" || type === "mouseleave" } },
    },
    hooks: {
      drawClear: [u => shade(u, chart)],
      draw: [u => drawOver(u, chart, plot)],
      setCursor: [u => { if (plot.isSeen) read(plot, u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null); }],
      setSelect: [u => {
        if (u.select.width > 3) show(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
        u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
      }],
    },
  };
  if (plot.u) plot.u.destroy();
  plot.u = new uPlot(options, data, plot.place);
  plot.u.over.addEventListener("dblclick", () => show(whole.min, whole.max));
  plot.place.querySelectorAll(".uplot *").forEach(node => node.setAttribute("aria-hidden", "true"));
  plot.u.setScale("x", shown);
  plot.isOld = false;
}

const same = (a, b) => a.length === b.length && a.every((x, k) => x === b[k]);

function shade(u, chart) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = colour("--shade");
  for (const [from, to] of chart.marks) {
    const left = u.valToPos(from, "x", true), right = u.valToPos(to, "x", true);
    ctx.fillRect(left, bbox.top, Math.max(right - left, 2), bbox.height);
  }
  ctx.restore();
}

function drawOver(u, chart, plot) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.lineWidth = devicePixelRatio;
  ctx.strokeStyle = colour("--quiet");
  ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
  for (const level of chart.levels) {
    const y = u.valToPos(level, "y", true);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.setLineDash([]);
  // Deviations of single points.
  chart.series.forEach((series, k) => {
    if (!series.marked || !series.s) return;
    ctx.strokeStyle = colour("--" + series.class);
    const [x, y, s] = plot.lines[k];
    x.forEach((t, i) => {
      if (y[i] === null) return;
      const at = u.valToPos(t, "x", true);
      ctx.beginPath();
      ctx.moveTo(at, u.valToPos(y[i] - s[i], "y", true));
      ctx.lineTo(at, u.valToPos(y[i] + s[i], "y", true));
      ctx.stroke();
    });
  });
  ctx.restore();
}

// Values at a time beside the names, and what is marked there.
function read(plot, t) {
  const { chart, figure } = plot;
  figure.querySelectorAll(".legend output").forEach((output, k) => {
    let text = "";
    if (t !== null && chart.series[k]) {
      const [x, y, s] = plot.lines[k];
      let i = near(x, t);
      if (i >= 0 && y[i] === null) i = y[i + 1] != null ? i + 1 : y[i - 1] != null ? i - 1 : -1;
      if (i >= 0 && Math.abs(x[i] - t) <= Math.max(chart.series[k].bridged, (shown.max - shown.min) / 50)) {
        text = " " + digits(y[i]) + (chart.series[k].s ? " ± " + digits(s[i]) : "") + " " + chart.unit;
      }
    }
    output.textContent = text;
  });
  const there = t === null ? [] : chart.marks.filter(([from, to]) => t >= from && t <= to).map(mark => mark[2]);
  figure.querySelector(".note").textContent =
    t === null ? "" : placeRead(t) + (there.length ? ": " + there.join("; ") : "");
}

// Place of the time that is nearest.
function near(x, t) {
  let low = 0, high = x.length - 1;
  if (high < 0) return -1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (x[middle] < t) low = middle; else high = middle;
  }
  return Math.abs(x[low] - t) <= Math.abs(x[high] - t) ? low : high;
}

// Shows a span of time in every plot: at once where it can be seen, else when it comes into view.
function show(min, max) {
  const least = (whole.max - whole.min) * 1e-4, most = whole.max - whole.min;
  const width = Math.min(most, Math.max(least, max - min));
  min = Math.min(Math.max(min, whole.min), whole.max - width);
  shown = { min, max: min + width };
  document.querySelectorAll(".bar .span").forEach(output => {
    output.textContent = page.over === "date"
      ? place(shown.min) + " to " + place(shown.max) : digits(shown.min) + " to " + digits(shown.max) + " " + page.over;
  });
  for (const plot of plots) {
    if (plot.isSeen && plot.u) plot.u.setScale("x", shown); else plot.isOld = true;
  }
}

function move(share) { const width = shown.max - shown.min; show(shown.min + share * width, shown.max + share * width); }
function zoom(factor) {
  const middle = (shown.min + shown.max) / 2, half = factor * (shown.max - shown.min) / 2;
  show(middle - half, middle + half);
}
const actions = {
  earlier: () => move(-0.25), later: () => move(0.25), closer: () => zoom(0.5), wider: () => zoom(2),
  all: () => show(whole.min, whole.max),
};

// Arrows read values, with Shift they move the span; + and - zoom.
function pressed(event, plot) {
  const { u } = plot;
  if (!u || event.ctrlKey || event.metaKey || event.altKey) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (step && event.shiftKey) move(0.1 * step);
  else if (step) {
    const width = u.over.clientWidth;
    const from = u.cursor.left >= 0 ? u.cursor.left : width / 2;
    const left = Math.min(Math.max(from + step * width / 100, 0), width);
    // As if it were pointed at, so that the other plots follow.
    u.setCursor({ left, top: u.over.clientHeight / 2 }, true, true);
  } else if (event.key === "+" || event.key === "=") zoom(0.5);
  else if (event.key === "-") zoom(2);
  else if (event.key === "Home" || event.key === "0") actions.all();
  else return;
  event.preventDefault();
}

const watcher = new IntersectionObserver(entries => {
  for (const entry of entries) {
    const plot = plots.find(plot => plot.place === entry.target);
    plot.isSeen = entry.isIntersecting;
    if (!plot.isSeen) continue;
    if (!plot.u) build(plot);
    else if (plot.isOld) { plot.u.setScale("x", shown); plot.isOld = false; }
  }
}, { rootMargin: "200px" });

page.charts.forEach((chart, number) => {
  const figure = document.getElementById("chart-" + number);
  const plot = { chart, figure, place: figure.querySelector(".plot"), u: null, isSeen: false, isOld: false };
  plots.push(plot);
  plot.place.addEventListener("keydown", event => pressed(event, plot));
  watcher.observe(plot.place);
});
document.querySelectorAll(".bar button").forEach(button => button.addEventListener("click", actions[button.dataset.do]));
show(whole.min, whole.max);

function again() { for (const plot of plots) if (plot.u) build(plot); }
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
let width = window.innerWidth;
window.addEventListener("resize", () => {
  if (window.innerWidth !== width) { width = window.innerWidth; again(); }
});
// For tests, and for a reader's own questions in the browser's console.
window.report = { plots, show, buildAll: () => plots.forEach(plot => plot.u || build(plot)) };
})();
