// SPDX-License-Identifier: Apache-2.0
// A filter beside what it became smoothed, where a run has both.

const smoothedName = (filter) => `${filter.name}.smoothed`;

const ratioCell = (after, before) => el('td', { class: 'n ratio' }, isNumber(after) && isNumber(before) && before !== 0 ? brief(after / before) : '\u2013');

/// Names that both have, in the order of the first.
const inBoth = (first, second) => Object.keys(first || {}).filter((name) => name in (second || {}));

/// Rms and maximum of each error, and what part of the filter's is left.
function smoothedErrors([path, before], [smoothedPath, after]) {
  const pairs = (name) => ['rms', 'max'].flatMap((key) => {
    const at = token('reference') + token(name) + token(key), values = [before, after].map((figures) => figures.reference[name][key]);
    return [numeral(path + at, values[0]), numeral(smoothedPath + at, values[1]), ratioCell(values[1], values[0])];
  });
  const names = inBoth(before.reference, after.reference);
  return names.length ? table(['error', 'rms', 'smoothed', 'ratio', 'max', 'smoothed', 'ratio', 'unit'],
    names.map((name) => row(name, ...pairs(name), unitCell(before.reference[name]))), { left: [7] }) : null;
}

function smoothedConsistency([path, before], [smoothedPath, after]) {
  const cells = (at, entry) => [numeral(at + '/nees_mean', entry.nees_mean), numeral(at + '/n', entry.n, count), el('td', { class: 'n' }, brief(entry.nees_mean / entry.dof)), el('td', {}, neesBadge(entry.nees_mean / entry.dof))];
  const names = inBoth(before.consistency, after.consistency), part = (name) => token('consistency') + token(name);
  return names.length ? table(['block', 'mean NEES', 'samples', 'NEES / dof', '', 'smoothed', 'samples', 'NEES / dof', ''],
    names.map((name) => row(name, ...cells(path + part(name), before.consistency[name]), ...cells(smoothedPath + part(name), after.consistency[name])))) : null;
}

function smoothedSection(filter) {
  const filters = payload.run.summary.filters || {}, name = smoothedName(filter);
  if (!filters[filter.name] || !filters[name]) return null;
  const both = [filter.name, name].map((one) => ['/run/filters' + token(one), filters[one]]), tables = [smoothedErrors(...both), smoothedConsistency(...both)].filter(Boolean);
  return tables.length ? section('Filter and smoothed', `${filter.name} beside ${name}, relative to the same reference. A ratio below 1: the smoothed error is smaller. NEES / dof: 1 is right.`, ...tables) : null;
}
