(() => {
"use strict";
// The grid on which the curves lie; a nested picture shows a part of it.
const WIDE = 10000, HIGH = 5000;
const make = (parent, name, values, text) => {
  const element = document.createElementNS(parent.namespaceURI, name);
  for (const key in values) element.setAttribute(key, values[key]);
  if (text !== undefined) element.textContent = text;
  return parent.appendChild(element);
};
const nice = (step) => {
  const power = 10 ** Math.floor(Math.log10(step));
  return power * ([1, 2, 5].find((factor) => factor * power >= step * (1 - 1e-9)) || 10);
};
const ticks = (from, to, count) => {
  const step = nice((to - from) / count), power = Math.floor(Math.log10(step) + 1e-9), list = [];
  const largest = Math.max(Math.abs(from), Math.abs(to)), limit = (digits) => Math.min(9, Math.max(0, digits));
  const number = (tick) => {
    if (largest >= 1e-4 && largest < 1e6) return tick.toFixed(limit(-power)).replace(/^-(?=[0.]*$)/, "");
    const size = Math.abs(tick);
    return size < step / 2 ? "0" : tick.toExponential(limit(Math.floor(Math.log10(size) + 1e-9) - power)).replace("+", "");
  };
  for (let k = Math.ceil(from / step - 1e-6); k * step <= to + 1e-6 * step; k++) {
    list.push([k * step, number(k * step).replaceAll("-", "\u2212")]);
  }
  return list;
};
const spoken = (value) => {
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(3) : String(Number(value.toPrecision(4)));
  return text.replace("-", "\u2212");
};

class Chart {
  constructor(svg) {
    this.svg = svg;
    this.figure = svg.closest("figure");
    this.plot = svg.querySelector(".plot");
    this.grid = svg.querySelector(".grid");
    this.drawn = this.grid.innerHTML;
    this.whole = this.plot.getAttribute("viewBox");
    this.x = svg.dataset.x.split(" ").map(Number);
    this.y = svg.dataset.y.split(" ").map(Number);
    this.high = "rows" in svg.dataset ? this.y[1] : HIGH;
    this.curves = [...this.plot.querySelectorAll("[data-curve]")].map((path) => ({
      path, shown: this.figure.querySelector(`output[data-curve="${path.dataset.curve}"]`),
    }));
    this.notes = [...svg.querySelectorAll(".note")].map((note) => [note, note.getAttribute("x"), note.getAttribute("y")]);
    this.line = make(svg, "line", { class: "cursor", y2: "100%", visibility: "hidden" });
    this.time = make(svg, "text", { class: "note", y: -1, "text-anchor": "middle", visibility: "hidden" });
    this.chosen = make(svg, "rect", { class: "chosen", height: "100%", width: 0 });
    this.view = [0, 1];
  }
  // Places along the grid with the height of the curve there; NaN breaks it.
  points(curve) {
    if (!curve.points) {
      curve.points = [];
      for (const run of curve.path.getAttribute("d").split("M").slice(1)) {
        const numbers = (run.match(/-?\d+/g) || []).map(Number);
        let [x, y] = numbers;
        curve.points.push([x, y]);
        if (run.includes("h")) continue;
        for (let k = 2; k + 1 < numbers.length; k += 2) curve.points.push([x += numbers[k], y += numbers[k + 1]]);
        curve.points.push([x, NaN]);
      }
    }
    return curve.points;
  }
  // Height of a curve at a place, or undefined where there is none.
  at(curve, place) {
    const points = this.points(curve);
    let low = 0, high = points.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (points[middle][0] < place) low = middle + 1; else high = middle;
    }
    const before = points[low - 1], behind = points[low];
    if (curve.path.classList.contains("dots")) {
      const near = [before, behind].filter((point) => point && Math.abs(point[0] - place) < 100);
      near.sort((a, b) => Math.abs(a[0] - place) - Math.abs(b[0] - place));
      return near.length ? near[0][1] : undefined;
    }
    if (!before || !behind) return behind && behind[0] === place ? behind[1] : undefined;
    const span = behind[0] - before[0];
    const value = span > 0 ? before[1] + (behind[1] - before[1]) * (place - before[0]) / span : behind[1];
    return Number.isNaN(value) ? undefined : value;
  }
  value(height) {
    const value = this.y[1] - (this.y[1] - this.y[0]) * height / HIGH;
    return "log" in this.svg.dataset ? 10 ** value : value;
  }
  // Lowest and highest place that the curves reach in a part of the chart.
  reach(from, to) {
    let low = Infinity, high = -Infinity;
    for (const curve of this.curves) {
      const ends = [this.at(curve, from), this.at(curve, to)].filter((height) => height !== undefined);
      for (const [x, y] of this.points(curve)) if (x >= from && x <= to && !Number.isNaN(y)) ends.push(y);
      for (const y of ends) { low = Math.min(low, y); high = Math.max(high, y); }
    }
    if (!(high > low)) return [0, HIGH];
    const rim = Math.max(0.06 * (high - low), 8);
    return [low - rim, high + rim];
  }
  show(view) {
    this.view = view;
    const whole = view[0] === 0 && view[1] === 1;
    if (whole) {
      this.plot.setAttribute("viewBox", this.whole);
      this.grid.innerHTML = this.drawn;
      for (const [note, x, y] of this.notes) { note.setAttribute("x", x); note.setAttribute("y", y); note.style.display = ""; }
      return;
    }
    const from = view[0] * WIDE, to = view[1] * WIDE;
    const [top, bottom] = "fixed" in this.svg.dataset ? [0, this.high] : this.reach(from, to);
    this.plot.setAttribute("viewBox", `${from} ${top} ${to - from} ${bottom - top}`);
    const along = (value) => ((value - this.x[0]) / (this.x[1] - this.x[0]) - view[0]) / (view[1] - view[0]) * 100;
    const up = (value) => ((this.y[1] - value) / (this.y[1] - this.y[0]) * this.high - top) / (bottom - top) * 100;
    const ends = (share) => this.x[0] + share * (this.x[1] - this.x[0]);
    const level = (place) => this.y[1] - place / this.high * (this.y[1] - this.y[0]);
    this.grid.textContent = "";
    if (!("rows" in this.svg.dataset)) {
      for (const [tick, text] of ticks(level(bottom), level(top), 4)) {
        make(this.grid, "line", { x2: "100%", y1: up(tick) + "%", y2: up(tick) + "%" });
        make(this.grid, "text", { class: "y", x: -7, y: up(tick) + "%", dy: 4 }, text);
      }
    }
    for (const [tick, text] of ticks(ends(view[0]), ends(view[1]), "narrow" in this.svg.dataset ? 4 : 7)) {
      make(this.grid, "line", { class: "x", x1: along(tick) + "%", x2: along(tick) + "%", y2: "100%" });
      make(this.grid, "text", { class: "x", x: along(tick) + "%", y: "100%", dy: 16 }, text);
    }
    for (const [note] of this.notes) {
      const { at, level: height } = note.dataset;
      const places = [at === undefined ? 50 : along(at), height === undefined ? 50 : up(height)];
      if (at !== undefined) note.setAttribute("x", places[0] + "%");
      if (height !== undefined) note.setAttribute("y", places[1] + "%");
      note.style.display = places.every((place) => place >= 0 && place <= 100) ? "" : "none";
    }
  }
  // The cursor at a share of the whole axis; null takes it away.
  point(share, first) {
    const inside = share === null ? -1 : (share - this.view[0]) / (this.view[1] - this.view[0]);
    const seen = inside >= 0 && inside <= 1;
    this.line.setAttribute("visibility", seen ? "visible" : "hidden");
    this.time.setAttribute("visibility", seen && first ? "visible" : "hidden");
    if (seen) {
      this.line.setAttribute("x1", inside * 100 + "%");
      this.line.setAttribute("x2", inside * 100 + "%");
      this.time.setAttribute("x", inside * 100 + "%");
      this.time.textContent = spoken(this.x[0] + share * (this.x[1] - this.x[0]));
    }
    for (const curve of this.curves) {
      if (!curve.shown) continue;
      const height = seen ? this.at(curve, share * WIDE) : undefined;
      curve.shown.textContent = height === undefined ? "" : spoken(this.value(height));
    }
  }
}

const all = [...document.querySelectorAll("svg.live")].map((svg) => new Chart(svg));
const together = (chart) => all.filter((other) => other === chart || (chart.svg.dataset.group && other.svg.dataset.group === chart.svg.dataset.group));
const zoom = (chart, from, to) => {
  if ("still" in chart.svg.dataset) return;
  const least = 1e-3, width = Math.min(1, Math.max(least, to - from));
  from = Math.min(Math.max(0, from), 1 - width);
  together(chart).forEach((other) => other.show([from, from + width]));
};
const cursor = (chart, share) => together(chart).forEach((other) => other.point(share, other === chart));

for (const chart of all) {
  const { svg } = chart;
  let begin = null, share = 0.5;
  const inside = (event) => {
    const box = svg.getBoundingClientRect();
    return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  };
  const place = (within) => chart.view[0] + within * (chart.view[1] - chart.view[0]);
  svg.addEventListener("pointermove", (event) => {
    const here = inside(event);
    share = place(here);
    cursor(chart, share);
    if (begin !== null) {
      chart.chosen.setAttribute("x", Math.min(begin, here) * 100 + "%");
      chart.chosen.setAttribute("width", Math.abs(here - begin) * 100 + "%");
    }
  });
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || "still" in svg.dataset) return;
    begin = inside(event);
    try { svg.setPointerCapture(event.pointerId); } catch { /* a pointer that is gone already */ }
  });
  svg.addEventListener("pointerup", (event) => {
    if (begin === null) return;
    const ends = [begin, inside(event)].sort((a, b) => a - b);
    if ((ends[1] - ends[0]) * svg.clientWidth > 5) zoom(chart, place(ends[0]), place(ends[1]));
    begin = null;
    chart.chosen.setAttribute("width", 0);
  });
  svg.addEventListener("pointercancel", () => { begin = null; chart.chosen.setAttribute("width", 0); });
  svg.addEventListener("pointerleave", () => { if (begin === null) cursor(chart, null); });
  svg.addEventListener("dblclick", () => zoom(chart, 0, 1));
  const closer = (around, factor) => {
    const [from, to] = chart.view;
    zoom(chart, around - (around - from) * factor, around + (to - around) * factor);
  };
  // A wheel alone scrolls the page.
  svg.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    closer(place(inside(event)), (event.deltaY || event.deltaX) > 0 ? 1.25 : 0.8);
  }, { passive: false });
  svg.addEventListener("keydown", (event) => {
    const step = 0.01 * (chart.view[1] - chart.view[0]);
    const moves = { ArrowLeft: -step, ArrowRight: step };
    if (event.key in moves) {
      share = Math.min(chart.view[1], Math.max(chart.view[0], share + moves[event.key]));
      cursor(chart, share);
    } else if (event.key === "+") closer(share, 0.8);
    else if (event.key === "-") closer(share, 1.25);
    else if (event.key === "0" || event.key === "Escape") zoom(chart, 0, 1);
    else return;
    event.preventDefault();
  });
}

const button = (parent, text, title, act) => {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.title = title;
  made.addEventListener("click", () => act(made));
  parent.append(made);
};
const PAINTED = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity",
  "font-size", "font-weight", "text-anchor", "vector-effect", "visibility", "display", "paint-order"];
// The picture as it is seen, to stand alone.
const alone = (figure) => {
  const svg = figure.querySelector("svg.live, :scope > svg"), box = svg.getBoundingClientRect();
  const copy = svg.cloneNode(true), before = [svg, ...svg.querySelectorAll("*")], behind = [copy, ...copy.querySelectorAll("*")];
  behind.forEach((element, index) => {
    const style = getComputedStyle(before[index]);
    element.setAttribute("style", PAINTED.map((name) => `${name}:${style.getPropertyValue(name)}`).join(";"));
  });
  const live = svg.classList.contains("live"), [left, top, right, bottom] = live ? [70, 60, 20, 40] : [0, 0, 0, 0];
  const page = getComputedStyle(document.body), size = [box.width + left + right, box.height + top + bottom];
  const out = document.createElementNS(svg.namespaceURI, "svg");
  for (const [key, value] of [["viewBox", `0 0 ${size.join(" ")}`], ["width", size[0]], ["height", size[1]], ["font-family", "sans-serif"]]) {
    out.setAttribute(key, value);
  }
  make(out, "rect", { width: "100%", height: "100%", fill: page.backgroundColor });
  if (live) {
    const text = { fill: page.color, "font-size": 14, x: left };
    make(out, "text", { ...text, y: 20, "font-weight": "bold" }, figure.querySelector("h3").textContent);
    let at = left;
    for (const name of figure.querySelectorAll(".key li")) {
      const sample = name.querySelector(".sample > *"), style = getComputedStyle(sample), shown = sample.cloneNode();
      shown.setAttribute("style", PAINTED.map((key) => `${key}:${style.getPropertyValue(key)}`).join(";"));
      shown.setAttribute("transform", `translate(${at} 30)`);
      out.append(shown);
      const words = name.childNodes[1].textContent.trim();
      make(out, "text", { ...text, x: at + 30, y: 41, "font-size": 12 }, words);
      at += 50 + 7 * words.length;
    }
    make(out, "text", { ...text, x: left + box.width, y: size[1] - 5, "font-size": 12, "text-anchor": "end" }, figure.querySelector("figcaption").textContent);
  }
  copy.setAttribute("x", left);
  copy.setAttribute("y", top);
  copy.setAttribute("width", box.width);
  copy.setAttribute("height", box.height);
  copy.style.overflow = "visible";
  out.append(copy);
  return new XMLSerializer().serializeToString(out);
};
for (const figure of document.querySelectorAll("figure.chart, figure.drawing")) {
  const tools = figure.querySelector(".tools"), chart = all.find((one) => one.figure === figure);
  if (chart && !("still" in chart.svg.dataset)) {
    button(tools, "Reset", "Show all again (double click; drag, or Ctrl and wheel, to zoom)", () => zoom(chart, 0, 1));
  }
  button(tools, "SVG", "Save this picture", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([alone(figure)], { type: "image/svg+xml" }));
    link.download = (figure.dataset.name || "picture").replace(/[^\w.-]+/g, "_") + ".svg";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}
for (const wide of document.querySelectorAll(".wide")) {
  const table = wide.querySelector("table"), tools = wide.previousElementSibling.querySelector(".tools");
  button(tools, "Copy", "Copy this table", (pressed) => {
    const cell = (one) => one.querySelector("svg")?.getAttribute("aria-label") ?? one.textContent.trim();
    const text = [...table.rows].map((row) => [...row.cells].map(cell).join("\t")).join("\n");
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    pressed.textContent = done ? "Copied" : "Not copied";
    setTimeout(() => { pressed.textContent = "Copy"; }, 1500);
  });
}
})();
// Rows that hold every word that is searched for, and the word that is chosen.
for (const table of document.querySelectorAll("table[data-choice]")) {
  const head = table.closest(".wide").previousElementSibling, rows = [...table.tBodies[0].rows], column = Number(table.dataset.choice);
  const texts = rows.map((row) => row.textContent.toLowerCase()), words = rows.map((row) => row.cells[column].textContent);
  const search = document.createElement("input"), choice = document.createElement("select"), said = document.createElement("output");
  search.type = "search";
  search.placeholder = "Search";
  search.setAttribute("aria-label", `Search in: ${table.getAttribute("aria-label")}`);
  choice.setAttribute("aria-label", table.tHead.rows[0].cells[column].textContent);
  choice.append(new Option("all", ""), ...[...new Set(words)].map((word) => new Option(`${word} (${words.filter((one) => one === word).length})`, word)));
  const show = () => {
    const wanted = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    rows.forEach((row, index) => {
      row.hidden = !(wanted.every((word) => texts[index].includes(word)) && (!choice.value || words[index] === choice.value));
      count += !row.hidden;
    });
    said.textContent = count === rows.length ? `${count} rows` : `${count} of ${rows.length} rows`;
  };
  search.addEventListener("input", show);
  choice.addEventListener("change", show);
  const bar = document.createElement("div");
  bar.className = "search";
  bar.append(search, choice, said);
  head.before(bar);
  show();
}
// A table that is wider than a phone becomes a card for each row.
for (const table of document.querySelectorAll(".wide table")) {
  const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent.trim());
  const fits = heads.length < (table.querySelector("td.picture") ? 3 : 4);
  if (fits || table.classList.contains("upright") || table.querySelector("td.shade")) continue;
  table.classList.add("stack");
  for (const row of table.tBodies[0].rows) [...row.cells].forEach((cell, at) => { cell.dataset.label = heads[at] ?? ""; });
}
// What a link or the printer asks for is opened.
const unfold = (element) => { for (let fold = element?.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true; };
const wanted = () => unfold(document.getElementById(location.hash.slice(1)));
addEventListener("hashchange", wanted);
for (const link of document.querySelectorAll("nav a")) link.addEventListener("click", () => unfold(document.getElementById(link.hash.slice(1))));
wanted();
let closed = [];
addEventListener("beforeprint", () => { closed = [...document.querySelectorAll("details:not([open])")]; closed.forEach((fold) => { fold.open = true; }); });
addEventListener("afterprint", () => closed.forEach((fold) => { fold.open = false; }));
