/** Days and hours of a place, as sliders have them, and dates, as edits do. A place's clock is that of its zone of 15°. */

/** @typedef {import("./messages.js").LightEdit} LightEdit */
/** @typedef {{year: number, day: number, hour: number}} Moment  day: of the year, from 1; hour: with its fraction, from 0 to 24 */

const HOUR = 3_600_000; // [ms]

/** How much a place's clock is ahead of UTC [h]. @param {number} longitude [°] */
export const zoneOf = (longitude) => Math.round(longitude / 15);

/** @param {Moment} moment @param {number} longitude [°] @returns {string} ISO 8601, with the zone */
export function dateOf({ year, day, hour }, longitude) {
  const zone = zoneOf(longitude);
  const clock = new Date(Date.UTC(year, 0, day) + Math.round(hour * 60) * 60_000).toISOString().slice(0, 19);
  return `${clock}${zone < 0 ? "-" : "+"}${String(Math.abs(zone)).padStart(2, "0")}:00`;
}

/** @param {string} date ISO 8601 @param {number} longitude [°] @returns {Moment} */
export function momentOf(date, longitude) {
  const clock = new Date(Date.parse(date) + zoneOf(longitude) * HOUR);
  const year = clock.getUTCFullYear();
  const hours = (clock.getTime() - Date.UTC(year, 0, 1)) / HOUR;
  return { year, day: Math.floor(hours / 24) + 1, hour: hours % 24 };
}

/** In words. @param {Moment} moment @returns {[string, string]} the day, and the time of day */
export function wordsOf({ year, day, hour }) {
  const words = new Date(Date.UTC(year, 0, day)).toLocaleDateString("en-GB", { day: "numeric", month: "short", timeZone: "UTC" });
  const minutes = Math.round(hour * 60);
  return [words, `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}`];
}

/** @param {LightEdit} edit */
const timeOf = ({ date = null, place = null, north = null }) => ({ date, place, north });

/**
 * What changes with an `edit` of a light, by id: sun and sky are of one time, so all that have a date have the same.
 * @param {string} id of the light @param {LightEdit} edit @param {Readonly<Record<string, LightEdit>>} lights  what differs of all
 * @returns {Record<string, LightEdit>}
 */
export function atOneTime(id, edit, lights) {
  if (!edit.date) return { [id]: edit };
  const dated = Object.entries(lights).filter(([one, other]) => one !== id && other.date);
  const [, known] = dated[0] ?? [];
  if (known && !lights[id]?.date) return { [id]: { ...edit, ...timeOf(known) } };
  return Object.fromEntries([[id, edit], ...dated.map(([one]) => [one, timeOf(edit)])]);
}
