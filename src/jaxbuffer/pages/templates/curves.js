"use strict";
/* Forces and other values over time to be read off: a slider or the pointer sets the time, buttons show less of it or more. */
{
const NAMESPACE = "http://www.w3.org/2000/svg", HEIGHT = 300, LEFT = 56, RIGHT = 12, TOP = 28, BOTTOM = 36, ZOOM = 4, PAD = 8;
const ROOM = 70; // pixels for a label of the time axis
const EARLY = 0.25, BEYOND = 1.2; // impacts within this share of the run are shown first, with some time after them

function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= rough);
  const first = Math.ceil(low / step), last = Math.floor(high / step + 1e-9);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return Array.from({ length: last - first + 1 }, (_, k) => [(first + k) * step, ((first + k) * step).toFixed(digits)]);
}

function valueAt({ times, forces }, time) {
  if (time < times[0] || time > times[times.length - 1]) return null;
  let low = 0, high = times.length - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (times[middle] <= time) low = middle; else high = middle; }
  const share = (time - times[low]) / Math.max(times[high] - times[low], 1e-300);
  return forces[low] + share * (forces[high] - forces[low]);
}

function lastTouchdown({ times, forces }) { // 0 where nothing touches after the beginning
  let k = forces.length - 2;
  while (k >= 0 && !(forces[k] === 0 && forces[k + 1] > 0)) k--;
  return k < 0 ? 0 : times[k];
}

class Curves {
  constructor(root) {
    const data = JSON.parse(root.querySelector("script").textContent);
    this.axis = root.dataset.axis; // "force [N]", "stroke [mm]"
    this.unit = root.dataset.unit;
    this.curves = data.map(it => ({ name: it.name, times: it.time, forces: it.values }));
    this.svg = root.querySelector(".chart");
    this.slider = root.querySelector(".time");
    this.clock = root.querySelector(".clock");
    this.end = Math.max(...this.curves.map(it => it.times[it.times.length - 1]));
    this.largest = Math.max(1e-12, ...this.curves.map(it => it.forces.reduce((a, b) => Math.max(a, b), 0)));
    this.lowest = Math.min(0, ...this.curves.map(it => it.forces.reduce((a, b) => Math.min(a, b), 0)));
    const last = this.curves[this.curves.length - 1];
    this.time = last.times[last.forces.indexOf(last.forces.reduce((a, b) => Math.max(a, b), 0))];
    this.slider.addEventListener("input", () => this.read(this.from + this.slider.value / 1000 * (this.to - this.from)));
    this.svg.addEventListener("pointermove", event => this.follow(event));
    const on = (name, act) => root.querySelector(name).addEventListener("click", act);
    on(".closer", () => this.zoom(1 / ZOOM));
    on(".wider", () => this.zoom(ZOOM));
    on(".whole", () => this.view(0, this.end));
    const impacts = BEYOND * Math.max(this.time, ...this.curves.map(lastTouchdown));
    const early = this.axis === "force [N]" && impacts < EARLY * this.end; // of contacts
    if (early) root.querySelector("figcaption").append(". Shown first: the beginning, with all impacts");
    this.view(0, early ? impacts : this.end);
    new ResizeObserver(() => this.draw()).observe(this.svg);
  }

  follow(event) {
    const box = this.svg.getBoundingClientRect(), share = (event.clientX - box.left - LEFT - PAD) / (this.width - LEFT - RIGHT - 2 * PAD);
    this.read(this.from + Math.min(1, Math.max(0, share)) * (this.to - this.from));
  }

  zoom(factor) {
    const length = Math.min(this.end, Math.max(1e-6, factor * (this.to - this.from)));
    const from = Math.min(this.end - length, Math.max(0, this.time - length / 2));
    this.view(from, from + length);
  }

  view(from, to) {
    this.from = from;
    this.to = to;
    this.draw();
  }

  add(parent, name, attributes, text) {
    const element = parent.appendChild(document.createElementNS(NAMESPACE, name));
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    return element;
  }

  x(time) { return PAD + (this.width - LEFT - RIGHT - 2 * PAD) * (time - this.from) / (this.to - this.from); }

  y(force) { // zero is at the bottom, unless something is below it
    const top = 1.05 * this.largest, bottom = 1.05 * this.lowest;
    return (HEIGHT - TOP - BOTTOM) * (top - force) / (top - bottom);
  }

  draw() {
    this.width = Math.max(this.svg.clientWidth, 200);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${HEIGHT}`);
    this.svg.replaceChildren();
    const inner = this.width - LEFT - RIGHT, tall = HEIGHT - TOP - BOTTOM;
    for (const [force, text] of ticks(1.05 * this.lowest, 1.05 * this.largest, 4)) {
      const y = TOP + this.y(force);
      this.add(this.svg, "line", { class: "grid", x1: LEFT, x2: LEFT + inner, y1: y, y2: y });
      this.add(this.svg, "text", { x: LEFT - 6, y: y + 4, "text-anchor": "end" }, text);
    }
    for (const [time, text] of ticks(this.from, this.to, Math.max(2, Math.floor(inner / ROOM)))) {
      const x = LEFT + this.x(time);
      this.add(this.svg, "line", { class: "grid", x1: x, x2: x, y1: TOP, y2: TOP + tall });
      this.add(this.svg, "text", { x, y: TOP + tall + 16, "text-anchor": "middle" }, text);
    }
    this.add(this.svg, "text", { x: LEFT + inner, y: HEIGHT - 4, "text-anchor": "end" }, "time [s]");
    this.add(this.svg, "text", { x: 0, y: 14 }, this.axis);
    const field = this.add(this.svg, "svg", { x: LEFT, y: TOP, width: inner, height: tall, overflow: "hidden" });
    this.curves.forEach(({ times, forces }, n) => {
      const points = [];
      times.forEach((time, k) => {
        if ((times[k + 1] ?? time) >= this.from && (times[k - 1] ?? time) <= this.to)
          points.push(`${this.x(time).toFixed(2)},${this.y(forces[k]).toFixed(2)}`);
      });
      this.add(field, "polyline", { class: `curve${n % 4}`, points: points.join(" ") });
    });
    this.cursor = this.add(field, "line", { class: "cursor", y1: 0, y2: tall });
    this.marks = this.curves.map((_, n) => this.add(field, "circle", { class: `mark${n % 4}`, r: 4 }));
    this.read(Math.min(this.to, Math.max(this.from, this.time)));
  }

  read(time) {
    this.time = time;
    this.slider.value = Math.round(1000 * (time - this.from) / (this.to - this.from));
    const x = this.x(time), told = [];
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.curves.forEach((curve, n) => {
      const force = valueAt(curve, time);
      this.marks[n].setAttribute("visibility", force === null ? "hidden" : "visible");
      if (force === null) { told.push(`${curve.name}: is over`); return; }
      this.marks[n].setAttribute("cx", x);
      this.marks[n].setAttribute("cy", this.y(force));
      told.push(`${curve.name}: ${Number(force.toPrecision(4))} ${this.unit}`);
    });
    const text = [`${time.toPrecision(5)} s`, ...told].join(" · ");
    this.clock.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
  }
}

document.querySelectorAll(".curves").forEach(root => new Curves(root));
}
