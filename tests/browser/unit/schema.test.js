import assert from "node:assert/strict";
import { test } from "node:test";

import { accepted, fieldsOf } from "../../../web/ui/schema.js";

const schema = {
  $defs: { Method: { enum: ["fuzzy-vpl", "path"], type: "string", description: "How light is computed." } },
  properties: {
    method: { $ref: "#/$defs/Method", default: "fuzzy-vpl", description: "how" },
    vpl_clusters: { anyOf: [{ type: "integer", minimum: 1, maximum: 9 }, { type: "null" }], default: null },
    lambertian: { type: "boolean", default: false },
    exposure: { anyOf: [{ type: "number", exclusiveMinimum: 0 }, { type: "null" }], default: null },
    nested: { type: "object" },
  },
};

test("each property becomes the control that suits it", () => {
  const fields = fieldsOf(schema);
  assert.deepEqual(
    fields.map(({ name, label, kind, optional }) => [name, label, kind, optional]),
    [
      ["method", "method", "choice", false],
      ["vpl_clusters", "VPL clusters", "integer", true],
      ["lambertian", "lambertian", "switch", false],
      ["exposure", "exposure", "number", true],
    ],
  );
  const [method, clusters, , exposure] = fields;
  assert.deepEqual(method?.choices, ["fuzzy-vpl", "path"]);
  assert.equal(method?.initial, "fuzzy-vpl");
  assert.equal(method?.hint, "how");
  assert.deepEqual([clusters?.min, clusters?.max, clusters?.initial], [1, 9, null]);
  assert.deepEqual([exposure?.min, exposure?.max, exposure?.open, clusters?.open], [0, null, true, false]);
});

test("of a link's words only settings with values that they can have are taken", () => {
  const fields = fieldsOf(schema);
  const words = { method: "path", vpl_clusters: "9", lambertian: "true", exposure: "0.5", other: "1" };
  assert.deepEqual(accepted(fields, words), { method: "path", vpl_clusters: 9, lambertian: true, exposure: 0.5 });
  assert.deepEqual(accepted(fields, { method: "fuzzy-vpl", lambertian: "false" }), {});
  const junk = { method: "magic", vpl_clusters: "10", lambertian: "yes", exposure: "", nested: "{}" };
  assert.deepEqual(accepted(fields, junk), {});
  assert.deepEqual(accepted(fields, { vpl_clusters: "1.5", exposure: "Infinity" }), {});
  assert.deepEqual(accepted(fields, { exposure: "0" }), {});
});
