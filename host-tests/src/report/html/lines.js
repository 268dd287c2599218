// Lines of the page: unpacked once, and thinned to what the screen can show of a span.
const lines = (() => {
"use strict";
const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
// Values of a series; no value is NaN.
const unpacked = ([middle, step, text]) =>
  Float64Array.from(new Int16Array(bytes(text)), n => n === -32768 ? NaN : middle + step * n);

// Times, from a start on.
const timesOf = (text, start) => Float64Array.from(new Int32Array(bytes(text)), t => start + t * 1e-4);

// Times of a thinned line: a quarter and three quarters of each stretch.
const even = (count, [start, end]) => Float64Array.from({ length: count }, (_, k) =>
  start + (end - start) * ((k >> 1) + (k & 1 ? 0.75 : 0.25)) / (count / 2));

// A line as times, values and deviations; wherever it is broken there is a value that is NaN. `times` has those of a line that
// was not thinned, `span` those of the page.
function line(series, isAngle, times, span) {
  const y = unpacked(series.y), s = series.s && unpacked(series.s);
  const isEven = series.t === null;
  const x = isEven ? even(y.length, span) : times;
  const out = [[], [], []];
  const put = (t, value, sigma) => { out[0].push(t); out[1].push(value); out[2].push(sigma); };
  let last = -1;
  for (let k = 0; k < y.length; k++) {
    if (Number.isNaN(y[k])) {
      if (isEven || last === k - 1) put(x[k], NaN, 0);
      continue;
    }
    if (last >= 0) {
      const wraps = isAngle && Math.abs(y[k] - y[last]) > 180 && !(isEven && (k & 1));
      if (wraps || x[k] - x[last] > series.bridged) put((x[k] + x[last]) / 2, NaN, 0);
    }
    put(x[k], y[k], s ? s[k] : 0);
    last = k;
  }
  const [t, values, sigmas] = out.map(column => Float64Array.from(column));
  return { x: t, y: values, s: sigmas };
}

// First place whose time is not before t.
function from(x, t) {
  let low = 0, high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
}

// What a line shows of a span of time, as times, values, deviations and the places of the least and the largest value of
// their column, for uPlot: of each column of pixels these two in their order. Columns begin at multiples of their width,
// so that they stay when the span moves.
function thinned({ x, y, s }, { min, max }, columns) {
  let k = Math.max(0, from(x, min) - 1);
  const end = Math.min(x.length, from(x, max) + 1);
  const out = { x: [], y: [], s: [], edges: [] };
  const put = (t, i, edges) => {
    out.x.push(t);
    out.y.push(i < 0 ? null : y[i]);
    out.s.push(i < 0 ? null : s[i]);
    out.edges.push(i < 0 ? null : edges);
  };
  if (end - k <= 2 * columns) {
    for (; k < end; k++) put(x[k], Number.isNaN(y[k]) ? -1 : k, [y[k], y[k]]);
    return out;
  }
  const width = (max - min) / columns;
  while (k < end) {
    const column = Math.floor(x[k] / width);
    let low = -1, high = -1, isBroken = false, isBrokenAfter = false;
    for (; k < end && x[k] < (column + 1) * width; k++) {
      if (Number.isNaN(y[k])) {
        if (low < 0) isBroken = true;
        isBrokenAfter = true;
        continue;
      }
      isBrokenAfter = false;
      if (low < 0 || y[k] < y[low]) low = k;
      if (high < 0 || y[k] > y[high]) high = k;
    }
    if (isBroken) put(column * width, -1);
    if (low < 0) continue;
    const edges = [y[low], y[high]];
    put((column + 0.25) * width, Math.min(low, high), edges);
    put((column + 0.75) * width, Math.max(low, high), edges);
    if (isBrokenAfter) put((column + 0.9) * width, -1);
  }
  return out;
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

return { unpacked, timesOf, line, from, thinned, near };
})();
