// SPDX-License-Identifier: Apache-2.0
// Several runs: what differs, and their curves over each other. A page of one run has nothing of this.

const runColour = (i) => `--c${i % 6}`;

/// spec as of TimePlot, with { curves: [{ name, colour, t, v, s }] } in place of t, v and s; of s the edges at three times it are drawn.
class OverlayPlot extends TimePlot {
  unpack() {
    if (this.t) return;
    this.curves = this.spec.curves.map((curve) => ({ ...curve, t: column(curve.t), v: column(curve.v), s: column(curve.s) }));
    this.t = this.curves[0].t;
  }

  /// Those of the curve with the most, which the cursor follows; the others are kept for draw().
  rows(from, to) {
    const stretches = Math.max(200, Math.round(this.plot.clientWidth || 600));
    for (const curve of this.curves) {
      const indices = indicesWithin(curve.t, from, to, curve.s ? [curve.v, curve.s] : [curve.v], null, stretches);
      curve.rows = broken(indices.map((i) => {
        const half = curve.s ? 3 * curve.s[i] : null;
        return [curve.t[i], Number.isNaN(curve.v[i]) ? null : curve.v[i], half === null ? null : this.spec.isLength ? 0 : -half, half];
      }));
    }
    return this.curves.reduce((most, curve) => (curve.rows.length > most.length ? curve.rows : most), this.curves[0].rows);
  }

  range(rows, from, to) { return super.range(this.curves.flatMap((curve) => curve.rows), from, to); }

  described([t]) {
    const values = this.curves.map((curve) => {
      const i = lowerBound(curve.t, t), near = i > 0 && (i === curve.t.length || t - curve.t[i - 1] < curve.t[i] - t) ? i - 1 : i;
      return `${curve.name} ${t < curve.t[0] || t > curve.t[curve.t.length - 1] ? '\u2013' : figure(curve.v[near])}`;
    });
    return `t ${Number(t.toFixed(6))} s: ${values.join(', ')}`;
  }

  draw(event) {
    const context = event.drawingContext, area = event.plotArea, graph = event.dygraph;
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.w, area.h);
    context.clip();
    if (this.curves.some((curve) => curve.s)) drawLevel(context, area, graph.toDomYCoord(0));
    for (const curve of this.curves) {
      const colour = css(curve.colour), points = (place) => curve.rows.map((row) => ({ canvasx: graph.toDomXCoord(row[0]), canvasy: row[place] === null ? NaN : graph.toDomYCoord(row[place]), yval: row[place] }));
      if (curve.s) {
        context.setLineDash([4, 3]);
        context.globalAlpha = 0.7;
        for (const place of this.spec.isLength ? [3] : [2, 3]) drawLine(context, points(place), colour);
        context.setLineDash([]);
        context.globalAlpha = 1;
      }
      drawLine(context, points(1), colour, this.spec.turn);
    }
    context.restore();
  }
}

/// The tracks of several runs about one origin, each in its colour; the reference of the first that has one.
class OverlayMap extends TrackMap {
  unpack(filter) {
    this.tracks = filter.tracks.map((entry) => ({ ...entry, path: unpackedPath(entry.track.estimate) }));
    const referenced = filter.tracks.find((entry) => entry.track.reference);
    this.track = filter.tracks[0].track;
    this.paths = { estimate: this.tracks[0].path, reference: referenced && unpackedPath(referenced.track.reference) };
  }

  controls() {
    const button = (text, label, scale) => el('button', { type: 'button', 'aria-label': label, title: label, onclick: () => this.zoom(scale) }, text);
    return el('div', { class: 'controls' }, el('span', { class: 'steps' }, button('\u2212', 'Zoom out', 1.6), button('+', 'Zoom in', 1 / 1.6), button('All', 'Whole track', null)));
  }

  bounds() {
    const all = [...this.tracks.map((entry) => entry.path), this.paths.reference].filter(Boolean);
    return { left: Math.min(...all.map(({ e }) => least(e))), right: Math.max(...all.map(({ e }) => greatest(e))), low: Math.min(...all.map(({ n }) => least(n))), high: Math.max(...all.map(({ n }) => greatest(n))) };
  }

  draw() {
    const picture = this.picture;
    picture.replaceChildren();
    picture.setAttribute('viewBox', `0 0 ${this.size.width} ${this.size.height}`);
    picture.append(this.grid());
    if (this.paths.reference) picture.append(this.line(this.paths.reference, 'reference'));
    // The first is the widest, so that what lies on it does not hide it.
    this.tracks.forEach(({ path, colour, name }, k) => {
      const width = 2 + 1.5 * (this.tracks.length - 1 - k);
      const line = this.line(path, 'estimate');
      line.dataset.run = name;
      for (const part of line.children) part.setAttribute('style', `stroke: var(${colour}); stroke-width: ${width}`);
      picture.append(line);
    });
    this.part = svg('g', {});
    this.dots = this.tracks.map(({ colour }) => svg('circle', { class: 'here', r: 5, visibility: 'hidden', style: `fill: var(${colour})` }));
    const first = this.paths.estimate;
    picture.append(this.part, this.mark(first, 0, 'start'), this.mark(first, first.e.length - 1, 'end'), this.scaleBar(), ...this.dots);
    this.drawWindow();
    this.drawLegend();
  }

  drawWindow() {
    this.part.replaceChildren();
    if (!view.window) return;
    for (const { path, colour } of this.tracks)
      this.part.append(svg('polyline', { class: 'part', style: `stroke: var(${colour})`, points: this.points(path, lowerBound(path.t, view.window[0]), lowerBound(path.t, view.window[1])) }));
  }

  cursor(t) {
    this.tracks.forEach(({ path }, k) => {
      const is = t !== null && t >= path.t[0] && t <= path.t[path.t.length - 1];
      this.dots[k].setAttribute('visibility', is ? 'visible' : 'hidden');
      if (!is) return;
      const i = Math.min(path.t.length - 1, lowerBound(path.t, t));
      this.dots[k].setAttribute('cx', this.px(path.e[i]));
      this.dots[k].setAttribute('cy', this.py(path.n[i]));
    });
  }

  drawLegend() {
    const origin = this.track.origin;
    this.legend.replaceChildren(...runKeys(this.tracks), ...(this.paths.reference ? [el('span', { class: 'key' }, el('i', { class: 'reference' }), 'reference')] : []),
      el('span', { class: 'origin' }, origin ? `origin ${withMinus(origin.lat.toFixed(6))}\u00b0, ${withMinus(origin.lon.toFixed(6))}\u00b0` : ''));
  }
}

const runKeys = (list) => list.map(({ name, colour }) => el('span', { class: 'key' }, el('i', { style: `background: var(${colour})` }), name));

// ---- tables

const compared = () => payload.comparison;
const runNames = () => compared().runs.map((run) => run.name);

function runsSection() {
  const { runs, lacks } = compared();
  return section('Runs', 'Each has the colour in which its curves are drawn.',
    table(['run', 'title', 'folder', 'command', 'version', 'seed', 'made'], runs.map((run, i) => row(runKeys([{ name: run.name, colour: runColour(i) }]),
      ...['title', 'folder', 'command', 'version', 'seed', 'created'].map((key) => el('td', key === 'folder' || key === 'command' ? { class: 'path' } : {}, run[key] === null ? '' : String(run[key]))))), { left: [1, 2, 3, 4, 5, 6] }),
    lacks.length ? [el('h4', {}, 'What is not in all of them'), el('ul', { class: 'warnings lacks' }, lacks.map((text) => el('li', {}, text)))] : null);
}

function verdictSection() {
  return section('Verdicts', 'Whether the filter\u2019s estimates can be trusted, and the codes of its reasons.', table(['filter', ...runNames()], compared().verdicts.map((entry) => row(entry.filter,
    ...entry.states.map((state, i) => el('td', { class: 'verdict', title: entry.codes[i].join(', ') }, state === null ? '\u2013' : [state, entry.codes[i].length ? ` (${[...new Set(entry.codes[i])].join(', ')})` : ''])))), { left: runNames().map((name, i) => i + 1) }));
}

const isHeadline = (name) => /\/(rms|nees_mean|nis_mean|accepted|gated|recoveries)$/.test(name) && !/\/windows\//.test(name);

function metricRows(keep) {
  return compared().metrics.map((metric, m) => ({ metric, m })).filter(({ metric }) => keep(metric.name)).map(({ metric, m }) => row(metric.name,
    ...metric.values.map((value, i) => numeral(`/comparison/metrics/${m}/values/${i}`, value)),
    ...metric.differences.slice(1).map((value, i) => numeral(`/comparison/metrics/${m}/differences/${i + 1}`, value)), unitCell(metric)));
}

function metricsSection() {
  const names = runNames(), heads = ['figure', ...names, ...names.slice(1).map((name) => `${name} \u2212 ${names[0]}`), 'unit'];
  const left = { left: [heads.length - 1] }, rest = metricRows((name) => !isHeadline(name));
  return section('Differences', `Figures of the summaries; a difference is a run\u2019s less that of ${names[0]}. Hover a figure for all of its digits.`, table(heads, metricRows(isHeadline), left),
    rest.length ? el('details', {}, el('summary', {}, `${rest.length} further figures`), table(heads, rest, left)) : null);
}

function configSection() {
  const shown = (value) => (value === null ? '\u2013' : JSON.stringify(value)), short = (text) => (text.length > 160 ? text.slice(0, 160) + '\u2026' : text);
  const list = compared().config;
  if (!list.length) return section('Configs', 'They are the same in all runs.');
  return section('Configs', 'Where they differ, by JSON pointer; \u2013 where a run has nothing. Hover a value for all of it.', table(['pointer', ...runNames()], list.map((entry) => row(entry.pointer || '/',
    ...entry.values.map((value) => el('td', { class: 'path', title: shown(value) }, short(shown(value)))))), { left: runNames().map((name, i) => i + 1) }));
}

// ---- curves

/// [{ name, colour, filter }] of the runs that have it.
function membersOf(keys) {
  return keys.map((key, i) => ({ name: runNames()[i], colour: runColour(i), filter: key && payload.run.filters.find((filter) => filter.name === key) })).filter(({ filter }) => filter && filter.span && filter.span[1] > filter.span[0]);
}

/// Names in the order in which they come, of all members.
function namesOf(members, list) {
  return [...new Set(members.flatMap(({ filter }) => list(filter).map((entry) => entry.name)))];
}

function spanOf(members) {
  return [Math.min(...members.map(({ filter }) => filter.span[0])), Math.max(...members.map(({ filter }) => filter.span[1]))];
}

/// `of(filter)` is the entry of a member, { t, v, s, unit, … }, or nothing. Entries of another unit than the first are not drawn with it.
function overlaid(shown, members, spec, of) {
  const found = members.map((member) => ({ ...member, entry: of(member.filter) })).filter(({ entry }) => entry && column(entry.t).length > 0);
  if (!found.length) return null;
  const { unit, turn, length } = found[0].entry, alike = found.filter(({ entry }) => (entry.unit || '') === (unit || ''));
  const others = found.filter((one) => !alike.includes(one)).map(({ name, entry }) => `${name} is in ${entry.unit}`);
  const name = `${shown} ${spec.name} of all`;
  return drawing(OverlayPlot, name, { span: spanOf(members), windows: [], unit, turn, isLength: length, colour: '--text', ...spec, name,
    stat: others.join(', ') || alike.map((one) => one.name).join(', '),
    curves: alike.map(({ name: run, colour, entry }) => ({ name: run, colour, t: entry.t, v: entry.v, s: spec.isBand ? entry.s : undefined })) });
}

const blockOf = (filter, name) => filter.blocks.find((block) => block.name === name) || { errors: [], estimates: [] };

function overlaidStates(shown, members) {
  const part = section('Errors and sigma', 'Over each other: errors within three times what each filter thinks of them, dashed; estimates; and the 1\u03c3 of each filter.');
  for (const block of namesOf(members, (filter) => filter.blocks)) {
    const of = (list, name) => (filter) => blockOf(filter, block)[list].find((entry) => entry.name === name);
    const errors = namesOf(members, (filter) => blockOf(filter, block).errors).map((name) => overlaid(shown, members, { title: name, name: `${block}.${name} error`, isBand: true }, of('errors', name)));
    const outputs = namesOf(members, (filter) => blockOf(filter, block).estimates);
    const estimates = outputs.map((name) => overlaid(shown, members, { title: name, name: `${block}.${name}` }, of('estimates', name)));
    const sigmas = outputs.map((name) => overlaid(shown, members, { title: name, name: `${block}.${name} sigma`, least: 0 }, (filter) => {
      const entry = of('estimates', name)(filter);
      return entry && entry.s !== undefined ? { t: entry.t, v: entry.s, unit: entry.unit } : null;
    }));
    const grid = (title, plots) => (plots.some(Boolean) ? [el('h5', {}, title), el('div', { class: 'grid' }, plots)] : null);
    part.element.append(el('div', { class: 'block' }, el('h4', {}, block), grid('error', errors), grid('estimate', estimates), grid('1\u03c3', sigmas)));
  }
  return part;
}

/// The mean over many samples over each other where there is one; below, sample by sample, side by side.
function overlaidNis(shown, members) {
  const names = namesOf(members, (filter) => filter.measurements.filter((measurement) => measurement.nis));
  if (!names.length) return null;
  const part = section('NIS of all', 'The mean over many samples, over each other; then sample by sample, side by side. Dashed: what 95 % of \u03c7\u00b2, or of such means, lie between.');
  for (const name of names) {
    const of = (filter) => filter.measurements.find((measurement) => measurement.name === name && measurement.nis);
    const means = members.map(({ filter }) => of(filter)).map((measurement) => measurement && measurement.nis.moving).filter(Boolean);
    const mean = means.length ? overlaid(shown, members, { title: 'mean NIS', name: `${name}.nis`, least: 0, lines: [{ value: means[0].low, isInRange: true }, { value: means[0].high, isInRange: true }] }, (filter) => of(filter) && of(filter).nis.moving) : null;
    part.element.append(el('div', { class: 'block' }, el('h4', {}, name), mean,
      el('div', { class: 'grid' }, members.filter(({ filter }) => of(filter)).map(({ name: run, filter }) => el('div', {}, el('h5', {}, run), nisPlot(filter, of(filter)))))));
  }
  return part;
}

function overlaidNees(shown, members) {
  const names = namesOf(members, (filter) => filter.nees);
  if (!names.length) return null;
  return section('NEES of all', 'Errors weighed by each filter\u2019s own covariance; dashed: 95 % of them should lie between.', el('div', { class: 'grid' }, names.map((name) => {
    const of = (filter) => filter.nees.find((entry) => entry.name === name), first = of(members.find(({ filter }) => of(filter)).filter);
    return overlaid(shown, members, { title: name, name: `${name}.nees`, isSquare: true, least: 0, high: first.high, lines: first.dof > 0 ? [{ value: first.low }, { value: first.high }] : [] }, of);
  })));
}

function overlaidTrack(shown, members) {
  const tracks = members.filter(({ filter }) => filter.track && column(filter.track.estimate.t).length).map(({ name, colour, filter }) => ({ name, colour, track: filter.track }));
  if (!tracks.length) return null;
  const map = drawing(OverlayMap, `${shown} track of all`, { name: `${shown} of all runs`, tracks });
  requestAnimationFrame(() => map.dispatchEvent(new Event('fit')));
  return section('Tracks', 'Metres east and north of where the first begins; both axes have one scale.', map);
}

function overlaidParts() {
  return compared().filters.flatMap((filter, i) => {
    const members = membersOf(compared().keys[i]);
    if (members.length < 2) return [];
    const keys = el('div', { class: 'legend' }, runKeys(members));
    const sections = [overlaidTrack(filter.name, members), overlaidStates(filter.name, members), overlaidNees(filter.name, members), overlaidNis(filter.name, members)].filter(Boolean);
    if (sections.length) sections[0].element.prepend(keys);
    return [{ title: `Filter ${filter.name}, all runs`, sections }];
  });
}

const headerOfOne = header;
header = () => headerOfOne('Runs compared', {});
verdicts = () => null;
parts = () => [
  { title: 'Comparison', sections: [runsSection(), verdictSection(), metricsSection(), configSection()] },
  ...overlaidParts(),
  ...payload.run.filters.map((filter) => ({ title: filter.name, sections: filterSections(filter, payload.run.summary.filters[filter.name] || {}, '/run/filters' + token(filter.name)) })),
  { title: 'Of all runs', sections: [restSection(() => remainingTable(payload.run.summary, '/run'))].filter(Boolean) },
].filter((part) => part.sections.length);
