// Put into the head of a copy of a page: works its charts as a hand would and tells its frame what came of it.
(() => {
"use strict";
const told = { errors: [], charts: 0, drawings: 0, empty: [], zoomed: 0, pointed: 0, wrong: [], overlapping: [], saved: [] };
addEventListener("error", (event) => told.errors.push(String(event.message)));
addEventListener("securitypolicyviolation", (event) => told.errors.push(`forbidden: ${event.blockedURI}`));

const fire = (svg, name, share, more) => {
  const box = svg.getBoundingClientRect();
  const values = { bubbles: true, cancelable: true, clientX: box.left + share * box.width, clientY: box.top + box.height / 2, button: 0, pointerId: 1, ...more };
  svg.dispatchEvent(name === "wheel" ? new WheelEvent(name, values) : new PointerEvent(name, values));
};
const numbers = (svg) => svg.querySelector(".plot").getAttribute("viewBox").split(" ").map(Number);
const ticks = (svg) => [...svg.querySelectorAll("text.x")].map((text) => text.textContent).join(" ");
const near = (a, b) => Math.abs(a - b) < 150;

const overlaps = (svg, name) => {
  for (const [kind, from, to] of [["text.x", "left", "right"], ["text.y", "top", "bottom"]]) {
    const boxes = [...svg.querySelectorAll(kind)].map((text) => text.getBoundingClientRect()).sort((a, b) => a[from] - b[from]);
    for (let k = 1; k < boxes.length; k++) {
      if (boxes[k][from] < boxes[k - 1][to] - (kind === "text.y" ? 6 : 0)) { told.overlapping.push(`${name}: ${kind}`); break; }
    }
  }
};

const work = (svg) => {
  const name = svg.closest("figure").dataset.name, box = svg.getBoundingClientRect(), drawn = svg.querySelectorAll(".plot > *");
  told.charts++;
  const seen = [...drawn].some((one) => { const own = one.getBBox(); return own.width > 0 || own.height > 0; });
  if (box.width < 150 || box.height < 40 || !seen) told.empty.push(name);
  overlaps(svg, name);
  fire(svg, "pointermove", 0.5);
  const shown = [...svg.closest("figure").querySelectorAll("output")];
  const line = svg.querySelector(".cursor").getAttribute("visibility") === "visible";
  if (line && shown.some((output) => output.textContent !== "")) told.pointed++;
  if (!line) told.wrong.push(`${name}: no cursor`);
  if ("still" in svg.dataset) return;
  const whole = numbers(svg), before = ticks(svg);
  fire(svg, "pointerdown", 0.25);
  fire(svg, "pointermove", 0.5);
  fire(svg, "pointerup", 0.5);
  const part = numbers(svg);
  if (near(part[0], 2500) && near(part[2], 2500) && ticks(svg) !== before) told.zoomed++; else told.wrong.push(`${name}: drag gave ${part}`);
  overlaps(svg, `${name}, zoomed`);
  fire(svg, "wheel", 0.5, { ctrlKey: true, deltaY: -100 });
  if (!(numbers(svg)[2] < part[2])) told.wrong.push(`${name}: wheel gave ${numbers(svg)}`);
  svg.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
  if (String(numbers(svg)) !== String(whole) || ticks(svg) !== before) told.wrong.push(`${name}: reset gave ${numbers(svg)}`);
  fire(svg, "pointerleave", 0.5);
};

addEventListener("load", () => {
  document.querySelectorAll("details").forEach((fold) => { fold.open = true; });
  const live = [...document.querySelectorAll("svg.live")];
  live.forEach(work);
  told.drawings = document.querySelectorAll(".drawing > svg").length;
  const blobs = [];
  // Its text at once: a page on a busy machine may be asked before a promise is kept.
  globalThis.Blob = class { constructor(parts) { this.whole = parts.join(""); } };
  URL.createObjectURL = (blob) => { blobs.push(blob); return "#"; };
  URL.revokeObjectURL = () => {};
  HTMLAnchorElement.prototype.click = () => {};
  for (const figure of document.querySelectorAll("figure.chart, figure.drawing")) {
    const button = [...figure.querySelectorAll("button")].find((one) => one.textContent === "SVG");
    if (!button) { told.wrong.push(`${figure.dataset.name}: no button`); continue; }
    button.click();
  }
  for (const blob of blobs) {
    const picture = new DOMParser().parseFromString(blob.whole, "image/svg+xml");
    if (picture.querySelector("parsererror")) told.wrong.push("a saved picture does not parse");
    told.saved.push(blob.whole.length);
  }
  told.copies = [...document.querySelectorAll("button")].filter((one) => one.textContent === "Copy").length;
  told.tables = document.querySelectorAll("table").length;
  told.unnamed = [...document.querySelectorAll("svg[role=img]")].filter((svg) => !svg.getAttribute("aria-label")).length;
  told.width = innerWidth;
  told.dark = matchMedia("(prefers-color-scheme: dark)").matches;
  told.wider = document.documentElement.scrollWidth - innerWidth;
  told.requests = performance.getEntriesByType("resource").map((entry) => entry.name);
  parent.postMessage(JSON.stringify(told), "*");
});
})();
