// Asks twice a second what the probe has said, and takes it over.
(() => {
"use strict";
const main = document.querySelector("main");
let last = null, heard = Date.now();

// What a part is: two with one name are one, as it was and as it is.
const name = node => node.tagName + [...node.querySelectorAll(":scope > h2, :scope > h3, :scope > .legend > span")]
  .map(part => part.firstChild.textContent).join("|");

// Takes over what differs. A plot stays, with its place and what it points at; its data come beside.
function take(old, fresh) {
  const have = [...old.children], wanted = [...fresh.children];
  if (have.map(name).join() !== wanted.map(name).join()) { old.replaceChildren(...wanted); return; }
  have.forEach((node, k) => {
    const other = wanted[k];
    if (node.tagName === "SECTION") {
      node.setAttribute("aria-labelledby", other.getAttribute("aria-labelledby"));
      take(node, other);
    } else if (node.querySelector(".plot")) {
      node.id = other.id;
      node.querySelector(".about").replaceWith(other.querySelector(".about"));
      node.querySelector(".plot").setAttribute("aria-label", other.querySelector(".plot").getAttribute("aria-label"));
    } else if (!node.isEqualNode(other)) node.replaceWith(other);
  });
}

function parsed(html) {
  const template = document.createElement("template");
  template.innerHTML = html;
  return template.content;
}

function show(said) {
  if (said.t_s !== last) {
    heard = Date.now();
    take(document.getElementById("head"), parsed(said.head));
    take(main.querySelector("nav"), parsed(said.links));
    take(document.getElementById("sections"), parsed(said.sections));
    report.load(said.data);
  }
  last = said.t_s;
  const silent_s = (Date.now() - heard) / 1000;
  document.getElementById("age").textContent = said.t_s === null ? "Waiting for the probe."
    : `Probe's time ${said.t_s.toFixed(1)} s` + (silent_s > 3 ? `; silent for ${silent_s.toFixed(0)} s.` : ".");
}

async function ask() {
  try { show(await (await fetch("/state")).json()); }
  catch { document.getElementById("age").textContent = "The monitor has ended."; }
  setTimeout(ask, 500);
}
ask();
})();
