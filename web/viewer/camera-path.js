/**
 * A camera's way through views, as films are rendered: the same spline as gpu/scene/camera_path.py, which says what it
 * is and why. A view's place may be in the coordinates of any file, its yaw and pitch are those of the world.
 */

/** @typedef {import("../link.js").View} View */
/** @typedef {{time: number, view: View}} Keyframe  time [s], increasing */

export class CameraPath {
  #times;
  #values;
  #slopes;

  /** @param {readonly Keyframe[]} keyframes two or more */
  constructor(keyframes) {
    const views = keyframes.map(({ view }) => view);
    const times = keyframes.map(({ time }) => time);
    const places = views.map(({ at }) => [...at]);
    const numbers = [
      unwrapped(views.map(({ look }) => look[0])),
      views.map(({ look }) => look[1]),
      views.map(({ yfov }) => Math.log(Math.tan(yfov / 2))),
      views.map(({ near }) => near ?? 0),
    ];
    this.#times = times;
    this.#values = places.map((place, index) => [...place, ...numbers.map((values) => values[index] ?? 0)]);
    const rates = numbers.map((values) => monotoneSlopes(times, values));
    this.#slopes = velocities(times, places).map((speed, index) => [...speed, ...rates.map((slopes) => slopes[index] ?? 0)]);
  }

  /** When it begins and ends [s]. */
  get start() {
    return this.#times[0] ?? 0;
  }

  get end() {
    return this.#times.at(-1) ?? 0;
  }

  /** The view at a time [s]; before the first keyframe and after the last, those. @param {number} time @returns {View} */
  at(time) {
    const values = hermite(this.#times, this.#values, this.#slopes, time);
    const [x = 0, y = 0, z = 0, yaw = 0, pitch = 0, zoom = 0, near = 0] = values;
    return { at: [x, y, z], look: [yaw, pitch], yfov: 2 * Math.atan(Math.exp(zoom)), ...(near > 0 && { near }) };
  }
}

/** @param {readonly number[]} values */
const steps = (values) => values.slice(1).map((value, index) => value - (values[index] ?? 0));

/** Derivatives of values by time (Fritsch and Butland 1984). @param {readonly number[]} times @param {readonly number[]} values */
function monotoneSlopes(times, values) {
  const lengths = steps(times);
  const secants = steps(values).map((step, index) => step / (lengths[index] ?? 1));
  const inner = secants.slice(1).map((after, index) => {
    const before = secants[index] ?? 0;
    const [one = 1, two = 1] = lengths.slice(index, index + 2);
    const weights = /** @type {const} */ ([2 * two + one, two + 2 * one]);
    return before * after <= 0 ? 0 : (weights[0] + weights[1]) / (weights[0] / before + weights[1] / after);
  });
  return [secants[0] ?? 0, ...inner, secants.at(-1) ?? 0];
}

/**
 * Derivatives of places by time, along a centripetal Catmull-Rom curve.
 * @param {readonly number[]} times @param {readonly number[][]} places
 */
function velocities(times, places) {
  const moves = places.slice(1).map((place, index) => place.map((value, axis) => value - (places[index]?.[axis] ?? 0)));
  const lengths = moves.map((move) => Math.sqrt(Math.hypot(...move)));
  const along = lengths.reduce((sums, length) => [...sums, (sums.at(-1) ?? 0) + length], [0]);
  const rates = monotoneSlopes(times, along);
  const inner = moves.slice(1).map((after, index) => {
    const before = moves[index] ?? after;
    const rate = rates[index + 1] ?? 0;
    const [one = 1, two = 1] = lengths.slice(index, index + 2);
    if (rate === 0) return after.map(() => 0);
    return after.map((step, axis) => (rate * ((two / one) * (before[axis] ?? 0) + (one / two) * step)) / (one + two));
  });
  const durations = steps(times);
  const straight = (/** @type {number} */ index) => (moves.at(index) ?? []).map((step) => step / (durations.at(index) ?? 1));
  return [straight(0), ...inner, straight(-1)];
}

/**
 * The cubic of the two knots around a place, with their values and derivatives.
 * @param {readonly number[]} knots @param {readonly number[][]} values @param {readonly number[][]} slopes @param {number} at
 */
function hermite(knots, values, slopes, at) {
  const next = knots.findIndex((knot) => knot > at);
  const left = Math.max((next < 0 ? knots.length - 1 : next) - 1, 0);
  const [begin = 0, end = 1] = knots.slice(left, left + 2);
  const share = Math.min(Math.max((at - begin) / (end - begin), 0), 1);
  const rest = 1 - share;
  return (values[left] ?? []).map((value, index) => {
    const [after = 0, speed = 0, speedAfter = 0] = [values[left + 1]?.[index], slopes[left]?.[index], slopes[left + 1]?.[index]];
    const ends = value * rest ** 2 * (1 + 2 * share) + after * share ** 2 * (1 + 2 * rest);
    return ends + (end - begin) * share * rest * (speed * rest - speedAfter * share);
  });
}

/** Angles as a way of less than half a turn from each to the next. @param {readonly number[]} angles */
function unwrapped(angles) {
  const turn = 2 * Math.PI;
  /** @type {number[]} */
  const way = [];
  for (const angle of angles) {
    const step = angle - (way.at(-1) ?? angle);
    way.push((way.at(-1) ?? angle) + step - turn * Math.ceil(step / turn - 0.5));
  }
  return way;
}
