// SPDX-License-Identifier: Apache-2.0
// The payload: columns of numbers, and those of them that a plot of some width needs.

let payload = null;

const decoded = new Map();

function setPayload(text) {
  payload = JSON.parse(text);
  decoded.clear();
}

function bytesOf(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/// A column by its number, unpacked when it is first asked for.
function column(index) {
  if (index === undefined || index === null) return null;
  if (!decoded.has(index)) decoded.set(index, unpacked(payload.columns[index]));
  return decoded.get(index);
}

function unpacked(entry) {
  if (entry.u1 !== undefined) return bytesOf(entry.u1);
  if (entry.f8 !== undefined) return new Float64Array(bytesOf(entry.f8).buffer);
  const packed = new Float32Array(bytesOf(entry.f4).buffer);
  const values = new Float64Array(packed.length);
  const offset = entry.o || 0;
  for (let i = 0; i < packed.length; ++i) values[i] = packed[i] + offset;
  return values;
}

/// First index with t[i] >= time.
function lowerBound(t, time) {
  let low = 0, high = t.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (t[middle] < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/// Indices between from and to, and one beyond on either side; of very many, where each column is least and greatest in
/// every one of `stretches`, and the first of each kind.
function indicesWithin(t, from, to, columns, kinds, stretches) {
  const begin = Math.max(0, lowerBound(t, from) - 1);
  const end = Math.min(t.length, lowerBound(t, to) + 2);
  const n = end - begin;
  const indices = [];
  if (n <= stretches * 4) {
    for (let i = begin; i < end; ++i) indices.push(i);
    return indices;
  }
  for (let s = 0; s < stretches; ++s) {
    const first = begin + Math.floor((n * s) / stretches), last = begin + Math.floor((n * (s + 1)) / stretches);
    const kept = new Set();
    for (const values of columns) {
      let least = first, greatest = first;
      for (let i = first; i < last; ++i) {
        if (values[i] < values[least]) least = i;
        if (values[i] > values[greatest]) greatest = i;
      }
      kept.add(least).add(greatest);
    }
    if (kinds) {
      const seen = new Set();
      for (let i = first; i < last; ++i)
        if (!seen.has(kinds[i])) {
          seen.add(kinds[i]);
          kept.add(i);
        }
    }
    indices.push(...[...kept].sort((a, b) => a - b));
  }
  return indices;
}

const outcomeNames = ['accepted', 'gated', 'late', 'unsupported', 'invalid', 'withheld', 'rejected'];
