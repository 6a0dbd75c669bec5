// SPDX-License-Identifier: Apache-2.0
// Time plots: made when they come into view, all with the same time window and the same cursor.

const view = {
  window: null,       // [from, to] when zoomed; null: each plot's own span
  items: [],          // whatever has show(window), cursor(t) and an element
  listeners: [],      // called with a new window
  cursorListeners: [],
};

let updateIsDue = false;

/// Zooms everything on the page. Null: all of it.
function setWindow(from, to) {
  view.window = from === null || !(to > from) ? null : [from, to];
  for (const item of view.items) item.isStale = true;
  if (updateIsDue) return;
  updateIsDue = true;
  requestAnimationFrame(() => {
    updateIsDue = false;
    for (const item of view.items) if (item.isVisible) refresh(item);
    for (const listener of view.listeners) listener(view.window);
  });
}

function refresh(item) {
  if (!item.isStale) return;
  item.isStale = false;
  item.show(view.window || item.span);
}

function setCursor(t) {
  for (const item of view.items) if (item.isVisible && item.cursor) item.cursor(t);
  for (const listener of view.cursorListeners) listener(t);
}

const observer = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    const item = entry.target.item;
    item.isVisible = entry.isIntersecting;
    if (item.isVisible) refresh(item);
  }
}, { rootMargin: '300px 0px' });

function watch(item) {
  item.isStale = true;
  item.element.item = item;
  view.items.push(item);
  observer.observe(item.element);
}

/// What is drawn, by its name: a page that is rendered again keeps its drawings, with what is zoomed in them.
const drawings = new Map(), drawnNow = new Set();

/// The element of a drawing; where it is on the page already, a place that putDrawings() fills.
function drawing(Type, name, content) {
  let key = name;
  for (let i = 2; drawnNow.has(key); ++i) key = `${name} (${i})`;
  drawnNow.add(key);
  const known = drawings.get(key);
  if (!known) {
    const made = new Type(content);
    made.element.dataset.key = key;
    drawings.set(key, made);
    return made.element;
  }
  known.take(content);
  return el('figure', { 'data-key': key, 'data-place': true });
}

/// Places that found no drawing beside them, and what is to be drawn anew.
function putDrawings() {
  for (const place of document.querySelectorAll('[data-place]')) place.replaceWith(drawings.get(place.dataset.key).element);
  for (const item of view.items) if (item.isVisible) refresh(item);
}

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const colourNames = {
  north: 0, x: 0, roll: 0, lat: 0, vn: 0, along: 0,
  east: 1, y: 1, pitch: 1, lon: 1, ve: 1, cross: 1,
  down: 2, z: 2, yaw: 2, height: 2, vd: 2, up: 2,
  horizontal: 3, tilt: 3, length: 3,
};

/// The same component has the same colour wherever it is drawn.
const colourOf = (name, index) => `--c${name in colourNames ? colourNames[name] : index % 6}`;

const outcomeColour = (code) => css(`--o${code}`);

/// Of 99.7 % there should be.
function shareClass({ three, of }) {
  return three >= 0.99 * of ? 'fine' : three >= 0.95 * of ? 'so-so' : 'poor';
}

/// With an empty row in every gap: no line is drawn where there was nothing.
function broken(rows) {
  const steps = rows.slice(1).map((r, i) => r[0] - rows[i][0]).sort((a, b) => a - b);
  const gap = 10 * (steps[steps.length >> 1] || 0);
  const least = rows.length ? (rows[rows.length - 1][0] - rows[0][0]) / 200 : 0;
  return rows.flatMap((r, i) => {
    const before = i ? r[0] - rows[i - 1][0] : 0;
    return before > gap && before > least ? [[r[0] - before / 2, null, null, null], r] : [r];
  });
}

// ---- a plot

/// spec: { title, unit, name, span, windows, t, v, s, turn, centre, outcomes, lines: [{ value | column, label }], moving, stat, colour, n, least }
class TimePlot {
  constructor(spec) {
    this.readout = el('span', {});
    this.unit = el('span', { class: 'unit' });
    this.plot = el('div', { class: 'plot' });
    this.line = el('div', { class: 'cursor' });
    this.element = el('figure', { class: 'chart', 'data-name': spec.name },
      el('figcaption', {}, el('span', { class: 'swatch', style: `background: var(${spec.colour})` }), el('b', {}, spec.title), this.unit, this.readout),
      el('div', { class: 'canvas' }, this.plot, this.line));
    this.take(spec);
    watch(this);
  }

  /// Other data of the same plot.
  take(spec) {
    this.spec = spec;
    this.span = spec.span;
    this.t = null;
    this.isStale = true;
    this.unit.textContent = spec.unit && spec.unit !== '1' ? spec.unit : '';
    this.readout.className = 'readout ' + (spec.within ? shareClass(spec.within) : '');
    if (!this.element.classList.contains('read')) this.readout.textContent = spec.stat || '';
  }

  unpack() {
    if (this.t) return;
    const spec = this.spec;
    this.t = column(spec.t);
    this.v = column(spec.v);
    this.s = column(spec.s);
    this.o = column(spec.o);
    this.lows = column(spec.lows);
    this.highs = column(spec.highs);
    this.moving = spec.moving && { t: column(spec.moving.t), v: column(spec.moving.v) };
  }

  /// Rows of dygraphs: time, value, lower and upper bound.
  rows(from, to) {
    const stretches = Math.max(200, Math.round(this.plot.clientWidth || 600));
    const columns = this.s ? [this.v, this.s] : [this.v];
    const indices = indicesWithin(this.t, from, to, columns, this.o, stretches);
    this.kinds = this.o ? indices.map((i) => this.o[i]) : null;
    const centre = this.spec.centre === 'value';
    const rows = indices.map((i) => {
      const value = this.v[i], half = this.s ? 3 * this.s[i] : null;
      const middle = centre ? value : 0;
      const low = this.lows ? this.lows[i] : half === null ? null : this.spec.isLength ? 0 : middle - half;
      const high = this.highs ? this.highs[i] : half === null ? null : middle + half;
      return [this.t[i], Number.isNaN(value) ? null : value, low, high];
    });
    return this.o ? rows : broken(rows);
  }

  /// All of the values, and as much of the band as it takes for most of it: what a filter did not know at its start
  /// would flatten everything that came later.
  range(rows, from, to) {
    const inside = rows.filter((r) => r[0] >= from && r[0] <= to);
    const values = inside.map((r) => r[1]).filter(isNumber);
    if (!values.length) return [0, 1];
    let low = Math.min(...values), high = Math.max(...values);
    const bands = inside.map((r) => r[3]).filter(isNumber).sort((a, b) => a - b);
    const lows = inside.map((r) => r[2]).filter(isNumber).sort((a, b) => b - a);
    if (bands.length && !this.highs) {
      const at = Math.floor(0.95 * (bands.length - 1));
      high = Math.max(high, bands[at]);
      low = Math.min(low, lows[at]);
    }
    if (this.spec.isSquare) {
      const sorted = values.slice().sort((a, b) => a - b);
      const usual = sorted[Math.floor(0.99 * (sorted.length - 1))];
      high = Math.max(usual, 1.25 * (this.spec.high || Math.max(...(this.highs || [0]))));
      low = 0;
    }
    for (const line of this.spec.lines || []) if (line.isInRange) {
      low = Math.min(low, line.value);
      high = Math.max(high, line.value);
    }
    const margin = (high - low || Math.abs(high) || 1) * 0.06;
    return [this.spec.isSquare || this.spec.isLength || this.spec.least === 0 ? Math.min(0, low) : low - margin, high + margin];
  }

  show([from, to]) {
    this.unpack();
    const rows = this.rows(from, to);
    this.drawn = rows;
    this.userRange = null;
    const options = { file: rows.length ? rows : [[from, null, null, null]], dateWindow: [from, to], valueRange: this.range(rows, from, to) };
    if (this.graph) this.graph.updateOptions(options);
    else this.graph = this.made(options);
    this.element.dataset.from = from;
    this.element.dataset.to = to;
    this.element.dataset.points = rows.length;
  }

  made(options) {
    const plot = this;
    return new Dygraph(this.plot, options.file, {
      ...options,
      labels: ['t', 'value', 'low', 'high'],
      legend: 'never',
      rightGap: 6,
      xRangePad: 0,
      axisLabelFontSize: 11,
      axisLineColor: css('--line'),
      gridLineColor: css('--grid'),
      gridLineWidth: 1,
      highlightCircleSize: 3,
      drawHighlightPointCallback: drawHighlight,
      pixelRatio: document.documentElement.classList.contains('printing') ? 2 : null,
      plotter: (event) => event.seriesIndex === 0 && plot.draw(event),
      underlayCallback: (context, area, graph) => plot.drawUnder(context, area, graph),
      axes: {
        x: { axisLabelFormatter: (t, granularity, opts, graph) => tick(t, graph.xAxisRange()), pixelsPerLabel: 48 },
        y: { axisLabelFormatter: (value, granularity, opts, graph) => tick(value, graph.yAxisRange()), axisLabelWidth: this.plot.clientWidth < 420 ? 44 : 54, pixelsPerLabel: 22 },
      },
      zoomCallback: (from, to, ranges) => plot.zoomed(from, to, ranges),
      highlightCallback: (event, t, points, index) => plot.highlighted(t, index),
      unhighlightCallback: () => plot.unhighlighted(),
      interactionModel: interaction,
    });
  }

  /// By the mouse in this plot: along time for all, along values for this one.
  zoomed(from, to) {
    const [a, b] = view.window || this.span;
    if (Math.abs(from - a) > 1e-9 * (b - a) || Math.abs(to - b) > 1e-9 * (b - a)) setWindow(from, to);
  }

  highlighted(t, index) {
    const point = this.drawn[index];
    if (point) this.readout.textContent = this.described(point, index);
    this.element.classList.add('read');
    setCursor(t);
  }

  described([t, value, low, high], index) {
    const spec = this.spec;
    const digits = (number) => (isNumber(number) ? withMinus(String(Number(number.toPrecision(7)))) : '\u2013');
    let text = `t ${Number(t.toFixed(6))} s: ${digits(value)}`;
    if (this.s) text += spec.isLength ? `, 3\u03c3 ${digits(high)}` : `, 3\u03c3 ${digits((high - low) / 2)}`;
    else if (spec.high && !this.lows) text += ` (95 %: ${figure(spec.low)} to ${figure(spec.high)})`;
    else if (this.highs) text += ` (95 %: ${figure(low)} to ${figure(high)})`;
    if (this.kinds) text += `, ${outcomeNames[this.kinds[index]]}`;
    return text;
  }

  unhighlighted() {
    this.readout.textContent = this.spec.stat || '';
    this.element.classList.remove('read');
    setCursor(null);
  }

  cursor(t) {
    const graph = this.graph;
    if (!graph) return;
    const [from, to] = graph.xAxisRange();
    const is = t !== null && t >= from && t <= to;
    this.line.style.display = is ? 'block' : 'none';
    if (is) this.line.style.left = graph.toDomXCoord(t) + 'px';
  }

  // -- drawing

  drawUnder(context, area, graph) {
    context.save();
    context.fillStyle = css('--window');
    for (const window of this.spec.windows || []) {
      const left = Math.max(area.x, graph.toDomXCoord(window.from)), right = Math.min(area.x + area.w, graph.toDomXCoord(window.to));
      if (right > left) context.fillRect(left, area.y, right - left, area.h);
    }
    context.strokeStyle = css('--bound');
    context.setLineDash([4, 3]);
    for (const line of this.spec.lines || []) {
      const y = graph.toDomYCoord(line.value);
      if (!(y >= area.y && y <= area.y + area.h)) continue;
      context.beginPath();
      context.moveTo(area.x, Math.round(y) + 0.5);
      context.lineTo(area.x + area.w, Math.round(y) + 0.5);
      context.stroke();
    }
    context.restore();
  }

  draw(event) {
    const [values, lows, highs] = event.allSeriesPoints;
    const context = event.drawingContext, area = event.plotArea;
    const colour = css(this.spec.colour);
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.w, area.h);
    context.clip();
    if (this.lows || this.s) drawBand(context, lows, highs, colour, !!this.lows);
    if (this.spec.centre !== 'value' && this.s) drawLevel(context, area, event.dygraph.toDomYCoord(0));
    if (this.o) this.drawPoints(context, values, area);
    else drawLine(context, values, colour, this.spec.turn);
    if (this.moving) this.drawMoving(context, event.dygraph);
    context.restore();
  }

  drawPoints(context, points, area) {
    const radius = points.length > 1500 ? 1.3 : 1.9;
    const plain = css(this.spec.colour);
    for (let pass = 0; pass < 2; ++pass)
      for (let i = 0; i < points.length; ++i) {
        const kind = this.kinds[i], y = points[i].canvasy;
        if ((kind === 0) !== (pass === 0) || Number.isNaN(y)) continue;
        context.fillStyle = kind === 0 ? plain : outcomeColour(kind);
        context.globalAlpha = kind === 0 ? 0.65 : 1;
        context.beginPath();
        if (y < area.y) wedge(context, points[i].canvasx, area.y + 1, 1);
        else if (y > area.y + area.h) wedge(context, points[i].canvasx, area.y + area.h - 1, -1);
        else context.arc(points[i].canvasx, y, kind === 0 ? radius : radius + 0.5, 0, 2 * Math.PI);
        context.fill();
      }
    context.globalAlpha = 1;
  }

  drawMoving(context, graph) {
    context.strokeStyle = css('--text');
    context.lineWidth = 1.5;
    context.beginPath();
    this.moving.t.forEach((t, i) => context.lineTo(graph.toDomXCoord(t), graph.toDomYCoord(this.moving.v[i])));
    context.stroke();
  }
}

/// What lies beyond the plot's edge is shown there.
function wedge(context, x, y, direction) {
  context.moveTo(x, y);
  context.lineTo(x - 3, y + 5 * direction);
  context.lineTo(x + 3, y + 5 * direction);
}

/// The stretches in which both edges are known.
function runs(lows, highs) {
  const list = [];
  let run = [];
  highs.forEach((point, i) => {
    if (!Number.isNaN(point.canvasy) && !Number.isNaN(lows[i].canvasy)) run.push(i);
    else if (run.length) {
      list.push(run);
      run = [];
    }
  });
  return run.length ? [...list, run] : list;
}

function drawBand(context, lows, highs, colour, isOutline) {
  for (const run of runs(lows, highs)) {
    if (isOutline) {
      drawEdges(context, [lows, highs], run, css('--bound'), 1, [4, 3]);
      continue;
    }
    context.beginPath();
    for (const i of run) context.lineTo(highs[i].canvasx, highs[i].canvasy);
    for (const i of run.slice().reverse()) context.lineTo(lows[i].canvasx, lows[i].canvasy);
    context.closePath();
    context.fillStyle = colour;
    context.globalAlpha = 0.16;
    context.fill();
    context.globalAlpha = 1;
    drawEdges(context, [lows, highs], run, colour, 0.45, []);
  }
}

function drawEdges(context, edges, run, colour, alpha, dashes) {
  context.globalAlpha = alpha;
  context.strokeStyle = colour;
  context.lineWidth = 0.8;
  context.setLineDash(dashes);
  for (const edge of edges) {
    context.beginPath();
    for (const i of run) context.lineTo(edge[i].canvasx, edge[i].canvasy);
    context.stroke();
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
}

function drawLevel(context, area, y) {
  context.strokeStyle = css('--line');
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(area.x, y);
  context.lineTo(area.x + area.w, y);
  context.stroke();
}

/// Broken where an angle jumps by a turn.
function drawLine(context, points, colour, turn) {
  context.strokeStyle = colour;
  context.lineWidth = 1.4;
  context.lineJoin = 'round';
  context.beginPath();
  let last = null;
  for (const point of points) {
    if (Number.isNaN(point.canvasy)) {
      last = null;
      continue;
    }
    if (last && !(turn && Math.abs(point.yval - last.yval) > turn / 2)) context.lineTo(point.canvasx, point.canvasy);
    else context.moveTo(point.canvasx, point.canvasy);
    last = point;
  }
  context.stroke();
}

function drawHighlight(graph, name, context, x, y, colour, size) {
  if (name !== 'value') return;
  context.fillStyle = css('--text');
  context.beginPath();
  context.arc(x, y, size, 0, 2 * Math.PI);
  context.fill();
}

/// As many decimals as tell neighbouring ticks apart.
function tick(value, [low, high]) {
  const range = high - low;
  if (!(range > 0)) return figure(value);
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (Math.abs(value) < range * 1e-9) return '0';
  if (size >= 1e6 || size < 1e-3) return withMinus(value.toExponential(Math.max(0, Math.min(4, Math.ceil(Math.log10(size / range) + 0.7)))).replace('e+', 'e'));
  const text = value.toFixed(Math.max(0, Math.min(9, Math.ceil(-Math.log10(range / 6)))));
  return withMinus(/\./.test(text) ? text.replace(/\.?0+$/, '') : text);
}

// ---- the hand

/// One finger scrolls the page; two zoom. The mouse: drag to zoom, shift-drag to move, double click for all.
const interaction = {
  ...Dygraph.defaultInteractionModel,
  touchstart: (event, graph, context) => event.touches.length > 1 && Dygraph.startTouch(event, graph, context),
  touchmove: (event, graph, context) => {
    if (event.touches.length > 1 && context.initialTouches) Dygraph.moveTouch(event, graph, context);
  },
  touchend: (event, graph, context) => {
    if (!context.initialTouches) return;
    Dygraph.endTouch(event, graph, context);
    context.initialTouches = null;
    setWindow(...graph.xAxisRange());
  },
  dblclick: () => setWindow(null),
};
interaction.mousedown = (event, graph, context) => {
  Dygraph.defaultInteractionModel.mousedown(event, graph, context);
  if (!event.altKey && !event.shiftKey) return;
  const done = () => {
    document.removeEventListener('mouseup', done);
    setTimeout(() => setWindow(...graph.xAxisRange()));
  };
  document.addEventListener('mouseup', done);
};
