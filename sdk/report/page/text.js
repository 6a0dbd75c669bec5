// SPDX-License-Identifier: Apache-2.0
// Elements and numbers as people read them. Text from results only ever becomes text nodes, never markup.

function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  fill(node, attributes, children);
  return node;
}

function svg(tag, attributes, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  fill(node, attributes, children);
  return node;
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? '' : value);
  }
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    node.append(child instanceof Node ? child : String(child));
  }
}

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

const withMinus = (text) => text.replace(/^-/, '\u2212');

/// Four digits, without an exponent where that reads better.
function figure(value) {
  if (!isNumber(value)) return '\u2013';
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size >= 1e7 || size < 1e-4) return withMinus(value.toExponential(3).replace('e+', 'e'));
  if (size >= 9999.5) return withMinus(grouped(Math.round(value)));
  return withMinus(value.toPrecision(4));
}

/// Two digits, for what is about one.
const brief = (value) => (isNumber(value) ? (Math.abs(value) >= 100 ? grouped(Math.round(value)) : Number.isInteger(value) ? String(value) : value.toPrecision(2)) : '\u2013');

/// Whole numbers, in groups of three from five digits on.
function grouped(value) {
  const text = String(value);
  return Math.abs(value) < 10000 ? text : text.replace(/\B(?=(\d{3})+(?!\d))/g, '\u202f');
}

const count = (value) => (isNumber(value) ? (Number.isInteger(value) ? grouped(value) : figure(value)) : '\u2013');

/// Both as texts: the error to two digits, the value to as many decimals.
function withError(value, se) {
  if (!isNumber(value) || !isNumber(se) || !(se > 0)) return [figure(value), isNumber(se) ? figure(se) : ''];
  const decimals = 1 - Math.floor(Math.log10(se));
  if (decimals > 6 || Math.abs(value) >= 1e7) return [figure(value), figure(se)];
  const places = Math.max(0, decimals);
  return [withMinus(value.toFixed(places)), se.toFixed(places)];
}

/// A share that is never rounded up to all or down to nothing.
function percent(part, whole) {
  if (!(whole > 0)) return '\u2013';
  const share = (100 * part) / whole;
  if (part === whole) return '100 %';
  if (part === 0) return '0 %';
  const text = share >= 99.95 || share < 0.1 ? share.toPrecision(share >= 99 ? 5 : 2) : share.toFixed(1);
  return text + ' %';
}

function duration(s) {
  if (!isNumber(s)) return '\u2013';
  if (s < 1e-3) return (s * 1e6).toPrecision(3) + ' \u00b5s';
  if (s < 1) return (s * 1e3).toPrecision(3) + ' ms';
  if (s < 120) return s.toPrecision(3) + ' s';
  const minutes = Math.floor(s / 60), rest = Math.round(s - 60 * minutes);
  if (minutes < 60) return `${minutes} min ${rest} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

const bracketed = (unit) => (unit && unit !== '1' ? ` [${unit}]` : '');

/// A JSON pointer's token, as RFC 6901 writes it.
const token = (key) => '/' + String(key).replace(/~/g, '~0').replace(/\//g, '~1');

/// A number as the summary has it: what is shown is rounded, title and data have all of it.
function numeral(path, value, show = figure, tag = 'td') {
  shownPaths.add(path);
  const full = value === null || value === undefined ? '' : String(value);
  return el(tag, { class: 'n', 'data-path': path, 'data-value': full, title: full }, show(value));
}

/// "3.38 ± 0.11", both as the summary has them.
function measured(path, value, errorPath, se) {
  const [text, error] = withError(value, se);
  return el('td', { class: 'n' }, numeral(path, value, () => text, 'span'),
    se === undefined || se === null ? '' : [' \u00b1 ', numeral(errorPath, se, () => error, 'span')]);
}

const shownPaths = new Set();
