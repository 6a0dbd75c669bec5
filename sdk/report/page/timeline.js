// SPDX-License-Identifier: Apache-2.0
// Outcomes over time, one lane a measurement, and the bar that shows and sets the time window.

const leftAxis = 60, rightGap = 6;

/// What canvases of one's own need: as wide as their place, sharp, redrawn with the window.
class Strip {
  constructor(element, canvas, height) {
    this.element = element;
    this.canvas = canvas;
    this.height = height;
  }

  context() {
    const ratio = document.documentElement.classList.contains('printing') ? 2 : window.devicePixelRatio || 1;
    this.width = this.canvas.parentElement.clientWidth;
    this.canvas.width = this.width * ratio;
    this.canvas.height = this.height * ratio;
    this.canvas.style.height = this.height + 'px';
    const context = this.canvas.getContext('2d');
    context.scale(ratio, ratio);
    return context;
  }
}

class OutcomeLanes extends Strip {
  constructor(filter) {
    const canvas = el('canvas', {});
    super(el('figure', { class: 'chart lanes', 'data-name': `${filter.name} outcomes` }, el('div', { class: 'canvas' }, canvas)), canvas, 0);
    this.take(filter);
    this.canvas.addEventListener('mousemove', (event) => this.hover(event));
    this.canvas.addEventListener('mouseleave', () => setCursor(null));
    dragToZoom(this);
    watch(this);
  }

  take(filter) {
    this.span = filter.span;
    this.lanes = filter.measurements.filter((measurement) => measurement.n > 0);
    this.height = 30 * this.lanes.length + 4;
    this.isStale = true;
  }

  left() {
    return Math.min(110, Math.max(leftAxis, 10 + 6.2 * Math.max(...this.lanes.map((lane) => lane.name.length))));
  }

  time(x) {
    const [from, to] = this.shown;
    return from + ((x - this.left()) / (this.width - this.left() - rightGap)) * (to - from);
  }

  show([from, to]) {
    this.shown = [from, to];
    const context = this.context();
    const left = this.left(), wide = this.width - left - rightGap;
    context.clearRect(0, 0, this.width, this.height);
    context.font = '11px ' + css('--font');
    this.lanes.forEach((lane, i) => {
      const top = 30 * i + 4;
      context.fillStyle = css('--muted');
      context.textAlign = 'right';
      context.textBaseline = 'middle';
      context.fillText(clipped(context, lane.name, left - 8), left - 8, top + 11);
      context.fillStyle = css('--grid');
      context.fillRect(left, top, wide, 22);
      this.drawLane(context, lane, left, wide, top, from, to);
    });
    this.element.dataset.from = from;
    this.element.dataset.to = to;
  }

  /// Accepted ones first and half as high, so that each of the others is seen.
  drawLane(context, lane, left, wide, top, from, to) {
    const t = column(lane.outcomes.t), kinds = column(lane.outcomes.o);
    const begin = lowerBound(t, from), end = lowerBound(t, to + 1e-9);
    for (const isAccepted of [true, false]) {
      let last = '';
      for (let i = begin; i < end; ++i) {
        if ((kinds[i] === 0) !== isAccepted) continue;
        const x = Math.round((left + ((t[i] - from) / (to - from)) * wide) * 2) / 2;
        const mark = x + ':' + kinds[i];
        if (mark === last) continue;
        last = mark;
        context.fillStyle = outcomeColour(kinds[i]);
        if (isAccepted) context.fillRect(x, top + 7, 1, 15);
        else context.fillRect(x, top, 1.5, 22);
      }
    }
  }

  hover(event) {
    const t = this.time(event.offsetX);
    setCursor(t >= this.shown[0] && t <= this.shown[1] ? t : null);
  }
}

function clipped(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let short = text;
  while (short.length > 1 && context.measureText(short + '\u2026').width > width) short = short.slice(0, -1);
  return short + '\u2026';
}

function dragToZoom(strip) {
  strip.canvas.addEventListener('pointerdown', (event) => {
    if (event.pointerType === 'touch') return;
    const begin = strip.time(event.offsetX);
    strip.canvas.addEventListener('pointerup', (end) => {
      const t = strip.time(end.offsetX);
      if (Math.abs(end.offsetX - event.offsetX) > 4) setWindow(Math.min(begin, t), Math.max(begin, t));
    }, { once: true });
  });
  strip.canvas.addEventListener('dblclick', () => setWindow(null));
}

// ---- the bar

class TimeBar extends Strip {
  constructor(host, filters) {
    const canvas = el('canvas', { 'aria-hidden': true });
    super(host, canvas, 26);
    this.from = this.input('from', 0);
    this.to = this.input('to', 1);
    const step = (name, label, change) => el('button', { type: 'button', title: label, 'aria-label': label, onclick: () => this.step(change) }, name);
    host.append(
      el('div', { class: 'edges' }, el('label', {}, el('span', {}, 't '), this.from), el('label', {}, el('span', {}, 'to '), this.to, el('span', {}, ' s'))),
      el('div', { class: 'brush' }, canvas),
      el('div', { class: 'steps' }, step('\u2212', 'Zoom out', [-0.5, 0.5]), step('+', 'Zoom in', [0.25, -0.25]), step('\u2039', 'Earlier', [-0.5, -0.5]),
        step('\u203a', 'Later', [0.5, 0.5]), el('button', { type: 'button', class: 'all', onclick: () => setWindow(null) }, 'All')));
    host.hidden = false;
    document.body.classList.add('timed');
    this.grab();
    view.listeners.push(() => this.show());
    addEventListener('resize', () => this.show());
    this.take(filters);
  }

  take(filters) {
    const spans = filters.map((filter) => filter.span);
    this.span = [Math.min(...spans.map((span) => span[0])), Math.max(...spans.map((span) => span[1]))];
    this.curves = filters.length === 1 ? filters.map(overview).filter(Boolean) : [];
    this.windows = filters.length === 1 ? filters[0].windows : [];
    const typed = [this.from, this.to].find((input) => input === document.activeElement), text = typed && typed.value;
    this.show();
    if (typed) typed.value = text;
  }

  input(name, side) {
    return el('input', { type: 'number', step: 'any', 'aria-label': name + ' [s]', onchange: (event) => {
      const edges = (view.window || this.span).slice();
      edges[side] = Number(event.target.value);
      if (edges[1] > edges[0]) setWindow(...edges);
    } });
  }

  step([left, right]) {
    const [from, to] = view.window || this.span;
    const wide = to - from;
    this.set(from + left * wide, to + right * wide);
  }

  set(from, to) {
    const low = Math.max(this.span[0], from), high = Math.min(this.span[1], to);
    if (low <= this.span[0] && high >= this.span[1]) setWindow(null);
    else setWindow(low, high);
  }

  x(t) {
    return ((t - this.span[0]) / (this.span[1] - this.span[0])) * this.width;
  }

  time(x) {
    return this.span[0] + (x / this.width) * (this.span[1] - this.span[0]);
  }

  show() {
    const context = this.context();
    const [from, to] = view.window || this.span;
    context.fillStyle = css('--grid');
    context.fillRect(0, 0, this.width, this.height);
    context.fillStyle = css('--window');
    for (const window of this.windows) context.fillRect(this.x(window.from), 0, this.x(window.to) - this.x(window.from), this.height);
    for (const curve of this.curves) this.drawCurve(context, curve);
    if (view.window) {
      context.fillStyle = css('--shade');
      context.fillRect(0, 0, this.x(from), this.height);
      context.fillRect(this.x(to), 0, this.width - this.x(to), this.height);
      context.fillStyle = css('--accent');
      for (const t of [from, to]) context.fillRect(this.x(t) - 1.5, 0, 3, this.height);
    }
    const digits = Math.max(0, Math.min(6, Math.ceil(3 - Math.log10(to - from))));
    this.from.value = Number(from.toFixed(digits));
    this.to.value = Number(to.toFixed(digits));
    this.element.dataset.from = from;
    this.element.dataset.to = to;
  }

  drawCurve(context, { t, v }) {
    const sizes = Array.from(v, Math.abs).filter(isNumber).sort((a, b) => a - b);
    const top = sizes[Math.floor(0.99 * (sizes.length - 1))] || 1;
    context.strokeStyle = css('--muted');
    context.beginPath();
    for (let i = 0; i < t.length; ++i) context.lineTo(this.x(t[i]), this.height - 2 - (this.height - 4) * Math.min(1, Math.abs(v[i]) / top));
    context.stroke();
  }

  /// The edges and the window between them can be moved; elsewhere a new window is drawn.
  grab() {
    this.canvas.addEventListener('pointerdown', (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      const begin = event.offsetX, [from, to] = view.window || this.span;
      const near = (t) => view.window && Math.abs(this.x(t) - begin) < 10;
      const what = near(from) ? 'from' : near(to) ? 'to' : view.window && begin > this.x(from) && begin < this.x(to) ? 'both' : 'new';
      const move = (moved) => {
        const shift = this.time(moved.offsetX) - this.time(begin);
        if (what === 'from') this.set(Math.min(from + shift, to - 1e-9), to);
        else if (what === 'to') this.set(from, Math.max(to + shift, from + 1e-9));
        else if (what === 'both') {
          const kept = Math.max(this.span[0] - from, Math.min(this.span[1] - to, shift));
          this.set(from + kept, to + kept);
        } else if (Math.abs(moved.offsetX - begin) > 3) this.set(...[this.time(begin), this.time(moved.offsetX)].sort((a, b) => a - b));
      };
      this.canvas.addEventListener('pointermove', move);
      this.canvas.addEventListener('pointerup', () => this.canvas.removeEventListener('pointermove', move), { once: true });
    });
    this.canvas.addEventListener('dblclick', () => setWindow(null));
  }
}

/// A curve to find one's way by: the first norm of an error there is.
function overview(filter) {
  const errors = filter.blocks.flatMap((block) => block.errors);
  const chosen = errors.find((error) => /horizontal|tilt/.test(error.name)) || errors[0];
  if (!chosen) return null;
  const t = column(chosen.t), v = column(chosen.v);
  const indices = indicesWithin(t, -Infinity, Infinity, [v], null, 500);
  return { t: indices.map((i) => t[i]), v: indices.map((i) => v[i]) };
}
