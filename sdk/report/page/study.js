// SPDX-License-Identifier: Apache-2.0
// A study: its tables beside the paper's, how each metric is distributed over the runs, what broke.

function studyTable(path, plan) {
  const hasPaper = (c) => plan.paper && plan.paper.some((line) => line && isNumber(line[c]));
  const unitOf = (cells) => {
    const units = new Set(cells.filter(Boolean));
    return units.size === 1 ? [...units][0] : '';
  };
  const common = unitOf(plan.units.flat());
  const columns = plan.columns.map((name, c) => ({ name, paper: hasPaper(c), unit: common ? '' : unitOf(plan.units.map((line) => line[c])) }));
  const anyPaper = columns.some((entry) => entry.paper);
  const heads = [
    el('tr', {}, el('th', { rowspan: anyPaper ? 2 : 1 }, ''), columns.map((entry) =>
      el('th', { class: 'n span', scope: 'colgroup', colspan: entry.paper ? 2 : 1 }, entry.name, entry.unit && entry.unit !== '1' ? el('span', { class: 'unit' }, ` ${entry.unit}`) : ''))),
    anyPaper && el('tr', {}, columns.map((entry) => [el('th', { class: 'n' }, 'here'), entry.paper && el('th', { class: 'n paper' }, 'paper')])),
  ].filter(Boolean);
  const rows = plan.rows.map((name, r) => row(name, columns.map((entry, c) => {
    const cell = plan.cells[r][c], se = plan.se && plan.se[r] ? plan.se[r][c] : null;
    const own = typeof cell === 'number' ? measured(`${path}/cells/${r}/${c}`, cell, `${path}/se/${r}/${c}`, se) : el('td', { class: 'n' }, cell || '');
    const paper = entry.paper && numeral(`${path}/paper/${r}/${c}`, plan.paper[r][c], (value) => (isNumber(value) ? withMinus(String(value)) : '\u2013'));
    if (paper) paper.classList.add('paper');
    return [own, paper];
  })));
  return table(heads, rows, { caption: plan.title + (common && common !== '1' ? ` [${common}]` : '') });
}

function metricTable(root, figures, metric) {
  const names = Object.keys(figures.variants).filter((name) => figures.variants[name].metrics[metric]);
  const entries = names.map((name) => figures.variants[name].metrics[metric]);
  const hasBand = entries.some((entry) => entry.band);
  const rows = names.map((name, i) => {
    const entry = entries[i], at = `${root}/variants${token(name)}/metrics${token(metric)}`;
    const cell = (key, show = figure) => numeral(`${at}/${key}`, entry[key], show);
    return row(name, measured(`${at}/rms`, entry.rms, `${at}/se_rms`, entry.se_rms), measured(`${at}/mean`, entry.mean, `${at}/se`, entry.se), cell('std'), cell('p50'), cell('p95'),
      cell('max'), cell('n', count), hasBand && (entry.band
        ? el('td', {}, numeral(`${at}/band/0`, entry.band[0], figure, 'span'), ' to ', numeral(`${at}/band/1`, entry.band[1], figure, 'span'), ' ', bandBadge(entry.mean, entry.band[0], entry.band[1]))
        : el('td')));
  });
  return table(['variant', 'rms', 'mean', 'std', 'p50', 'p95', 'max', 'runs', ...(hasBand ? ['mean if consistent (99 %)'] : [])], rows, { left: hasBand ? [8] : [] });
}

// ---- distributions

/// Each variant as a row: every run a dot, the middle half a box, 5 % to 95 % a line, median and rms marked.
class Distribution {
  constructor(study) {
    this.study = study;
    this.metric = 0;
    this.isMagnitude = true;
    this.isCumulative = false;
    this.picture = svg('svg', { class: 'distribution', role: 'img' });
    this.legend = el('div', { class: 'legend' });
    this.element = el('figure', { class: 'track' }, this.controls(), this.picture, this.legend);
    for (const [target, event] of [[window, 'resize'], [this.element, 'fit']]) target.addEventListener(event, () => this.draw());
    requestAnimationFrame(() => this.draw());
  }

  controls() {
    const box = (text, change, on) => el('label', {}, el('input', { type: 'checkbox', checked: on, onchange: (event) => { change(event.target.checked); this.draw(); } }), ' ' + text);
    return el('div', { class: 'controls' },
      el('label', {}, 'Metric ', el('select', { onchange: (event) => { this.metric = Number(event.target.value); this.draw(); } },
        this.study.metrics.map((metric, i) => el('option', { value: i }, metric.name + bracketed(metric.unit))))),
      box('magnitudes', (on) => { this.isMagnitude = on; }, true), box('cumulative', (on) => { this.isCumulative = on; }, false));
  }

  sorted(variant) {
    const values = Array.from(column(this.study.metrics[this.metric].values[variant]) || []);
    return (this.isMagnitude ? values.map(Math.abs) : values).sort((a, b) => a - b);
  }

  draw() {
    const metric = this.study.metrics[this.metric];
    const rows = this.study.variants.map((name, v) => ({ name, values: this.sorted(v), v })).filter((entry) => entry.values.length);
    const width = this.picture.parentElement ? this.picture.parentElement.clientWidth : 0;
    if (!width || !rows.length) return;
    const all = rows.flatMap((entry) => [entry.values[0], entry.values[entry.values.length - 1]]);
    const low = this.isMagnitude ? 0 : Math.min(...all), high = Math.max(...all, low + 1e-300);
    const isNarrow = width < 560;
    const left = this.isCumulative ? 46 : isNarrow ? 8 : Math.min(190, 16 + 7.4 * Math.max(...rows.map((entry) => entry.name.length)));
    const scale = { low, high, left, right: width - 16, x: (value) => left + ((value - low) / (high - low || 1)) * (width - 16 - left) };
    const each = isNarrow ? 44 : 30;
    const height = this.isCumulative ? 320 : each * rows.length + 44;
    this.picture.replaceChildren();
    this.picture.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.picture.style.height = height + 'px';
    this.picture.setAttribute('aria-label', `Distribution of ${metric.name}`);
    this.axis(scale, height, metric);
    if (this.isCumulative) this.cumulative(rows, scale, height);
    else rows.forEach((entry, i) => this.strip(entry, scale, i * each + (isNarrow ? 26 : 15), isNarrow));
    this.legend.replaceChildren(...(this.isCumulative
      ? rows.map((entry) => el('span', { class: 'key' }, el('i', { style: `background: var(--c${entry.v % 6}); opacity: ${entry.v < 6 ? 1 : 0.5}` }), entry.name))
      : [el('span', {}, 'dot: a run \u00b7 box: the middle half, its line the median \u00b7 line: 5 % to 95 % \u00b7 diamond: rms')]));
  }

  axis({ low, high, x, left, right }, height, metric) {
    const step = niceStep((high - low) / Math.max(3, (right - left) / 110) || 1);
    const grid = svg('g', { class: 'grid' });
    for (let value = Math.ceil(low / step - 1e-9) * step; value <= high + step * 1e-9; value += step)
      grid.append(svg('line', { x1: x(value), x2: x(value), y1: 0, y2: height - 36 }), svg('text', { x: x(value), y: height - 22, 'text-anchor': 'middle' }, tick(value, [low, high])));
    grid.append(svg('text', { x: right, y: height - 5, 'text-anchor': 'end' }, `${this.isMagnitude ? '|' : ''}${metric.name}${this.isMagnitude ? '|' : ''}${bracketed(metric.unit)}`));
    this.picture.append(grid);
  }

  strip({ name, values, v }, { x }, y, isNarrow) {
    const figures = (this.isMagnitude && this.study.figures.variants[name].metrics[this.study.metrics[this.metric].name]) || {};
    const quantile = (q) => (q === 0.5 && figures.p50) || (q === 0.95 && figures.p95) || between(values, q);
    const rms = figures.rms || 0;
    const colour = `var(--c${this.colour(v)})`;
    const group = svg('g', {}, svg('title', {}, `${name}: median ${figure(quantile(0.5))}, 5 % to 95 %: ${figure(quantile(0.05))} to ${figure(quantile(0.95))}, rms ${figure(rms)}`));
    group.append(svg('text', { class: 'label', x: 8, y: isNarrow ? y - 12 : y + 4 }, name));
    group.append(svg('line', { x1: x(quantile(0.05)), x2: x(quantile(0.95)), y1: y, y2: y, style: `stroke: ${colour}; stroke-width: 1.2` }));
    group.append(svg('rect', { x: x(quantile(0.25)), width: Math.max(1, x(quantile(0.75)) - x(quantile(0.25))), y: y - 8, height: 16, rx: 2, style: `fill: ${colour}; fill-opacity: .18; stroke: ${colour}` }));
    values.forEach((value, i) => group.append(svg('circle', { cx: x(value).toFixed(1), cy: (y + scatter(i)).toFixed(1), r: 1.6, style: `fill: ${colour}; fill-opacity: .55` })));
    group.append(svg('line', { x1: x(quantile(0.5)), x2: x(quantile(0.5)), y1: y - 8, y2: y + 8, style: `stroke: ${colour}; stroke-width: 2.5` }));
    if (this.isMagnitude) group.append(svg('path', { d: `M${x(rms)} ${y - 5}l5 5l-5 5l-5 -5z`, style: 'fill: var(--text)' }));
    this.picture.append(group);
  }

  /// Variants of one kind ("ekf x1", "ekf x2") have one colour.
  colour(v) {
    const kinds = [...new Set(this.study.variants.map((name) => name.split(' ')[0]))];
    return kinds.length < this.study.variants.length ? kinds.indexOf(this.study.variants[v].split(' ')[0]) % 6 : v % 6;
  }

  cumulative(rows, { x, left, right }, height) {
    const y = (share) => 8 + (1 - share) * (height - 52);
    const grid = svg('g', { class: 'grid' });
    for (const share of [0, 0.25, 0.5, 0.75, 1]) grid.append(svg('line', { x1: left, x2: right, y1: y(share), y2: y(share) }), svg('text', { x: left - 6, y: y(share) + 4, 'text-anchor': 'end' }, `${100 * share} %`));
    this.picture.append(grid);
    for (const { name, values, v } of rows) {
      let d = `M${x(values[0]).toFixed(1)} ${y(0)}`;
      values.forEach((value, i) => { d += `H${x(value).toFixed(1)}V${y((i + 1) / values.length).toFixed(1)}`; });
      this.picture.append(svg('path', { d, style: `fill: none; stroke: var(--c${v % 6}); stroke-width: 1.6; ${v < 6 ? '' : 'stroke-dasharray: 5 3'}` }, svg('title', {}, name)));
    }
  }
}

/// Between the two values around it, of sorted ones.
function between(values, q) {
  const at = q * (values.length - 1), i = Math.floor(at);
  return i + 1 < values.length ? values[i] + (at - i) * (values[i + 1] - values[i]) : values[i];
}

/// Dots of a row lie apart, the same way every time.
function scatter(i) {
  const noise = Math.sin((i + 1) * 12.9898) * 43758.5453;
  return 11 * (noise - Math.floor(noise)) - 5.5;
}

function failureTable(root, figures) {
  const rows = Object.entries(figures.variants).flatMap(([name, variant]) => (variant.failures || []).map((failure, i) => {
    const at = `${root}/variants${token(name)}/failures/${i}`;
    return row(name, numeral(at + '/run', failure.run, count), el('td', {}, failure.reason));
  }));
  return rows.length ? table(['variant', 'run', 'reason'], rows, { left: [2] }) : null;
}

function studySections(study) {
  const figures = study.figures, root = '/study';
  const sections = [];
  const plans = figures.tables || (figures.table ? [figures.table] : []);
  if (figures.tables && figures.table) for (const [path] of leaves(figures.table, root + '/table')) shownPaths.add(path);
  if (plans.length)
    sections.push(section('Tables', plans[0].paper || plans.some((plan) => plan.paper)
      ? 'Figures of this study beside those that the paper prints. \u00b1 is one standard error: a difference of more than two or three of them is more than chance.'
      : '\u00b1 is one standard error.', plans.map((plan, i) => studyTable(figures.tables ? `${root}/tables/${i}` : root + '/table', plan))));
  sections.push(section('Distributions', `What ${study.runs} runs of each variant came to. Runs of the same number have the same random draws in every variant, so variants are compared run by run.`, new Distribution(study).element));
  sections.push(section('Metrics', 'rms, mean and std over runs, then percentiles of the magnitude.', study.metrics.map((metric) => [el('h4', {}, metric.name + bracketed(metric.unit)), metricTable(root, figures, metric.name)])));
  const failures = failureTable(root, figures);
  const failed = Object.values(figures.variants).reduce((sum, variant) => sum + (variant.failed || 0), 0);
  sections.push(section('Failed runs', failed ? 'These runs broke; the figures are of the others.' : 'None: every run of every variant was finished.', failures));
  return sections;
}
