"use strict";
// Reading the data of the page. No text of the model is ever set as markup.
const TURN = 0.5; // rotation between two frames above which poses are not interpolated [rad]

function mixed(a, b, part) {
  const channels = (c) => [1, 3, 5].map((k) => parseInt(c.slice(k, k + 2), 16));
  const [x, y] = [channels(a), channels(b)];
  return `#${x.map((u, k) => Math.round(u + (y[k] - u) * part).toString(16).padStart(2, "0")).join("")}`;
}

const $ = (id) => document.getElementById(id);

// A new element at the end of another, with these properties.
function added(parent, tag, properties = {}) {
  return Object.assign(parent.appendChild(document.createElement(tag)), properties);
}

const ARRAYS = { f8: Float64Array, f4: Float32Array, i2: Int16Array, u1: Uint8Array };

function decoded({ kind, data }) {
  const text = atob(data);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
  return new ARRAYS[kind](bytes.buffer);
}

// The row whose time is the last that is not after t, and the part of the way to the next.
function between(times, t) {
  let [low, high] = [0, times.length - 1];
  if (!(t > times[0])) return [0, 0];
  if (t >= times[high]) return [high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return [low, (t - times[low]) / (times[high] - times[low])];
}
