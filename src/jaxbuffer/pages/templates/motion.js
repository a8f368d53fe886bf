"use strict";
{
/* A run drawn moving. Shapes are given in the axes of frames [x, y, angle] that move; lengths in m, forces in N. */
const SVG = "http://www.w3.org/2000/svg";
const FILLS = ["#d5ecfa", "#f2cf80", "#8cd3c0", "#a6a6a6", "#529fcb", "#d55e00"];
const TURNS = 8;

function placed([x, y, angle], [u, v]) {
  const cos = Math.cos(angle), sin = Math.sin(angle);
  return [x + cos * u - sin * v, y + sin * u + cos * v];
}

function frameOf(frames, body) { return body < 0 ? [0, 0, 0] : frames[body]; }

function corners(shape, frames) {
  if (shape.corners) return shape.corners.map(point => placed(frameOf(frames, shape.body), point));
  if (shape.stations) {
    const side = off => shape.stations.map(n => placed(frames[n], [0, off * shape.width / 2]));
    return [...side(1), ...side(-1).reverse()];
  }
  const [first, second] = [shape.first, shape.second].map(s => placed(frameOf(frames, s.body), [s.x, s.y]));
  const along = [second[0] - first[0], second[1] - first[1]], length = Math.max(Math.hypot(...along), 1e-12);
  const across = [-along[1] / length, along[0] / length];
  const at = (share, off) => [0, 1].map(k => first[k] + share * along[k] + off * shape.width / 2 * across[k]);
  if (!shape.spring) return [at(0, -1), at(1, -1), at(1, 1), at(0, 1)];
  const middle = Array.from({ length: 2 * TURNS - 1 }, (_, k) => at(0.1 + 0.8 * (k + 1) / (2 * TURNS), k % 2 ? 1 : -1));
  return [at(0, 0), at(0.1, 0), ...middle, at(0.9, 0), at(1, 0)];
}

class View {
  constructor(svg, data, shapes, path = null, forces = data.forces) {
    this.forces = forces;
    this.svg = svg;
    this.data = data;
    this.drawn = shapes;
    this.shapes = shapes.map(shape => {
      const element = this.add(shape.filled ? "polygon" : "polyline");
      element.setAttribute("fill", shape.filled ? FILLS[shape.colour % FILLS.length] : "none");
      element.setAttribute("stroke", shape.dashed ? "#888888" : shape.stroke);
      if (shape.dashed) element.setAttribute("stroke-dasharray", "6 4");
      if (shape.part) element.appendChild(document.createElementNS(SVG, "title")).textContent = shape.part;
      return element;
    });
    this.arrows = data.contacts.map(() => {
      const element = this.line("#b2182b");
      element.style.strokeWidth = "3px";
      return element;
    });
    this.path = path;
    if (path !== null) this.way = this.line("#222222"); // as no part is drawn
  }

  line(colour) {
    const element = this.add("polyline");
    element.setAttribute("fill", "none");
    element.setAttribute("stroke", colour);
    return element;
  }

  add(name) {
    const element = this.svg.appendChild(document.createElementNS(SVG, name));
    element.setAttribute("vector-effect", "non-scaling-stroke");
    element.setAttribute("stroke-width", "1.2");
    return element;
  }

  show(k, [[left, low], [right, high]]) {
    const frames = this.data.frames[k], flipped = points => points.map(([x, y]) => `${x},${-y}`).join(" ");
    this.svg.setAttribute("viewBox", `${left} ${-high} ${right - left} ${high - low}`);
    this.drawn.forEach((shape, n) => this.shapes[n].setAttribute("points", flipped(corners(shape, frames))));
    if (this.way) this.way.setAttribute("points", flipped(this.data.frames.slice(0, k + 1).map(all => all[this.path])));
    const reach = 0.2 * (right - left);
    this.forces[k].forEach(([x, y, forceX, forceY], n) => {
      const scale = reach / this.data.largest, tip = [x + scale * forceX, y + scale * forceY];
      const size = Math.hypot(forceX, forceY), arrow = [];
      if (size > 0.02 * this.data.largest) {
        const back = [-0.25 * scale * forceX, -0.25 * scale * forceY];
        const head = turn => [tip[0] + back[0] - turn * back[1] * 0.6, tip[1] + back[1] + turn * back[0] * 0.6];
        arrow.push([x, y], tip, head(1), tip, head(-1));
      }
      this.arrows[n].setAttribute("points", flipped(arrow));
    });
  }
}

class Motion {
  constructor(root) {
    this.data = JSON.parse(root.querySelector("script").textContent);
    this.whole = new View(root.querySelector(".whole"), this.data, this.data.shapes);
    const closer = root.querySelector(".closer");
    const detail = this.data.detail, own = detail && detail.shapes && detail.shapes.length ? detail.shapes : this.data.shapes;
    // Records of earlier versions have no forces of the detail's own, and null means that it has none.
    const forces = (detail && detail.forces) || this.data.forces;
    if (detail) this.closer = new View(closer, this.data, own, detail.path, forces); else closer.remove();
    this.button = root.querySelector(".play");
    this.slider = root.querySelector(".time");
    this.clock = root.querySelector(".clock");
    this.slider.addEventListener("input", () => { this.stop(); this.show(Number(this.slider.value)); });
    this.button.addEventListener("click", () => this.timer ? this.stop() : this.play());
    this.show(0);
  }

  show(k) {
    this.k = k;
    this.slider.value = k;
    this.whole.show(k, this.data.bounds);
    if (this.closer) {
      const { body, x, y, half } = this.data.detail, [cx, cy] = placed(frameOf(this.data.frames[k], body), [x, y]);
      this.closer.show(k, [[cx - half, cy - half], [cx + half, cy + half]]);
    }
    // Records of earlier versions have the arrows alone.
    const sizes = this.data.acting ? this.data.acting[k] : this.data.forces[k].map(([, , x, y]) => Math.hypot(x, y));
    const acting = this.data.contacts.map((name, n) => [name, sizes[n]])
      .filter(([, force]) => force > 1e-4 * this.data.largest).map(([name, force]) => `${force.toPrecision(3)} N ${name}`);
    const text = [`${this.data.times[k].toPrecision(4)} s`, this.data.paces[k], ...acting].join(" · ");
    this.clock.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
  }

  play() {
    if (this.k >= this.data.times.length - 1) this.show(0);
    this.button.textContent = "Pause";
    this.timer = setInterval(() => {
      if (this.k >= this.data.times.length - 1) this.stop(); else this.show(this.k + 1);
    }, 50);
  }

  stop() {
    clearInterval(this.timer);
    this.timer = null;
    this.button.textContent = "Play";
  }
}

document.querySelectorAll(".motion").forEach(root => new Motion(root));
}
