"use strict";
/* Models of a design's quantities, evaluated where the sliders stand: the same as experiments/what_if_model.py. */
{
const NONE = "–", SURE = 0.002, DOUBTFUL = 0.5, SQRT5 = Math.sqrt(5);

function evaluate(model, shares, at) {
  let sum = model.constant;
  if (model.linear) at.forEach((u, i) => {
    sum += model.linear[i] * u;
    for (let j = i; j < at.length; j++) sum += model.square[i][j] * u * at[j];
  });
  if (model.weights) model.weights.forEach((weight, k) => {
    if (weight === 0) return; // of a run that did not end as it should
    let square = 0;
    for (let i = 0; i < at.length; i++) square += ((shares[k][i] - at[i]) / model.lengths[i]) ** 2;
    const r = SQRT5 * Math.sqrt(square);
    sum += weight * (1 + r + r * r / 3) * Math.exp(-r);
  });
  return model.logarithmic ? Math.exp(sum) : sum;
}

function number(value, error) { // as many digits as the error leaves
  return String(Number(value.toPrecision(error <= SURE ? 4 : 3)));
}

function percent(share, digits) { return `${Number((100 * share).toPrecision(digits))} %`; }

class WhatIf {
  constructor(root) {
    this.data = JSON.parse(root.querySelector("script").textContent);
    this.inputs = [...root.querySelectorAll("input")];
    this.here = [...root.querySelectorAll(".here")];
    this.lines = [...root.querySelectorAll(".over-all tbody tr")];
    this.cells = [...root.querySelectorAll(".each tbody tr")].map(row => [...row.querySelectorAll("td")]);
    this.ends = root.querySelector(".ends");
    this.nominal = this.data.sliders.map(it => it.nominal);
    this.inputs.forEach(it => it.addEventListener("input", () => this.show(this.inputs.map(one => Number(one.value)))));
    root.querySelector(".reset").addEventListener("click", () => this.show(this.nominal));
    // Paper has no sliders: it shows the tuned design.
    addEventListener("beforeprint", () => { this.before = this.at; this.show(this.nominal); });
    addEventListener("afterprint", () => this.show(this.before));
    this.tuned = this.worst(this.values(this.nominal));
    this.show(this.nominal);
    root.whatIf = this;
  }

  endsWell({ succeeded, neighbours }, at) { // as Endings.well: where all of the nearest runs did
    const square = place => place.reduce((sum, u, i) => sum + (u - at[i]) ** 2, 0);
    const nearest = this.data.shares.map((place, k) => [square(place), k]).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    if (nearest[0][0] === 0) return succeeded[nearest[0][1]];
    return neighbours <= nearest.length && nearest.slice(0, neighbours).every(([, k]) => succeeded[k]);
  }

  values(at) { // of each scenario and quantity, in the units shown; null where there is no model
    return this.data.cases.map(({ models }) => models.map((model, q) =>
      model ? this.data.quantities[q].factor * evaluate(model, this.data.shares, at) : null));
  }

  worst(values) { // of each line the value and the scenario; null where one without a good model may have it
    return this.data.rows.map(({ quantity, side }) => {
      const sign = side === "most" ? 1 : -1, good = this.data.good;
      const all = values.map((row, c) => ({ value: row[quantity], error: this.data.cases[c].models[quantity]?.error, c }));
      let best = null;
      for (const it of all) if (it.value !== null && it.error <= good && (best === null || sign * it.value > sign * best.value)) best = it;
      for (const { value, error } of all) {
        if (value === null || error >= DOUBTFUL) return null;
        const end = Math.max(sign * value / (1 + error), sign * value / (1 - error));
        if (error > good && (best === null || end > sign * best.value)) return null;
      }
      return best && [best.value, best.c];
    });
  }

  show(at) {
    this.at = at;
    this.data.sliders.forEach((it, i) => {
      const value = at[i] === it.nominal ? it.value
        : it.scale === "log" ? it.low * (it.high / it.low) ** at[i] : it.low + (it.high - it.low) * at[i];
      this.inputs[i].value = at[i];
      this.here[i].textContent = Number(value.toPrecision(4));
      this.inputs[i].setAttribute("aria-valuetext", `${Number(value.toPrecision(4))} ${it.unit}`);
    });
    const ended = this.data.cases.map(it => this.endsWell(it, at)), values = this.values(at);
    this.worst(values).forEach((found, k) => this.line(this.data.rows[k], this.lines[k], found, ended.includes(false), this.tuned[k]));
    this.cells.forEach((row, c) => row.forEach((cell, q) => {
      const model = this.data.cases[c].models[q];
      if (model && model.error <= this.data.good) cell.textContent = ended[c] ? number(values[c][q], model.error) : NONE;
    }));
    const failing = this.data.cases.filter((_, c) => !ended[c]);
    this.ends.classList.toggle("warning", failing.length > 0);
    this.ends.textContent = failing.length
      ? `No number is shown here: not all runs around are ${this.data.success} in ${failing.map(it => it.label).join("; ")}.`
      : "";
  }

  line(row, element, found, failing, tuned) {
    const set = (name, text) => { element.querySelector(name).textContent = text; };
    const value = element.querySelector(".value"), space = element.querySelector(".room");
    value.classList.remove("good", "bad", "unsure");
    set(".told", found === null ? row.of_all : row.measured);
    if (failing || found === null) {
      for (const name of [".value", ".change", ".room", ".where"]) set(name, NONE);
      if (!failing) set(".value", row.none);
      return;
    }
    set(".value", number(found[0], row.error));
    set(".where", this.data.cases[found[1]].label);
    const change = tuned === null || tuned[0] === 0 ? 0 : found[0] / tuned[0] - 1;
    set(".change", tuned === null || found[0] === tuned[0] ? NONE : Math.abs(change) <= row.error ? "within the error" : `${change > 0 ? "+" : ""}${percent(change, 2)}`);
    if (row.limit === null) return;
    const left = row.side === "most" ? row.limit - found[0] : found[0] - row.limit;
    const unsure = Math.abs(left) <= row.error * Math.abs(found[0]);
    space.textContent = unsure ? "within the error"
      : number(left, SURE + row.error) + (row.limit ? ` (${percent(left / Math.abs(row.limit), 3)})` : "");
    value.classList.add(unsure ? "unsure" : left > 0 ? "good" : "bad");
  }
}

document.querySelectorAll(".what-if").forEach(root => new WhatIf(root));
}
