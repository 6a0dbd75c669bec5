// SPDX-License-Identifier: Apache-2.0
// The figures of a run's summary as tables.

function table(heads, rows, options = {}) {
  const align = (i) => (i > 0 && !(options.left || []).includes(i) ? { class: 'n' } : {});
  const body = el('tbody', {}, rows);
  return el('div', { class: 'table' }, options.caption && el('p', { class: 'caption' }, options.caption), el('div', { class: 'scroll' },
    el('table', {},
      el('thead', {}, heads.map((row) => (row instanceof Node ? row : null)), heads.some((head) => head instanceof Node)
        ? null
        : el('tr', {}, heads.map((head, i) => el('th', { scope: 'col', ...align(i) }, head)))),
      body)));
}

const row = (name, ...cells) => el('tr', {}, el('th', { scope: 'row' }, name), ...cells);

const unitCell = (entry) => el('td', { class: 'unit' }, entry.unit && entry.unit !== '1' ? entry.unit : '');

function note(...text) {
  return el('p', { class: 'note' }, ...text);
}

/// Blocks in the order in which they come, each block's norms and outputs as they come.
function errorTable(path, figures, caption) {
  const keys = ['rms', 'p50', 'p95', 'max', 'mean', 'final', 'n'];
  const names = Object.keys(figures);
  if (!names.length) return null;
  let last = null;
  const rows = names.map((name) => {
    const block = name.slice(0, name.lastIndexOf('.'));
    const line = row(name, ...keys.map((key) => numeral(path + token(name) + token(key), figures[name][key], key === 'n' ? count : figure)),
      unitCell(figures[name]));
    if (last !== null && block !== last) line.className = 'group';
    last = block;
    return line;
  });
  return table([caption, 'rms', 'p50', 'p95', 'max', 'mean', 'final', 'samples', 'unit'], rows, { left: [8] });
}

function windowTables(path, windows) {
  const list = Object.entries(windows).map(([name, figures]) =>
    el('details', {}, el('summary', {}, name), errorTable(path + token(name), figures, 'error')));
  return [windowOverview(path, windows), el('div', { class: 'windows' }, list)];
}

/// Windows as rows; per window the last and the rms error of every horizontal or other norm there is.
function windowOverview(path, windows) {
  const all = new Set(Object.values(windows).flatMap((figures) => Object.keys(figures)));
  const preferred = [...all].filter((name) => /\.(horizontal|height|tilt|yaw)$/.test(name));
  const names = (preferred.length ? preferred : [...all]).slice(0, 5);
  if (!names.length) return null;
  const unit = (name) => Object.values(windows).map((figures) => figures[name]).find(Boolean).unit;
  const heads = [
    el('tr', {}, el('th', { scope: 'col', rowspan: 2 }, 'window'), names.map((name) => el('th', { class: 'n span', colspan: 2, scope: 'colgroup' }, name + bracketed(unit(name))))),
    el('tr', {}, names.map(() => [el('th', { class: 'n', scope: 'col' }, 'final'), el('th', { class: 'n', scope: 'col' }, 'rms')])),
  ];
  const rows = Object.entries(windows).map(([window, figures]) =>
    row(window, ...names.flatMap((name) => ['final', 'rms'].map((key) =>
      figures[name] ? numeral(path + token(window) + token(name) + token(key), figures[name][key]) : el('td')))));
  return table(heads, rows);
}

function measurementTable(path, measurements) {
  const names = Object.keys(measurements);
  if (!names.length) return null;
  const keys = ['offered', 'accepted', 'gated', 'late', 'unsupported', 'invalid', 'rejected', 'withheld', 'before_start'];
  const used = keys.filter((key) => key === 'offered' || key === 'accepted' || names.some((name) => measurements[name][key]));
  for (const name of names) for (const key of keys) if (!used.includes(key) && key in measurements[name]) zeros.push(path + token(name) + token(key));
  const rows = names.map((name) => {
    const entry = measurements[name], at = path + token(name);
    const ratio = isNumber(entry.nis_mean) && entry.dof ? entry.nis_mean / entry.dof : null;
    return row(name, ...used.map((key) => numeral(at + token(key), entry[key], count)), numeral(at + '/nis_mean', entry.nis_mean),
      numeral(at + '/dof', entry.dof, count), el('td', { class: 'n' }, ratio === null ? '\u2013' : figure(ratio)));
  });
  return table(['measurement', ...used.map((key) => key.replace('_', ' ')), 'mean NIS', 'rows', 'NIS / rows'], rows);
}

const zeros = [];

function consistencyTable(path, consistency) {
  const rows = Object.entries(consistency).map(([block, entry]) => row(block,
    numeral(path + token(block) + '/nees_mean', entry.nees_mean), numeral(path + token(block) + '/dof', entry.dof, count),
    el('td', { class: 'n' }, figure(entry.nees_mean / entry.dof)), numeral(path + token(block) + '/n', entry.n, count), el('td', {}, neesBadge(entry.nees_mean / entry.dof))));
  return table(['block', 'mean NEES', 'degrees of freedom', 'NEES / dof', 'samples', ''], rows);
}

function acrossTable(path, across) {
  const keys = [['final', 'mean'], ['final', 'p50'], ['final', 'max'], ['rms', 'mean'], ['rms', 'p50'], ['rms', 'max'], ['max', 'mean'], ['max', 'p50'], ['max', 'max']];
  const heads = [
    el('tr', {}, el('th', { rowspan: 2 }, 'error'), el('th', { class: 'n', rowspan: 2 }, 'windows'),
      ['final', 'rms', 'max'].map((name) => el('th', { class: 'n span', colspan: 3 }, name)), el('th', { rowspan: 2 }, 'unit')),
    el('tr', {}, keys.map(([, statistic]) => el('th', { class: 'n' }, statistic))),
  ];
  const rows = Object.entries(across).map(([name, entry]) => row(name, numeral(path + token(name) + '/n', entry.n, count),
    ...keys.map(([of, statistic]) => numeral(path + token(name) + token(of) + token(statistic), entry[of] && entry[of][statistic])), unitCell(entry)));
  return table(heads, rows);
}

/// [ [pointer, value] ] of everything in there that is no object or list.
function leaves(value, path, list = []) {
  if (value !== null && typeof value === 'object') for (const [key, child] of Object.entries(value)) leaves(child, path + token(key), list);
  else list.push([path, value]);
  return list;
}

/// What no other table of the page has shown.
function remainingTable(summary, root) {
  const rest = leaves(summary, root).filter(([path, value]) => typeof value !== 'string' && !shownPaths.has(path));
  if (!rest.length) return null;
  return table(['in the summary', 'value'], rest.map(([path, value]) =>
    row(path.slice(root.length), isNumber(value) ? numeral(path, value, count) : el('td', { class: 'n', 'data-path': path, 'data-value': String(value) }, String(value)))));
}
