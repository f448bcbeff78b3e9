// SPDX-License-Identifier: MIT
// Small plots with axes, on a canvas: as many pixels as the screen has, colours of the page.
class Plot {
  constructor(canvas) {
    this.canvas = canvas;
    this.top = 0;
  }

  // Fits the canvas to its place; gives the context in CSS pixels, cleared.
  begin() {
    const scale = window.devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    const width = Math.round(box.width * scale), height = Math.round(box.height * scale);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, {width, height});
    const c = this.canvas.getContext('2d', {willReadFrequently: true});  // small and often: not the graphics processor's
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, box.width, box.height);
    const style = getComputedStyle(document.documentElement);
    this.color = name => style.getPropertyValue('--' + name).trim();
    this.box = {left: 46, right: box.width - 6, top: 8, bottom: box.height - 18};
    return c;
  }

  // Axes from 0 to x_end and y_end; the unit of y stands at its top.
  axes(c, {x_begin = 0, x_end, x_label, y_end, y_unit, steps = 4}) {
    const {left, right, top, bottom} = this.box;
    if (right - left < 40 * steps) steps = 2;
    this.x = v => left + (v - x_begin) / (x_end - x_begin) * (right - left);
    this.y = v => bottom - v / y_end * (bottom - top);
    c.font = '10.5px system-ui, "DejaVu Sans", sans-serif';
    c.lineWidth = 1;
    const [factor, letter] = Text.prefix(y_end);
    for (const share of [0, 0.5, 1]) {
      const y = Math.round(this.y(share * y_end)) + 0.5;
      c.strokeStyle = this.color('line');
      c.beginPath();
      c.moveTo(left, y);
      c.lineTo(right, y);
      c.stroke();
      c.fillStyle = this.color('quiet');
      c.textAlign = 'right';
      c.textBaseline = 'middle';
      const value = share * y_end / factor;
      c.fillText(share === 0 ? '0' : String(Number(value.toPrecision(3))) + (share === 1 ? ' ' + letter + y_unit : ''), left - 5, y);
    }
    c.textBaseline = 'alphabetic';
    for (let i = 0; i <= steps; ++i) {
      const share = i / steps;
      c.textAlign = share === 0 ? 'left' : share === 1 ? 'right' : 'center';
      c.fillText(x_label(x_begin + share * (x_end - x_begin)), this.x(x_begin + share * (x_end - x_begin)), bottom + 14);
    }
  }

  // xs, ys in units of the axes; NaN lifts the pen. With `fill`, down to the axis.
  line(c, xs, ys, color, {width = 1.6, alpha = 1} = {}) {
    c.strokeStyle = this.color(color);
    c.globalAlpha = alpha;
    c.lineWidth = width;
    c.lineJoin = 'round';
    c.beginPath();
    let down = false;
    for (let i = 0; i < xs.length; ++i) {
      if (Number.isNaN(ys[i])) {
        down = false;
        continue;
      }
      const x = this.x(xs[i]), y = this.y(ys[i]);
      if (down) c.lineTo(x, y);
      else c.moveTo(x, y);
      down = true;
    }
    c.stroke();
    c.globalAlpha = 1;
  }

  // A dashed line up from x, where the axes reach that far, and beside it what lies beyond.
  border(c, x, beyond) {
    const {right, top, bottom} = this.box, at = Math.round(this.x(x)) + 0.5;
    if (!(at < right)) return;
    c.strokeStyle = c.fillStyle = this.color('quiet');
    c.setLineDash([3, 3]);
    c.beginPath();
    c.moveTo(at, bottom);
    c.lineTo(at, top);
    c.stroke();
    c.setLineDash([]);
    if (at + c.measureText(beyond).width + 4 > right) return;
    c.textAlign = 'left';
    c.textBaseline = 'bottom';
    c.fillText(beyond, at + 4, bottom - 2);
  }

  dot(c, x, y, color) {
    c.fillStyle = this.color(color);
    c.beginPath();
    c.arc(this.x(x), this.y(y), 3.5, 0, 2 * Math.PI);
    c.fill();
  }
}

// The last seconds of a session: force and depth of every tick, in a ring.
class History {
  constructor(ticks) {
    this.ticks = ticks;
    this.clear();
  }
  clear() {
    this.force = new Float32Array(this.ticks);
    this.depth = new Float32Array(this.ticks);
    this.contact = new Uint8Array(this.ticks);
    this.count = 0;
  }
  add(force, depth, contact) {
    const at = this.count++ % this.ticks;
    this.force[at] = force;
    this.depth[at] = depth;
    this.contact[at] = contact;
  }
  get begin() { return Math.max(0, this.count - this.ticks); }
  at(i) { return i % this.ticks; }
  largest(values) {
    let largest = 0;
    for (let i = this.begin; i < this.count; ++i) largest = Math.max(largest, values[this.at(i)]);
    return largest;
  }
}

const FINGERS = ['finger', 'second-finger'];  // their colours

// histories: of each finger.
function draw_by_time(plot, histories, seconds, floor) {
  const c = plot.begin(), y_end = Text.round_up(Math.max(...histories.map(h => 1.05 * h.largest(h.force)), floor));
  plot.axes(c, {x_begin: -seconds, x_end: 0, x_label: s => s === 0 ? 'now' : String(Number(s.toFixed(1))).replace('-', '−'), y_end, y_unit: 'N', steps: seconds});
  histories.forEach((history, finger) => draw_force(plot, c, history, Math.round(1000 * seconds), FINGERS[finger]));
}

function draw_force(plot, c, history, n, color) {
  const xs = [], ys = [], step = Math.max(1, Math.floor(n / 700));
  for (let i = Math.max(history.begin, history.count - n); i < history.count; i += step) {
    let most = 0;  // of the ticks that share a pixel
    for (let k = i; k < Math.min(i + step, history.count); ++k) most = Math.max(most, history.force[history.at(k)]);
    xs.push((i - history.count) / 1000);
    ys.push(most);
  }
  plot.line(c, xs, ys, color);
}

// good_m: the depth from which on the force is off by 10 % and more; 0: it is not known.
function draw_by_depth(plot, histories, floor_n, floor_m, good_m) {
  const c = plot.begin(), y_end = Text.round_up(Math.max(...histories.map(h => 1.05 * h.largest(h.force)), floor_n));
  const x_end = Text.round_up(Math.max(...histories.map(h => 1.02 * h.largest(h.depth)), floor_m));
  plot.axes(c, {x_end, x_label: m => String(Number((1e3 * m).toPrecision(3))), y_end, y_unit: 'N'});
  draw_good(plot, c, good_m);
  histories.forEach((history, finger) => draw_depth(plot, c, history, FINGERS[finger]));
}

function draw_good(plot, c, good_m) {
  if (good_m > 0) plot.border(c, good_m, 'may be off by 10 %');
}

function draw_depth(plot, c, history, color) {
  const xs = [], ys = [];
  for (let i = history.begin; i < history.count; ++i) {
    const at = history.at(i);
    xs.push(history.depth[at]);
    ys.push(history.contact[at] ? history.force[at] : NaN);
  }
  plot.line(c, xs, ys, color, {alpha: 0.8, width: 1.3});
  if (history.count > 0) {
    const last = history.at(history.count - 1);
    if (history.contact[last]) plot.dot(c, history.depth[last], history.force[last], color);
  }
}
