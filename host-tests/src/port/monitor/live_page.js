// Asks twice a second what the probe has said, and shows it.
(() => {
"use strict";
const names = ["Inclination", "Azimuth", "Toolface"], kept_s = 600;
const byId = id => document.getElementById(id);
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
let times = [], angles = [[], [], []], last = null, heard = Date.now(), plots = [];

function build() {
  byId("plots").replaceChildren();
  plots = names.map((name, k) => {
    const figure = document.createElement("figure"), head = document.createElement("h3");
    head.textContent = name + ", deg";
    figure.append(head);
    byId("plots").append(figure);
    const axis = { stroke: colour("--quiet"), font: "12px system-ui, sans-serif", grid: { stroke: colour("--grid"), width: 1 } };
    return new uPlot({
      width: figure.clientWidth, height: 200, legend: { show: false }, scales: { x: { time: false } },
      axes: [{ ...axis, size: 34, values: (_, ticks) => ticks.map(tick => tick + " s") }, { ...axis, size: 58 }],
      series: [{}, { stroke: colour("--after"), width: 1.4 }],
    }, [times, angles[k]], figure);
  });
}

function show(said) {
  if (said.t_s !== last) heard = Date.now();
  if (said.angles && said.t_s !== last) {
    // The probe has begun anew.
    if (said.t_s < last) { times = []; angles = [[], [], []]; }
    times.push(said.t_s);
    said.angles.deg.forEach((angle, k) => {
      const before = angles[k][angles[k].length - 1];
      // A line that passes north breaks.
      angles[k].push(k > 0 && before !== null && Math.abs(before - angle) > 180 ? null : angle);
    });
    while (times.length && times[0] < said.t_s - kept_s) { times.shift(); angles.forEach(angle => angle.shift()); }
    plots.forEach((plot, k) => plot.setData([times, angles[k]]));
  }
  last = said.t_s;
  if (said.angles) {
    byId("tiles").replaceChildren(...names.map((name, k) => {
      const tile = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = k === 2 ? `${name} (${said.angles.toolface})` : name;
      dd.textContent = `${said.angles.deg[k].toFixed(2)}° ± ${said.angles.sigma_deg[k].toFixed(2)}°`;
      tile.append(dt, dd);
      return tile;
    }));
    const pointer = byId("pointer");
    pointer.setAttribute("transform", `rotate(${said.angles.deg[2]})`);
    pointer.setAttribute("visibility", "visible");
  }
  byId("lines").textContent = said.lines.join("\n") || "nothing yet";
  const silent_s = (Date.now() - heard) / 1000;
  const flags = said.angles && said.angles.flags ? "; " + said.angles.flags : "";
  byId("age").textContent = said.lines.length
    ? `probe's time ${said.t_s.toFixed(1)} s` + (silent_s > 3 ? `; silent for ${silent_s.toFixed(0)} s` : "") + flags
    : "waiting for the probe";
}

async function ask() {
  try { show(await (await fetch("/state")).json()); }
  catch { byId("age").textContent = "the monitor has ended"; }
  setTimeout(ask, 500);
}
build();
window.addEventListener("resize", build);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
ask();
})();
