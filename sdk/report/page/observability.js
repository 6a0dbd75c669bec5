// SPDX-License-Identifier: Apache-2.0
// What the samples show of the state, and what they do not: binnacle observe.

/// A share of a variance, never rounded to all or nothing.
function shareCell(path, share) {
  return numeral(path, share, (value) => (value > 0.9995 && value < 1 ? '> 99.9 %' : value > 0 && value < 0.0005 ? '< 0.1 %' : `${(100 * Math.min(1, Math.max(0, value))).toFixed(1)} %`));
}

const afterCell = (path, s) => numeral(path, s, (value) => (isNumber(value) ? (value === 0 ? 'at once' : duration(value)) : '\u2013'));

function componentRows(path, components) {
  return Object.entries(components).map(([name, entry]) => {
    const at = path + token(name);
    const by = Object.entries(entry.by).filter(([, share]) => share > 0.005 * entry.removed).sort((a, b) => b[1] - a[1]).map(([measurement]) => measurement);
    return row(entry.considered ? `${name} (considered)` : name, numeral(at + '/before', entry.before), numeral(at + '/after', entry.after), unitCell(entry),
      shareCell(at + '/removed', entry.removed), shareCell(at + '/removed_without_process_noise', entry.removed_without_process_noise),
      afterCell(at + '/known_after_s', entry.known_after_s), el('td', {}, by.join(', ')));
  });
}

function partsCell(path, parts) {
  return el('td', {}, parts.map((part, i) => [i ? ', ' : '', `${part.component} `, numeral(`${path}/${i}/displacement`, part.displacement, figure, 'span'), part.unit === '1' ? '' : ` ${part.unit}`]));
}

function weakTable(path, weak) {
  if (!weak.length) return note('Every direction is observed: the samples remove at least half of the variance of each.');
  const rows = weak.map((entry, i) => row(entry.name, shareCell(`${path}/${i}/removed`, entry.removed),
    shareCell(`${path}/${i}/removed_without_process_noise`, entry.removed_without_process_noise), partsCell(`${path}/${i}/parts`, entry.parts)));
  return table(['not seen', 'removed', 'without process noise', '1\u03c3 that is left, together'], rows, { left: [3] });
}

function inconsistentTable(path, window) {
  if (window.not_checked) return note(`Consistency could not be checked: ${window.not_checked}.`);
  if (!window.inconsistent.length) return note(badge('good', 'consistent', 'Linearized along one path, the samples remove what the filter claims.'), ' Linearized along one path, the samples remove what the filter claims.');
  const rows = window.inconsistent.map((entry, i) => row(entry.name, shareCell(`${path}/${i}/claimed`, entry.claimed), shareCell(`${path}/${i}/removed`, entry.removed),
    afterCell(`${path}/${i}/since_s`, entry.since_s), partsCell(`${path}/${i}/parts`, entry.parts)));
  return [note(badge('bad', 'inconsistent', 'P shrinks along directions that are not seen.'), ' P shrinks along directions that the samples, linearized along one path, do not see.'),
    table(['inconsistent', 'claimed', 'seen', 'since', '1\u03c3 that is left, together'], rows, { left: [4] })];
}

function observabilityWindow(path, window) {
  const samples = Object.entries(window.samples).map(([name, n], i) => [i ? ', ' : '', numeral(`${path}/samples${token(name)}`, n, count, 'span'), ` of ${name}`]);
  return el('div', { class: 'block' },
    el('h4', {}, window.window, el('span', { class: 'aside' }, numeral(path + '/from_s', window.from_s, (t) => t.toFixed(3), 'span'), ' s to ', numeral(path + '/to_s', window.to_s, (t) => t.toFixed(3), 'span'), ' s; samples: ', samples)),
    table(['1\u03c3 at the begin', 'before', 'after', 'unit', 'removed', 'without process noise', 'known after', 'by'], componentRows(path + '/components', window.components), { left: [3, 7] }),
    weakTable(path + '/weak', window.weak), inconsistentTable(path + '/inconsistent', window),
    note('Singular values: ', window.singular_values.map((value, i) => [i ? ', ' : '', numeral(`${path}/singular_values/${i}`, value, figure, 'span')])),
    window.notes.map((text) => note(`${text}.`)));
}

function observabilitySection(summary, path) {
  if (!summary.observability || !summary.observability.length) return null;
  return section('Observability', 'What the samples of a window show of the state at its begin: the share of its variance that they remove. Known: half of it. Not seen: directions of which they remove less.',
    summary.observability.map((window, i) => observabilityWindow(`${path}/observability/${i}`, window)));
}
