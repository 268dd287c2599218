// Draws every plot of the page anew with uPlot, so that it can be zoomed; all share one span of time.
(() => {
"use strict";
const root = document.documentElement;
root.classList.add("scripted");
// Data of the page, the whole span and the part that is shown, and the plots; `load` sets them.
let page, whole, shown, times;
const plots = [];
const timesAt = k => times[k] ||= lines.timesOf(page.times[k], page.span[0]);

const palette = {};
const colour = name => palette[name] ||= getComputedStyle(root).getPropertyValue(name).trim();
const faint = (hex, share) => hex + Math.round(255 * share).toString(16).padStart(2, "0");

const digits = x => {
  if (x === null || x === undefined || Number.isNaN(x)) return "";
  if (x === 0) return "0";
  const decimals = Math.min(6, Math.max(0, 3 - Math.floor(Math.log10(Math.abs(x)))));
  return x.toFixed(decimals).replace(/^-(0\.?0*)$/, "$1");
};

// A place on the axis that all plots share: a day since 1970 as its date, else a number with its unit.
const place = x => page.over === "date" ? new Date(x * 864e5).toISOString().slice(0, 10) : +x.toPrecision(8) + " " + page.over;
const placeRead = x => page.over === "date" ? place(x) : digits(x) + " " + page.over;

// What a plot shows of the span now, as columns of uPlot: for each series its values and, with deviations, the edges of two
// bands. The range of its axis goes with it.
function viewed(plot) {
  const { chart } = plot;
  plot.lines ||= chart.series.map(one => lines.line(one, chart.angle, one.t === null ? null : timesAt(one.t), page.span));
  const columns = Math.max(50, plot.place.clientWidth - 70);
  const seen = plot.lines.map(one => lines.thinned(one, shown, columns));
  plot.range = rangeOf(chart, seen);
  // Lines of one pixel are drawn ten times as fast as wider ones, which look better where points are few.
  plot.wide = seen.some(one => one.x.length > 300) ? 1 : 1.5;
  const tables = seen.map(({ x, y, s, edges }, k) => {
    const table = [x, y];
    if (hasBands(chart.series[k])) {
      for (const wide of [1, -1, 2, -2]) {
        table.push(edges.map((both, i) => both && both[wide > 0 ? 1 : 0] + wide * s[i]));
      }
    }
    return table;
  });
  const sameTimes = tables.every(table => same(table[0], tables[0][0]));
  return sameTimes ? [tables[0][0], ...tables.flatMap(table => table.slice(1))] : uPlot.join(tables);
}

const hasBands = series => Boolean(series.s) && !series.marked;

const isAll = () => shown.max - shown.min > 0.999 * (whole.max - whole.min);

// The axis of the whole time leaves out rare large values; that of a part of it spans all that the part has.
function rangeOf(chart, seen) {
  if (isAll() || chart.whole) return chart.range;
  let low = Infinity, high = -Infinity, sum = 0, count = 0;
  seen.forEach(({ x, y, s }, k) => y.forEach((value, i) => {
    if (value === null || x[i] < shown.min || x[i] > shown.max) return;
    const wide = chart.series[k].marked ? s[i] : 0;
    low = Math.min(low, value - wide);
    high = Math.max(high, value + wide);
    if (hasBands(chart.series[k])) { sum += s[i]; count++; }
  }));
  if (low > high) return chart.range;
  if (chart.angle && high - low > 90) return chart.range;
  for (const level of chart.levels) { low = Math.min(low, level); high = Math.max(high, level); }
  if (chart.size) return [0, high > 0 ? 1.1 * high : 1];
  // Bands of two deviations of the usual size fit.
  const margin = Math.max(0.05 * (high - low), count ? 2.2 * sum / count : 0, 1e-6 * Math.max(Math.abs(low), Math.abs(high)), 1e-9);
  return [low - margin, high + margin];
}

function build(plot) {
  const { chart } = plot, data = viewed(plot);
  const series = [{ label: page.over }], bands = [];
  for (const one of chart.series) {
    const stroke = colour("--" + one.class);
    const at = series.length;
    series.push({
      // Lines through marked points are drawn with these.
      label: one.name, stroke, width: one.marked ? 0 : plot.wide, spanGaps: false,
      points: { show: false },
    });
    if (hasBands(one)) {
      for (let edge = 0; edge < 4; edge++) {
        series.push({ label: one.name + " band", width: 0, points: { show: false }, spanGaps: false });
      }
      bands.push({ series: [at + 3, at + 4], fill: faint(stroke, 0.12) });
      bands.push({ series: [at + 1, at + 2], fill: faint(stroke, 0.22) });
    }
  }
  const axis = { stroke: colour("--quiet"), font: "12px system-ui, sans-serif", grid: { stroke: colour("--grid"), width: 1 }, ticks: { stroke: colour("--grid"), width: 1, size: 4 } };
  const options = {
    width: plot.place.clientWidth, height: window.innerWidth < 600 ? 200 : 240,
    legend: { show: false }, series, bands,
    scales: { x: { time: false, range: (_, min, max) => [min, max] }, y: { range: () => plot.range } },
    axes: [
      { ...axis, size: 34, space: page.over === "date" ? 100 : 70, ...(page.over === "date" ? { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000] } : {}), values: (_, ticks) => ticks.map(place) },
      // As wide as its labels: letters of 12 pixels are 7 wide.
      { ...axis, size: (_, ticks) => Math.max(58, 16 + 7 * Math.max(0, ...(ticks || []).map(tick => tick.length))), space: 36, ...(chart.whole ? { incrs: [1, 2, 5] } : {}), ...(chart.angle ? { incrs: [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 90] } : {}), values: (_, ticks) => ticks.map(tick => String(+tick.toPrecision(8))) },
    ],
    cursor: {
      drag: { x: true, y: false, setScale: false }, points: { size: 6 }, focus: { prox: -1 },
      // The time that one plot points at is pointed at in all; what is dragged is one plot's own.
      sync: { key: "report", filters: { pub: type => type === "mousemove" || type === "mouseleave" } },
    },
    hooks: {
      drawClear: [u => shade(u, plot.chart)],
      draw: [u => drawOver(u, plot.chart, plot)],
      setCursor: [u => { if (plot.isSeen) read(plot, u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null); }],
      setSelect: [u => {
        if (u.select.width > 3) show(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
        u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
      }],
    },
  };
  if (plot.u) plot.u.destroy();
  plot.u = new uPlot(options, data, plot.place);
  plot.u.over.addEventListener("dblclick", actions.all);
  plot.place.querySelectorAll(".uplot *").forEach(node => node.setAttribute("aria-hidden", "true"));
  plot.u.setScale("x", shown);
  plot.isOld = false;
}

// Draws the span that is shown now.
function draw(plot) {
  plot.u.batch(() => {
    plot.u.setData(viewed(plot), false);
    for (const series of plot.u.series) if (series.width > 0) series.width = plot.wide;
    plot.u.setScale("x", shown);
  });
  plot.isOld = false;
}

const same = (a, b) => a === b || a.length === b.length && a.every((x, k) => x === b[k]);

function shade(u, chart) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = colour("--shade");
  for (const [from, to] of chart.marks) {
    if (to < shown.min || from > shown.max) continue;
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
  // Points with their deviations and the line through them. Of several series those of one time stand beside each other.
  const areBeside = chart.series.length > 2 && chart.series.some(series => series.s);
  chart.series.forEach((series, k) => {
    if (!series.marked) return;
    ctx.strokeStyle = ctx.fillStyle = colour("--" + series.class);
    const { x, y, s } = plot.lines[k];
    const beside = areBeside ? besideOf(u, x, chart.series.length) * (k - (chart.series.length - 1) / 2) * devicePixelRatio : 0;
    ctx.beginPath();
    let isBroken = true;
    x.forEach((t, i) => {
      if (!Number.isNaN(y[i])) {
        ctx[isBroken ? "moveTo" : "lineTo"](u.valToPos(t, "x", true) + beside, u.valToPos(y[i], "y", true));
      }
      isBroken = Number.isNaN(y[i]);
    });
    ctx.stroke();
    x.forEach((t, i) => {
      if (Number.isNaN(y[i]) || t < shown.min || t > shown.max) return;
      const at = u.valToPos(t, "x", true) + beside;
      ctx.beginPath();
      ctx.moveTo(at, u.valToPos(y[i] - s[i], "y", true));
      ctx.lineTo(at, u.valToPos(y[i] + s[i], "y", true));
      ctx.stroke();
      ctx.beginPath();
      ctx.arc(at, u.valToPos(y[i], "y", true), 3 * devicePixelRatio, 0, 2 * Math.PI);
      ctx.fill();
    });
  });
  ctx.restore();
}

// Step between points of several series at one time, pixels: less where points of one series are near one another, so that none
// passes its neighbour.
function besideOf(u, x, count) {
  const seen = x.filter(t => t >= shown.min && t <= shown.max);
  if (seen.length < 2) return 7;
  const apart = u.over.clientWidth * (seen[seen.length - 1] - seen[0]) / (shown.max - shown.min) / (seen.length - 1);
  return Math.min(7, apart / count);
}

// Values at a time beside the names, and what is marked there. Those of the plot that has the focus are spoken.
function read(plot, t) {
  const { chart, figure } = plot;
  figure.querySelectorAll(".legend output").forEach((output, k) => {
    let text = "";
    if (t !== null && chart.series[k]) {
      const { x, y, s } = plot.lines[k];
      let i = lines.near(x, t);
      if (i >= 0 && Number.isNaN(y[i])) i = y[i + 1] >= -Infinity ? i + 1 : y[i - 1] >= -Infinity ? i - 1 : -1;
      if (i >= 0 && Math.abs(x[i] - t) <= Math.max(chart.series[k].bridged, (shown.max - shown.min) / 50)) {
        text = " " + digits(y[i]) + (chart.series[k].s ? " ± " + digits(s[i]) : "") + " " + chart.unit;
      }
    }
    output.textContent = text;
  });
  const there = t === null ? [] : chart.marks.filter(([from, to]) => t >= from && t <= to).map(mark => mark[2]);
  const note = t === null ? "" : placeRead(t) + (there.length ? ": " + there.join("; ") : "");
  figure.querySelector(".note").textContent = note;
  if (document.activeElement === plot.place) {
    const values = [...figure.querySelectorAll(".legend > span:not(.level)")].map(one => one.textContent);
    document.querySelector(".spoken").textContent = [note, ...values].join(", ");
  }
}

// Shows a span of time in every plot, with the next frame: at once where it can be seen, else when it comes into view.
let isAsked = false;
function show(min, max) {
  const least = (whole.max - whole.min) * 1e-4, most = whole.max - whole.min;
  const width = Math.min(most, Math.max(least, max - min));
  min = Math.min(Math.max(min, whole.min), whole.max - width);
  shown = { min, max: min + width };
  document.querySelectorAll(".bar .span").forEach(output => {
    output.textContent = page.over === "date"
      ? place(shown.min) + " to " + place(shown.max) : digits(shown.min) + " to " + digits(shown.max) + " " + page.over;
  });
  for (const plot of plots) plot.isOld = true;
  if (!isAsked) requestAnimationFrame(() => { isAsked = false; drawSeen(); });
  isAsked = true;
}

function drawSeen() {
  for (const plot of plots) if (plot.isSeen && plot.u && plot.isOld) draw(plot);
  turns();
}

// The toolface as a dial, of the span that is shown: from the middle to the rim.
function turns() {
  const turns = document.querySelector(".dial .turns");
  if (!turns || !page.dial) return;
  page.dial.x ||= lines.timesOf(page.dial.t, page.span[0]);
  page.dial.degrees ||= lines.unpacked(page.dial.y);
  const { x, degrees: y } = page.dial;
  // The last moment of the span is in it: times are rounded to a tenth of a millisecond.
  const points = [], first = lines.from(x, shown.min), end = lines.from(x, shown.max + 1e-4);
  const step = Math.max(1, Math.ceil((end - first) / 240));
  for (let k = end - 1; k >= first; k -= step) if (!Number.isNaN(y[k])) points.unshift([x[k], y[k]]);
  const last = points.length - 1;
  turns.replaceChildren(...points.map(([t, degrees], k) => {
    const circle = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    const radius = 18 + 86 * (t - shown.min) / (shown.max - shown.min), angle = degrees * Math.PI / 180;
    const is = { class: k === last ? "x" : "z", cx: radius * Math.sin(angle), cy: -radius * Math.cos(angle), r: k === last ? 5 : 2 };
    for (const name in is) circle.setAttribute(name, is[name]);
    return circle;
  }));
  turns.closest("figure").querySelector(".note").textContent = last < 0 ? "No toolface in this stretch."
    : placeRead(points[0][0]) + " in the middle, " + placeRead(points[last][0]) + " at the rim: " + digits(points[last][1]) + " deg";
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
    if (plot) plot.isSeen = entry.isIntersecting;
    if (!plot || !plot.isSeen) continue;
    if (!plot.u) build(plot);
    else if (plot.isOld) draw(plot);
  }
}, { rootMargin: "200px" });

// Takes data for the plots that the page has places for. Of data that grow, what was shown stays; the end stays in view.
function load(data) {
  const followed = page && !isAll() ? { ...shown, isEnd: shown.max >= whole.max } : null;
  page = data;
  times = page.times.map(() => null);
  whole = { min: page.span[0], max: Math.max(page.span[1], page.span[0] + 1e-3) };
  shown = { ...whole };
  const had = plots.splice(0);
  page.charts.forEach((chart, number) => {
    const figure = document.getElementById("chart-" + number), place = figure.querySelector(".plot");
    let plot = had.find(plot => plot.place === place);
    if (!plot) {
      plot = { figure, place, u: null, isSeen: false, isOld: false };
      place.addEventListener("keydown", event => pressed(event, plots.find(plot => plot.place === place)));
      watcher.observe(place);
    }
    const form = chart => chart.series.map(series => series.class + hasBands(series)).join();
    const isOther = plot.u && form(plot.chart) !== form(chart);
    plot.chart = chart;
    plot.lines = null;
    if (isOther) build(plot);
    plots.push(plot);
  });
  for (const plot of had.filter(plot => !plots.includes(plot))) {
    watcher.unobserve(plot.place);
    if (plot.u) plot.u.destroy();
  }
  if (!followed) show(whole.min, whole.max);
  else {
    const by = followed.isEnd ? whole.max - followed.max : 0;
    show(followed.min + by, followed.max + by);
  }
}
load(JSON.parse(document.getElementById("data").textContent));
document.querySelectorAll(".bar button").forEach(button => button.addEventListener("click", actions[button.dataset.do]));

function again() {
  for (const name in palette) delete palette[name];
  for (const plot of plots) if (plot.u) build(plot);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
let width = window.innerWidth;
window.addEventListener("resize", () => {
  if (window.innerWidth !== width) { width = window.innerWidth; again(); }
});
// For a page that is live, for tests, and for a reader's own questions in the browser's console.
window.report = { plots, show, load, buildAll: () => plots.forEach(plot => plot.u || build(plot)) };
})();
