// SPDX-License-Identifier: Apache-2.0
// The track: metres east and north, equal in scale; nothing of it comes from anywhere else.

const rampSize = 7;

class TrackMap {
  constructor(filter) {
    this.unpack(filter);
    this.mode = this.paths.reference ? 'error' : this.paths.estimate.shade ? 'sigma' : 'plain';
    this.picture = svg('svg', { class: 'map', role: 'img', 'aria-label': `Track of ${filter.name}` });
    this.legend = el('div', { class: 'legend' });
    this.element = el('figure', { class: 'track', 'data-name': `${filter.name} track` }, this.controls(), this.picture, this.legend);
    this.fit();
    this.draw();
    this.drag();
    view.cursorListeners.push((t) => this.cursor(t));
    view.listeners.push(() => this.drawWindow());
    for (const [target, event] of [[window, 'resize'], [this.element, 'fit']]) target.addEventListener(event, () => { this.fit(); this.draw(); });
  }

  unpack(filter) {
    this.track = filter.track;
    this.paths = { estimate: unpackedPath(this.track.estimate), reference: this.track.reference && unpackedPath(this.track.reference) };
  }

  /// A part that is looked at stays.
  take(filter) {
    this.unpack(filter);
    if (!this.isMoved) this.fit();
    this.draw();
  }

  controls() {
    const option = (value, text) => el('option', { value, selected: value === this.mode }, text);
    const button = (text, label, scale) => el('button', { type: 'button', 'aria-label': label, title: label, onclick: () => this.zoom(scale) }, text);
    return el('div', { class: 'controls' },
      el('label', {}, 'Colour ', el('select', { onchange: (event) => { this.mode = event.target.value; this.draw(); } },
        this.paths.reference && option('error', 'horizontal error'), this.paths.estimate.shade && option('sigma', 'horizontal 1\u03c3 of the filter'), option('plain', 'none'))),
      el('span', { class: 'steps' }, button('\u2212', 'Zoom out', 1.6), button('+', 'Zoom in', 1 / 1.6), button('All', 'Whole track', null)));
  }

  bounds() {
    const all = [this.paths.estimate, this.paths.reference].filter(Boolean);
    const of = (key) => all.flatMap((path) => [least(path[key]), greatest(path[key])]);
    const e = of('e'), n = of('n');
    return { left: Math.min(...e), right: Math.max(...e), low: Math.min(...n), high: Math.max(...n) };
  }

  /// The whole track with a margin, as high as suits it.
  fit() {
    const { left, right, low, high } = this.bounds();
    const extent = Math.max(right - left, high - low, 1);
    const wide = right - left + 0.14 * extent, tall = high - low + 0.14 * extent;
    const width = this.picture.clientWidth || this.element.clientWidth || 900;
    const height = Math.max(260, Math.min(width < 600 ? 420 : 520, (width * tall) / wide));
    const scale = Math.max(wide / width, tall / height);
    this.size = { width, height };
    this.box = { x: (left + right) / 2 - (scale * width) / 2, y: -(low + high) / 2 - (scale * height) / 2, scale };
    this.picture.setAttribute('height', height);
    this.picture.style.height = height + 'px';
  }

  zoom(factor) {
    this.isMoved = factor !== null;
    if (factor === null) this.fit();
    else {
      const { width, height } = this.size, { x, y, scale } = this.box;
      this.box = { x: x + (scale * width * (1 - factor)) / 2, y: y + (scale * height * (1 - factor)) / 2, scale: scale * factor };
    }
    this.draw();
  }

  // Pixels of the picture; north is up.
  px(e) { return (e - this.box.x) / this.box.scale; }
  py(n) { return (-n - this.box.y) / this.box.scale; }

  draw() {
    const picture = this.picture, { width, height } = this.size;
    picture.replaceChildren();
    picture.setAttribute('viewBox', `0 0 ${width} ${height}`);
    picture.append(this.grid());
    const { estimate, reference } = this.paths;
    if (reference) picture.append(this.line(reference, 'reference'));
    if (this.mode === 'error') picture.append(...this.shaded(reference), this.line(estimate, 'thin'));
    else if (this.mode === 'sigma') picture.append(...this.shaded(estimate));
    else picture.append(this.line(estimate, 'estimate'));
    this.part = svg('g', {});
    this.dot = svg('circle', { class: 'here', r: 5, visibility: 'hidden' });
    picture.append(this.part, this.mark(estimate, 0, 'start'), this.mark(estimate, estimate.e.length - 1, 'end'), this.scaleBar(), this.dot);
    this.drawWindow();
    this.drawLegend();
  }

  points(path, begin = 0, end = path.e.length) {
    const list = [];
    for (let i = begin; i < end; ++i) list.push(`${this.px(path.e[i]).toFixed(1)},${this.py(path.n[i]).toFixed(1)}`);
    return list.join(' ');
  }

  /// Not across gaps.
  line(path, name) {
    const group = svg('g', {});
    let begin = 0;
    for (const end of [...path.gaps, path.e.length]) {
      group.append(svg('polyline', { class: name, points: this.points(path, begin, end) }));
      begin = end;
    }
    return group;
  }

  /// Runs of one shade as one line each.
  shaded(path) {
    this.levels = shadeLevels(path.shade);
    const lines = [];
    let begin = 0;
    const gaps = new Set(path.gaps);
    for (let i = 1; i <= path.e.length; ++i) {
      const isGap = gaps.has(i);
      if (!isGap && i < path.e.length && shadeOf(path.shade[i], this.levels) === shadeOf(path.shade[begin], this.levels)) continue;
      lines.push(svg('polyline', { class: 'shaded', style: `stroke: var(--r${shadeOf(path.shade[begin], this.levels)})`, points: this.points(path, begin, isGap ? i : Math.min(i + 1, path.e.length)) }));
      begin = i;
    }
    return lines;
  }

  mark(path, index, text) {
    const x = this.px(path.e[index]), y = this.py(path.n[index]);
    return svg('g', { class: 'mark' }, svg('circle', { cx: x, cy: y, r: 4.5, class: text }), svg('text', { x: x + 8, y: y + 4 }, text));
  }

  grid() {
    const { width, height } = this.size, step = niceStep(this.box.scale * Math.max(90, width / 9));
    const lines = svg('g', { class: 'grid' });
    const { x, y, scale } = this.box;
    for (let e = Math.ceil(x / step) * step; e < x + scale * width; e += step)
      lines.append(svg('line', { x1: this.px(e), x2: this.px(e), y1: 0, y2: height }), svg('text', { x: this.px(e) + 3, y: height - 5 }, metres(e)));
    for (let n = Math.ceil(-(y + scale * height) / step) * step; n < -y; n += step)
      lines.append(svg('line', { x1: 0, x2: width, y1: this.py(n), y2: this.py(n) }), svg('text', { x: 4, y: this.py(n) - 4 }, metres(n)));
    return lines;
  }

  scaleBar() {
    const { width } = this.size, length = niceStep(this.box.scale * 110), wide = length / this.box.scale;
    const right = width - 16, y = 28;
    return svg('g', { class: 'scale' }, svg('path', { d: `M${right - wide} ${y - 5}V${y}H${right}V${y - 5}` }),
      svg('text', { x: right - wide / 2, y: y - 8, 'text-anchor': 'middle' }, metres(length)),
      svg('path', { class: 'north', d: `M${right - wide - 28} ${y + 2}l6 -20l6 20l-6 -5z` }), svg('text', { x: right - wide - 22, y: y + 14, 'text-anchor': 'middle' }, 'N'));
  }

  /// The part of the track that the plots show.
  drawWindow() {
    this.part.replaceChildren();
    if (!view.window) return;
    const path = this.paths.estimate, begin = lowerBound(path.t, view.window[0]), end = lowerBound(path.t, view.window[1]);
    this.part.append(svg('polyline', { class: 'part', points: this.points(path, begin, end) }));
  }

  cursor(t) {
    const path = this.paths.estimate;
    const i = t === null ? -1 : Math.min(path.t.length - 1, lowerBound(path.t, t));
    this.dot.setAttribute('visibility', i < 0 ? 'hidden' : 'visible');
    if (i < 0) return;
    this.dot.setAttribute('cx', this.px(path.e[i]));
    this.dot.setAttribute('cy', this.py(path.n[i]));
  }

  drag() {
    this.picture.addEventListener('pointerdown', (event) => {
      if (event.pointerType === 'touch') return;
      event.preventDefault();
      let last = [event.clientX, event.clientY];
      const move = (moved) => {
        this.box.x -= (moved.clientX - last[0]) * this.box.scale;
        this.box.y -= (moved.clientY - last[1]) * this.box.scale;
        last = [moved.clientX, moved.clientY];
        this.isMoved = true;
        this.draw();
      };
      addEventListener('pointermove', move);
      addEventListener('pointerup', () => removeEventListener('pointermove', move), { once: true });
    });
  }

  drawLegend() {
    const item = (name, text) => el('span', { class: 'key' }, el('i', { class: name }), text);
    const plain = [this.paths.reference && this.mode !== 'error' && item('reference', 'reference'), this.mode === 'error' && item('thin', 'estimate'), this.mode === 'plain' && item('estimate', 'estimate')];
    const ramp = this.mode === 'plain' ? [] : el('span', { class: 'ramp' },
      this.mode === 'error' ? 'reference, horizontal error: ' : 'estimate, horizontal 1\u03c3: ',
      this.levels.map((level, i) => el('span', { class: 'key' }, el('i', { style: `background: var(--r${i})` }), i < this.levels.length - 1 ? `\u2264 ${short(level)}` : `> ${short(this.levels[i - 1] ?? 0)}`)), ' m');
    const origin = this.track.origin;
    this.legend.replaceChildren(...[...plain, ramp].flat().filter(Boolean),
      el('span', { class: 'origin' }, origin ? `origin ${withMinus(origin.lat.toFixed(6))}\u00b0, ${withMinus(origin.lon.toFixed(6))}\u00b0` : ''));
  }
}

function unpackedPath(path) {
  const unpacked = { t: column(path.t), e: column(path.e), n: column(path.n), shade: column(path.shade) };
  return { ...unpacked, gaps: gapsOf(unpacked) };
}

/// Where the track goes on far from where it was.
function gapsOf({ e, n }) {
  const steps = [];
  for (let i = 1; i < e.length; ++i) steps.push(Math.hypot(e[i] - e[i - 1], n[i] - n[i - 1]));
  const usual = steps.slice().sort((a, b) => a - b)[steps.length >> 1] || 0;
  return steps.flatMap((step, i) => (step > 10 * usual ? [i + 1] : []));
}

function least(values) {
  let low = Infinity;
  for (const value of values) if (value < low) low = value;
  return low;
}

function greatest(values) {
  let high = -Infinity;
  for (const value of values) if (value > high) high = value;
  return high;
}

/// Upper ends of the shades: round numbers, evenly many points in each as far as that goes.
function shadeLevels(shade) {
  const sorted = Float64Array.from(shade).filter((value) => Number.isFinite(value)).sort();
  const levels = [];
  for (let i = 1; i < rampSize; ++i) {
    const level = roundUp(sorted[Math.floor(((sorted.length - 1) * i) / rampSize)]);
    if (level > (levels[levels.length - 1] ?? -Infinity)) levels.push(level);
  }
  while (levels.length && levels[levels.length - 1] >= sorted[sorted.length - 1]) levels.pop();
  levels.push(Infinity);
  return levels;
}

function shadeOf(value, levels) {
  let i = 0;
  while (i < levels.length - 1 && value > levels[i]) ++i;
  return i;
}

function roundUp(value) {
  if (!(value > 0)) return 0;
  const power = 10 ** (Math.floor(Math.log10(value)) - 1);
  return Number((Math.ceil(value / power) * power).toPrecision(3));
}

const short = (value) => (value >= 1000 ? grouped(Math.round(value)) : String(Number(value.toPrecision(2))));

function niceStep(wanted) {
  const power = 10 ** Math.floor(Math.log10(wanted));
  for (const factor of [1, 2, 5, 10]) if (factor * power >= wanted) return factor * power;
  return wanted;
}

function metres(value) {
  if (Math.abs(value) >= 1000) return withMinus(String(Number((value / 1000).toFixed(3)))) + ' km';
  return withMinus(String(Number(value.toPrecision(6)))) + ' m';
}
