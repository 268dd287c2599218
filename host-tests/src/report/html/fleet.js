// Filters and orders the rows of a fleet.
(() => {
"use strict";
document.documentElement.classList.add("scripted");
const table = document.getElementById("fleet"), body = table.tBodies[0];
const rows = [...body.rows], told = document.getElementById("shown");
const form = document.getElementById("filters");
form.hidden = false;

function filter() {
  const wanted = new FormData(form);
  const text = wanted.get("text").trim().toLowerCase();
  const fits = row =>
    (!wanted.get("standing") || row.dataset.standing === wanted.get("standing")) &&
    (!wanted.get("effect") || row.dataset.effects.split(" ").includes(wanted.get("effect"))) &&
    (!wanted.get("serial") || row.dataset.serial === wanted.get("serial")) &&
    row.textContent.toLowerCase().includes(text);
  let count = 0;
  for (const row of rows) {
    row.hidden = !fits(row);
    count += row.hidden ? 0 : 1;
  }
  for (const probe of document.querySelectorAll("[data-probe]")) {
    probe.hidden = Boolean(wanted.get("serial")) && probe.dataset.probe !== wanted.get("serial");
  }
  told.textContent = count + " of " + rows.length + (rows.length === 1 ? " recording" : " recordings");
}

// Numbers by their size, texts by their letters; what has no value comes last.
function order(header) {
  const column = header.cellIndex;
  const up = header.getAttribute("aria-sort") !== "ascending";
  for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
  header.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => row.cells[column].dataset.key ?? "";
  const compared = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === "" || y === "") return x === y ? 0 : x === "" ? 1 : -1;
    const byNumber = Number(x) - Number(y);
    return (up ? 1 : -1) * (Number.isNaN(byNumber) ? x.localeCompare(y) : byNumber);
  };
  body.append(...rows.sort(compared));
}

for (const button of table.querySelectorAll("th button")) {
  button.disabled = false;
  button.addEventListener("click", () => order(button.parentNode));
}
form.addEventListener("input", filter);
form.addEventListener("reset", () => setTimeout(filter));
form.addEventListener("submit", event => event.preventDefault());
filter();
window.fleet = { filter };
})();
