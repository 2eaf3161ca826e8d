import assert from "node:assert/strict";
import { test } from "node:test";

import { atOneTime, dateOf, momentOf, wordsOf, zoneOf } from "../../../web/sun.js";

test("a day and hour are a date in the place's zone, and back", () => {
  const moment = { year: 2026, day: 172, hour: 18.25 };
  assert.equal(dateOf(moment, 11.6), "2026-06-21T18:15:00+01:00");
  assert.equal(dateOf(moment, -74), "2026-06-21T18:15:00-05:00");
  for (const longitude of [0, 11.6, -74, 180]) assert.deepEqual(momentOf(dateOf(moment, longitude), longitude), moment);
  assert.deepEqual(momentOf("2026-01-01T00:30:00Z", -74), { year: 2025, day: 365, hour: 19.5 });
  assert.equal(zoneOf(-7), -0);
});

test("they are said in words", () => {
  assert.deepEqual(wordsOf({ year: 2026, day: 172, hour: 6.25 }), ["21 Jun", "6:15"]);
});

test("what has a date has the same as all others", () => {
  const noon = { date: "2026-06-21T12:00:00+01:00", place: /** @type {[number, number]} */ ([48, 11]), north: 0 };
  const evening = { ...noon, date: "2026-06-21T18:00:00+01:00", direction: null };
  const { direction: _, ...time } = evening;
  assert.deepEqual(atOneTime("sun", evening, {}), { sun: evening });
  assert.deepEqual(atOneTime("sun", evening, { sun: noon, sky: noon, lamp: { on: true } }), { sun: evening, sky: time });
  assert.deepEqual(atOneTime("sun", evening, { sky: noon }), { sun: { ...evening, ...noon } });
  assert.deepEqual(atOneTime("sun", { date: null }, { sun: noon, sky: noon }), { sun: { date: null } });
});
