/**
 * JSON Merge Patch (RFC 7396), and what takes one back. Patches here name values, never whole objects: so two are one, and
 * each has an inverse.
 */

/** @typedef {{readonly [name: string]: unknown}} Json */

/** @param {unknown} value @returns {value is Json} */
const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** @param {unknown} value @returns {Json} */
const asObject = (value) => (isObject(value) ? value : {});

/** `target` after `patch`. @param {unknown} target @param {unknown} patch @returns {unknown} */
export function merge(target, patch) {
  if (!isObject(patch)) return patch;
  const made = { ...asObject(target) };
  for (const [name, value] of Object.entries(patch)) {
    if (value === null) delete made[name];
    else made[name] = merge(made[name], value);
  }
  return made;
}

/** One patch that does what `first`, then `second` do. @param {unknown} first @param {unknown} second @returns {unknown} */
export function compose(first, second) {
  if (!isObject(first) || !isObject(second)) return second;
  const made = { ...first };
  for (const [name, value] of Object.entries(second)) made[name] = name in made ? compose(made[name], value) : value;
  return made;
}

/** The patch that brings back what `target` has and `patch` changes. @param {unknown} target @param {unknown} patch @returns {unknown} */
export function inverse(target, patch) {
  if (!isObject(patch)) return target ?? null;
  return Object.fromEntries(Object.entries(patch).map(([name, value]) => [name, inverse(asObject(target)[name], value)]));
}

/** `patch` with the values of `other`, where that has some. @param {unknown} patch @param {unknown} other @returns {unknown} */
export function replaced(patch, other) {
  if (!isObject(patch) || !isObject(other)) return other;
  return Object.fromEntries(Object.entries(patch).map(([name, value]) => [name, name in other ? replaced(value, other[name]) : value]));
}

/** `patch` without what `other` changes. @param {unknown} patch @param {unknown} other @returns {unknown} */
export function without(patch, other) {
  const others = asObject(other);
  const left = Object.entries(asObject(patch)).filter(([name, value]) => isObject(value) || !(name in others));
  return Object.fromEntries(left.map(([name, value]) => [name, isObject(value) ? without(value, others[name]) : value]));
}

/** The patch that makes `to` of `from`. @param {unknown} from @param {unknown} to @returns {unknown} */
export function difference(from, to) {
  if (!isObject(from) && !isObject(to)) return to ?? null;
  const [before, after] = [asObject(from), asObject(to)];
  const differ = Object.keys({ ...before, ...after }).filter((name) => !same(before[name], after[name]));
  return Object.fromEntries(differ.map((name) => [name, difference(before[name], after[name])]));
}

/** Whether two say the same: what says nothing is like what is not there. @param {unknown} one @param {unknown} other @returns {boolean} */
function same(one, other) {
  if (!isObject(one) && !isObject(other)) return JSON.stringify(one ?? null) === JSON.stringify(other ?? null);
  const [a, b] = [asObject(one), asObject(other)];
  return Object.keys({ ...a, ...b }).every((name) => same(a[name], b[name]));
}

/** The patch that takes all values of `target` away. @param {unknown} target @returns {unknown} */
export function removal(target) {
  if (!isObject(target)) return null;
  return Object.fromEntries(Object.entries(target).map(([name, value]) => [name, removal(value)]));
}
