// SPDX-License-Identifier: Apache-2.0
// The page: sections in order, their contents, the theme, print.

const fixedIds = ['contents', 'main', 'timebar', 'payload'];

function identifier(text) {
  const plain = text.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/^-|-$/g, '') || 'section';
  let id = plain;
  for (let i = 2; identifier.used.has(id); ++i) id = `${plain}-${i}`;
  identifier.used.add(id);
  return id;
}

/// { element, title, id }; nothing where it would be empty.
function section(title, explanation, ...content) {
  const id = identifier(title);
  return { title, id, element: el('section', { id }, el('h3', {}, title), explanation && note(explanation), content) };
}

// ---- verdicts

function badge(kind, text, why) {
  return el('span', { class: 'badge ' + kind, title: why }, text);
}

/// Of a mean that should be about its degrees of freedom.
function bandBadge(mean, low, high) {
  if (!isNumber(mean) || !isNumber(low) || !isNumber(high)) return null;
  if (mean > high) return badge('bad', 'overconfident', 'Above what 99 % of such means lie in: errors are larger than the filter thinks.');
  if (mean < low) return badge('low', 'conservative', 'Below what 99 % of such means lie in: errors are smaller than the filter thinks.');
  return badge('good', 'consistent', 'Within what 99 % of such means lie in.');
}

/// Neighbouring NEES are not independent, so that no band fits their mean: only what is far off is reported.
function neesBadge(ratio) {
  if (!isNumber(ratio)) return null;
  if (ratio > 1.5) return badge('bad', 'overconfident', 'True errors are larger than the filter says.');
  if (ratio < 0.67) return badge('low', 'conservative', 'True errors are smaller than the filter says.');
  return badge('good', 'consistent', 'True errors are about as large as the filter says.');
}

function withinText(within) {
  if (!within || !within.of) return '';
  return `${percent(within.three, within.of)} within \u00b13\u03c3`;
}

/// Of the samples that are drawn of a run that goes on, no share is known.
const insideText = (nis) => (isNumber(nis.inside) ? `; ${percent(nis.inside, nis.accepted)} within 95 % bounds` : '');

// ---- a filter

function tiles(filter, summary, path) {
  const list = [];
  const add = (label, value, ...more) => list.push(el('div', { class: 'tile' }, el('span', { class: 'label' }, label), el('span', { class: 'value' }, value), el('span', { class: 'more' }, ...more)));
  if (isNumber(summary.start_s) && isNumber(summary.end_s))
    add('Filter time', duration(summary.end_s - summary.start_s), numeral(path + '/start_s', summary.start_s, (t) => t.toFixed(3), 'span'), ' s to ', numeral(path + '/end_s', summary.end_s, (t) => t.toFixed(3), 'span'), ' s');
  else add('Filter time', 'never started');
  if (isNumber(summary.steps))
    add('Steps', numeral(path + '/steps', summary.steps, count, 'span'), summary.steps > 0 ? `${duration(summary.filter_s / summary.steps)} each, ` : '', numeral(path + '/filter_s', summary.filter_s, duration, 'span'), ' in all');
  const errors = summary.reference || {};
  for (const name of headlines(errors)) {
    const entry = errors[name];
    add(name, [figure(entry.rms), el('span', { class: 'unit' }, ` ${entry.unit || ''} rms`)], `95 % below ${figure(entry.p95)}, max ${figure(entry.max)}`);
  }
  for (const measurement of filter.measurements) {
    const mean = measurement.nis && measurement.nis.mean;
    if (mean) add(`NIS / rows of ${measurement.name}`, [brief(mean.value / mean.dof), ' ', bandBadge(mean.value, mean.low, mean.high)], `1 is right${insideText(measurement.nis)}`);
  }
  for (const [block, entry] of Object.entries(summary.consistency || {}))
    add(`NEES / dof of ${block}`, [brief(entry.nees_mean / entry.dof), ' ', neesBadge(entry.nees_mean / entry.dof)], '1 is right');
  if (summary.broken) add('Filter', 'broken', typeof summary.broken === 'string' ? summary.broken : '');
  return el('div', { class: 'tiles' }, list);
}

function headlines(errors) {
  const names = Object.keys(errors);
  const preferred = names.filter((name) => /\.(horizontal|distance|tilt|yaw)$/.test(name));
  return (preferred.length ? preferred : names).slice(0, 4);
}

function summarySection(filter, summary, path) {
  const part = section('Summary', null, tiles(filter, summary, path));
  const add = (...nodes) => part.element.append(...nodes.flat().filter(Boolean));
  if (summary.reference && Object.keys(summary.reference).length) {
    add(el('h4', {}, 'Errors'), note('Truth minus estimate at the times of the reference; of a norm, its length. p50, p95 and max are of magnitudes. Hover a figure for all of its digits.'), errorTable(path + '/reference', summary.reference, 'error'));
  }
  if (summary.withheld)
    for (const [measurement, figures] of Object.entries(summary.withheld)) add(errorTable(`${path}/withheld${token(measurement)}`, figures, `withheld ${measurement}`));
  if (summary.windows) add(el('h4', {}, 'Windows'), note('Scored by themselves; shaded in the plots. final is the error at a window\u2019s end.'), windowTables(path + '/windows', summary.windows));
  if (summary.measurements && Object.keys(summary.measurements).length)
    add(el('h4', {}, 'Measurements'), note('What became of every sample offered. NIS / rows is 1 on average if the filter\u2019s uncertainty is right; above, it trusts too much; below, too little.'), measurementTable(path + '/measurements', summary.measurements));
  if (summary.consistency && Object.keys(summary.consistency).length)
    add(el('h4', {}, 'Consistency'), note('NEES weighs the errors against the filter\u2019s own covariance: 1 per degree of freedom is right, more means that the true errors are larger than the filter says.'), consistencyTable(path + '/consistency', summary.consistency));
  if (summary.noise) add(el('h4', {}, 'Adapted noise'), errorTable(path + '/noise', summary.noise, '\u221aR'));
  return part;
}

function timePlot(filter, spec) {
  const name = `${filter.name} ${spec.name}`;
  return drawing(TimePlot, name, { span: filter.span, windows: filter.windows, ...spec, name });
}

function sampleNote(entry) {
  const shown = column(entry.t) ? column(entry.t).length : 0;
  if (payload.live) return `${grouped(shown)} of the estimates since the first look are drawn`;
  return shown < entry.n ? `${grouped(entry.n)} samples, of which the least and greatest of each stretch are drawn` : `${grouped(entry.n)} samples`;
}

/// The errors that stand beside the estimates: of the same names if each has one, else as many as there are; then the others.
function besideEstimates(block) {
  const of = (name) => block.errors.find((error) => error.name === name);
  const named = block.estimates.map((estimate) => of(estimate.name));
  const beside = named.every(Boolean) ? named : block.errors.slice(0, block.estimates.length);
  return [beside, block.errors.filter((error) => !beside.includes(error))];
}

const smoothedFilter = (filter) => payload.run.filters.find((other) => other.name === smoothedName(filter));

/// The same error or estimate of what the filter became smoothed, to be drawn over it.
function smoothed(filter, block, list, entry) {
  const other = smoothedFilter(filter), same = other && other.blocks.find(({ name }) => name === block.name);
  const found = same && !entry.turn && same[list].find(({ name, unit }) => name === entry.name && unit === entry.unit);
  return found && { t: found.t, v: found.v };
}

function errorPlot(filter, block, entry) {
  const isLength = !!entry.length;
  return timePlot(filter, {
    title: entry.name, unit: entry.unit, name: `${block.name}.${entry.name} error`, t: entry.t, v: entry.v, s: entry.s, n: entry.n, isLength, within: entry.within,
    colour: colourOf(entry.name, block.errors.indexOf(entry)), stat: withinText(entry.within) || 'error', centre: 'zero',
    moving: smoothed(filter, block, 'errors', entry),
  });
}

function estimatePlot(filter, block, entry, i) {
  return timePlot(filter, {
    title: entry.name, unit: entry.unit, name: `${block.name}.${entry.name}`, t: entry.t, v: entry.v, s: entry.s, n: entry.n, turn: entry.turn,
    colour: colourOf(entry.name, i), stat: entry.s ? 'estimate \u00b13\u03c3' : 'estimate', centre: 'value',
    moving: smoothed(filter, block, 'estimates', entry),
  });
}

function statesSection(filter) {
  if (!filter.blocks.length) return null;
  const part = section('States', 'Errors with the filter\u2019s \u00b13\u03c3 about zero, where there is a reference: of a good filter 99.7 % lie inside, and the band is not much wider than they are. Estimates within their \u00b13\u03c3.' + (filter.windows.length ? ' Shaded: windows that are scored by themselves, and what was withheld.' : '') + (smoothedFilter(filter) ? ` The dark line is ${filter.name}.smoothed.` : ''));
  for (const block of filter.blocks) {
    const [beside, others] = besideEstimates(block);
    const errors = beside.map((entry) => errorPlot(filter, block, entry));
    const estimates = block.estimates.map((entry, i) => estimatePlot(filter, block, entry, i));
    part.element.append(el('div', { class: 'block' }, el('h4', {}, block.name, el('span', { class: 'aside' }, sampleNote(block.errors[0] || block.estimates[0]))),
      errors.length ? el('div', { class: 'pair' }, el('div', {}, el('h5', {}, 'error'), errors), el('div', {}, el('h5', {}, 'estimate'), estimates))
        : el('div', { class: 'grid' }, estimates),
      others.length ? [el('h5', {}, 'further errors'), el('div', { class: 'grid' }, others.map((entry) => errorPlot(filter, block, entry)))] : null));
  }
  return part;
}

function consistencySection(filter) {
  if (!filter.nees.length) return null;
  return section('NEES', 'Errors weighed by the filter\u2019s own covariance, over time; dashed: 95 % of them should lie between. Neighbouring values are not independent.',
    el('div', { class: 'grid' }, filter.nees.map((entry) => timePlot(filter, {
      title: entry.name, unit: `of ${entry.dof} degrees of freedom`, name: `${entry.name}.nees`, t: entry.t, v: entry.v, n: entry.n, colour: '--c3', isSquare: true, low: entry.low, high: entry.high, least: 0,
      lines: entry.dof > 0 ? [{ value: entry.low }, { value: entry.high }] : [], stat: entry.dof > 0 ? `${percent(entry.inside, entry.n)} within` : '',
    }))));
}

function measurementsSection(filter) {
  const used = filter.measurements.filter((measurement) => measurement.n > 0);
  if (!used.length) return null;
  const counts = outcomeNames.map((name, code) => used.reduce((sum, measurement) => sum + measurement.outcomes.counts[code], 0));
  const part = section('Measurements', 'What became of each sample, by time. Below, the NIS of each: dots are samples, ' + (payload.live ? '' : 'the line their mean over many, ') + 'dashed are the bounds that 95 % of \u03c7\u00b2 lie between. In a good filter the mean is the number of rows, and the residuals fill their \u00b13\u221aS without leaving it.', drawing(OutcomeLanes, `${filter.name} outcomes`, filter),
    el('div', { class: 'legend' }, outcomeNames.map((name, code) => counts[code] > 0 && el('span', { class: 'key' }, el('i', { style: `background: var(--o${code})` }), `${name} ${grouped(counts[code])}`))));
  for (const measurement of used) part.element.append(measurementBlock(filter, measurement));
  return part;
}

function measurementBlock(filter, measurement) {
  const block = el('div', { class: 'block' }, el('h4', {}, measurement.name, el('span', { class: 'aside' }, `${grouped(measurement.n)} samples offered`)));
  if (measurement.reasons.length)
    block.append(el('details', {}, el('summary', {}, 'Why samples were not used'), table(['reason', 'outcome', 'samples'], measurement.reasons.map((entry) =>
      row(entry.reason, el('td', {}, outcomeNames[entry.outcome]), el('td', { class: 'n' }, count(entry.count)))), { left: [1] })));
  if (measurement.nis) block.append(nisPlot(filter, measurement));
  if (measurement.residuals.length) block.append(el('h5', {}, 'residuals within \u00b13\u221aS'), el('div', { class: 'grid' }, measurement.residuals.map((entry, i) => residualPlot(filter, measurement, entry, i))));
  block.append(noisePart(filter, measurement) || '');
  return block;
}

function nisPlot(filter, measurement) {
  const nis = measurement.nis;
  return timePlot(filter, {
    title: 'NIS', unit: nis.dof ? `of ${nis.dof} rows` : `of ${brief(nis.mean ? nis.mean.dof : null)} rows on average`, name: `${measurement.name}.nis`, t: nis.t, v: nis.v, o: nis.o, n: nis.n, colour: '--c0', isSquare: true, least: 0,
    low: nis.low, high: nis.high, lows: nis.lows, highs: nis.highs, moving: nis.moving, lines: nis.dof ? [{ value: nis.low }, { value: nis.high }] : [],
    stat: nis.mean ? `mean ${brief(nis.mean.value)}${insideText(nis)}` : '',
  });
}

function residualPlot(filter, measurement, entry, i) {
  return timePlot(filter, {
    title: entry.of ? `${entry.name}, all ${entry.of}` : entry.name, unit: entry.unit, name: `${measurement.name}.${entry.name} residual`, t: entry.t, v: entry.v, s: entry.s, o: entry.o, n: entry.n,
    colour: colourOf(entry.name, i % 3), centre: 'zero', within: entry.within, lines: entry.bound ? [{ value: entry.bound, isInRange: true }, { value: -entry.bound, isInRange: true }] : [], stat: withinText(entry.within),
  });
}

function noisePart(filter, measurement) {
  const moving = measurement.noise.filter((entry) => entry.t !== undefined), constant = measurement.noise.filter((entry) => entry.t === undefined);
  if (!moving.length && !constant.length) return null;
  return el('div', {}, el('h5', {}, 'noise used, \u221aR'),
    el('div', { class: 'grid' }, moving.map((entry, i) => timePlot(filter, { title: entry.name, unit: entry.unit, name: `${measurement.name}.${entry.name} noise`, t: entry.t, v: entry.v, n: entry.n, colour: colourOf(entry.name, i % 3), least: 0, stat: 'as the update used it' }))),
    constant.length ? note('Constant: ', constant.map((entry) => `${entry.name} ${figure(entry.constant)} ${entry.unit}`).join(', ') + '.') : null);
}

function adaptedSection(filter) {
  if (!filter.noise.length) return null;
  return section('Adapted noise', 'What a noise estimator made of the residuals: \u221aR of each group of rows.', el('div', { class: 'grid' }, filter.noise.map((entry, i) =>
    timePlot(filter, { title: entry.name, unit: entry.unit, name: `${entry.name}.noise`, t: entry.t, v: entry.v, n: entry.n, colour: `--c${i % 6}`, least: 0 }))));
}

function trackSection(filter) {
  if (!filter.track) return null;
  const map = drawing(TrackMap, `${filter.name} track`, filter);
  // Its size is known once it is on the page.
  requestAnimationFrame(() => map.dispatchEvent(new Event('fit')));
  return section('Track', 'Metres east and north of the start; both axes have one scale. A time window chosen in any plot is drawn in bold, and the dot follows the cursor.', map);
}

function filterSections(filter, summary, path) {
  // Never started, or with one sample only: nothing is drawn over time.
  if (!filter.span || !(filter.span[1] > filter.span[0])) return [summarySection(filter, summary, path), smoothedSection(filter)].filter(Boolean);
  return [summarySection(filter, summary, path), smoothedSection(filter), trackSection(filter), observabilitySection(summary, path), statesSection(filter), consistencySection(filter), measurementsSection(filter), adaptedSection(filter)].filter(Boolean);
}

// ---- the whole

/// Whether each filter's estimates can be trusted, and why not.
function verdicts() {
  const filters = Object.entries((payload.run && payload.run.summary.filters) || {}).filter(([, filter]) => filter.verdict);
  return filters.length ? el('dl', { class: 'verdicts' }, filters.flatMap(([name, { verdict }]) => [el('dt', { class: verdict.state }, `${name}: ${verdict.state}`),
    ...[...verdict.reasons, ...(verdict.likely_causes || []), ...(verdict.notes || [])].map((reason) => el('dd', {}, `${reason.code} ${reason.text}`))])) : null;
}

function header(kind, provenance) {
  const facts = [];
  if (provenance.created) facts.push(String(provenance.created).replace('T', ' ').replace(/\.\d+/, '').replace('Z', ' UTC'));
  if (provenance.version) facts.push(`Binnacle ${provenance.version}`);
  if (provenance.seed !== undefined && provenance.seed !== null) facts.push(`seed ${provenance.seed}` + (provenance.run !== undefined && String(provenance.run) !== '0' ? `, run ${provenance.run}` : ''));
  return el('header', {}, el('div', { class: 'kind' }, kind + ' ', payload.live && el('span', { class: 'badge ' + liveStates[payload.live][0] }, liveStates[payload.live][1])), el('h1', {}, payload.title || kind), payload.description && el('p', { class: 'lead' }, payload.description),
    el('p', { class: 'facts' }, facts.map((fact) => el('span', {}, fact))), provenance.command && el('pre', { class: 'command' }, provenance.command), verdicts());
}

function originSection(config, provenance) {
  const plugins = Array.isArray(provenance.plugins) && provenance.plugins.length
    ? el('details', {}, el('summary', {}, `${provenance.plugins.length} plugins`), table(['plugin', 'version', 'file'], provenance.plugins.map((plugin) => row(plugin.name, el('td', {}, plugin.version || ''), el('td', { class: 'path' }, plugin.path || ''))), { left: [1, 2] })) : null;
  return section('Origin', 'With these plugins and this config, as run, the command above gives these figures again.', plugins,
    el('details', {}, el('summary', {}, 'Config as run'), el('pre', {}, JSON.stringify(config, null, 2))));
}

function warningSection(warnings) {
  if (!Array.isArray(warnings) || !warnings.length) return null;
  return section('Warnings', 'What was odd about the data.', el('ul', { class: 'warnings' }, warnings.map((warning) => el('li', {}, typeof warning === 'string' ? warning : warning.text || warning.message || JSON.stringify(warning)))));
}

/// { title, sections } in the order of the page; a run has one for each filter.
function parts() {
  const list = [];
  const { run, study } = payload;
  if (run) {
    const many = run.filters.length > 1;
    if (many && run.summary.windows) list.push({ title: 'All filters', sections: [section('Windows of all filters', 'Statistics over the windows of all filters.', acrossTable('/run/windows', run.summary.windows))] });
    for (const filter of run.filters)
      list.push({ title: `Filter ${filter.name}`, sections: filterSections(filter, (run.summary.filters || {})[filter.name] || {}, '/run/filters' + token(filter.name)) });
    const rest = () => remainingTable(run.summary, '/run');
    list.push({ title: study ? 'Of the run' : 'About', sections: [warningSection(run.summary.warnings), originSection(run.config, run.provenance || {}), restSection(rest)].filter(Boolean) });
  }
  if (study) {
    list.push({ title: 'Study', sections: studySections(study) });
    list.push({ title: run ? 'Of the study' : 'About', sections: [originSection(study.config, study.provenance || {}), restSection(() => remainingTable(study.figures, '/study'))].filter(Boolean) });
  }
  return list;
}

function restSection(make) {
  const rest = make();
  return rest && section('Other figures', 'What else the summary holds.', el('details', {}, el('summary', {}, 'Show'), rest));
}

function contents(list) {
  const links = list.map((part) => el('li', {}, el('a', { href: '#' + part.id }, part.title), el('ol', {}, part.sections.map((entry) => el('li', {}, el('a', { href: '#' + entry.id }, entry.title))))));
  const details = el('details', { open: innerWidth >= 1100 }, el('summary', {}, 'Contents'), el('ol', {}, links));
  details.addEventListener('click', (event) => { if (event.target.tagName === 'A' && innerWidth < 1100) details.open = false; });
  return details;
}

// ---- theme

const themes = ['auto', 'light', 'dark'];

function themeSwitch() {
  const button = el('button', { type: 'button', class: 'theme', onclick: () => setTheme(themes[(themes.indexOf(theme()) + 1) % themes.length], true) });
  const theme = () => document.documentElement.dataset.theme || 'auto';
  const setTheme = (name, isChosen) => {
    if (name === 'auto') delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = name;
    button.textContent = { auto: '\u25d0 auto', light: '\u25cb light', dark: '\u25cf dark' }[name];
    button.setAttribute('aria-label', `Theme: ${name}`);
    if (!isChosen) return;
    try { localStorage.setItem('binnacle-theme', name); } catch { /* a page opened from a file may not */ }
    redraw();
  };
  let kept = null;
  try { kept = localStorage.getItem('binnacle-theme'); } catch { /* as above */ }
  setTheme(themes.includes(kept) ? kept : 'auto', false);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  return button;
}

/// Canvases have their colours drawn in.
function redraw() {
  for (const item of view.items) {
    if (item.graph) {
      item.graph.destroy();
      item.graph = null;
    }
    item.isStale = true;
    if (item.isVisible) refresh(item);
  }
  for (const listener of view.listeners) listener(view.window);
}

/// On paper: light, every plot drawn as wide as the paper has it, and as a picture, since a canvas is printed stroke by
/// stroke, which takes long and loses what lies under another canvas.
function print(isBegin) {
  document.documentElement.classList.toggle('printing', isBegin);
  for (const picture of document.querySelectorAll('img.drawn')) picture.remove();
  if (isBegin) {
    for (const details of document.querySelectorAll('main details')) if (!details.querySelector('pre')) details.open = true;
    for (const item of view.items) item.isVisible = true;
  }
  redraw();
  if (!isBegin) {
    dispatchEvent(new Event('resize'));
    return;
  }
  for (const map of document.querySelectorAll('.track')) map.dispatchEvent(new Event('fit'));
  for (const item of view.items) {
    const canvas = item.graph ? item.graph.hidden_ : item.canvas;
    if (!canvas) continue;
    canvas.parentElement.append(el('img', { class: 'drawn', alt: '', src: canvas.toDataURL(), style: `width: ${canvas.clientWidth}px; height: ${canvas.clientHeight}px` }));
  }
}

// ---- as often as the payload changes

const timeBar = { made: null };

function render() {
  identifier.used = new Set(fixedIds);
  shownPaths.clear();
  zeros.length = 0;
  drawnNow.clear();
  const provenance = (payload.run || payload.study || {}).provenance || {};
  const list = parts();
  const main = el('main', { id: 'main' }, header(payload.run && payload.study ? 'Run and study' : payload.study ? 'Study' : 'Run', provenance));
  for (const part of list) {
    part.id = identifier(part.title);
    main.append(el('h2', { id: part.id }, part.title), ...part.sections.map((entry) => entry.element));
  }
  main.append(el('footer', {}, payload.live ? 'Served by binnacle run while it goes on; all that it fetches are the run\u2019s data.' : 'Made by binnacle report. This page is complete in itself: it fetches nothing.'));
  become(document.getElementById('main'), main);
  const nav = document.querySelector('#contents > details');
  if (nav) become(nav, contents(list));
  else document.getElementById('contents').append(contents(list));
  const timed = payload.run ? payload.run.filters.filter((filter) => filter.span && filter.span[1] > filter.span[0]) : [];
  if (timed.length && timeBar.made) timeBar.made.take(timed);
  else if (timed.length) timeBar.made = new TimeBar(document.getElementById('timebar'), timed);
  putDrawings();
}

function start() {
  setPayload(document.getElementById('payload').textContent);
  document.getElementById('contents').append(el('div', { class: 'brand' }, el('a', { href: '#main' }, 'Binnacle'), themeSwitch()));
  render();
  addEventListener('beforeprint', () => print(true));
  addEventListener('afterprint', () => print(false));
  document.documentElement.dataset.ready = 'yes';
  if (payload.live) follow();
}

