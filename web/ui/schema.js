/** The part of JSON schema that describes the settings, read into fields that a form can show. */

/**
 * @typedef {object} JsonSchema
 * @property {string} [type]
 * @property {string} [title]
 * @property {string} [description]
 * @property {unknown} [default]
 * @property {unknown[]} [enum]
 * @property {number} [minimum]
 * @property {number} [maximum]
 * @property {number} [exclusiveMinimum]
 * @property {JsonSchema[]} [anyOf]
 * @property {JsonSchema[]} [allOf]
 * @property {string} [$ref]
 * @property {Record<string, JsonSchema>} [properties]
 * @property {Record<string, JsonSchema>} [$defs]
 *
 * @typedef {object} Field
 * @property {string} name
 * @property {string} label
 * @property {string} hint
 * @property {"choice" | "integer" | "number" | "switch"} kind
 * @property {unknown} initial  the default
 * @property {boolean} optional  may be null: the server chooses
 * @property {string[]} choices
 * @property {number | null} min
 * @property {number | null} max
 * @property {boolean} open  it is more than `min`, never as much
 */

/** Words of the field that are written in capitals. */
const ACRONYMS = new Map([["sp", "SP"], ["sps", "SPs"], ["vpl", "VPL"], ["vpls", "VPLs"]]);

/** The fields of an object's schema, in its order; a property of a kind that no control shows is left out. @param {JsonSchema} schema @returns {Field[]} */
export function fieldsOf(schema) {
  return Object.entries(schema.properties ?? {}).flatMap(([name, property]) => {
    const { optional, plain } = resolve(property, schema);
    const kind = kindOf(plain);
    if (!kind) return [];
    return [
      {
        name,
        label: name.split("_").map((word) => ACRONYMS.get(word) ?? word).join(" "),
        hint: property.description ?? plain.description ?? "",
        kind,
        initial: property.default ?? null,
        optional,
        choices: (plain.enum ?? []).map(String),
        min: plain.minimum ?? plain.exclusiveMinimum ?? null,
        max: plain.maximum ?? null,
        open: plain.exclusiveMinimum !== undefined,
      },
    ];
  });
}

/** Follows references and takes "or null" apart. @param {JsonSchema} property @param {JsonSchema} root @returns {{optional: boolean, plain: JsonSchema}} */
function resolve(property, root) {
  const variants = property.anyOf ?? property.allOf ?? [property];
  const plain = variants.find((variant) => variant.type !== "null") ?? {};
  const name = plain.$ref?.split("/").at(-1);
  return {
    optional: variants.some((variant) => variant.type === "null"),
    plain: name === undefined ? plain : (root.$defs?.[name] ?? {}),
  };
}

/** @param {JsonSchema} plain @returns {Field["kind"] | null} */
function kindOf(plain) {
  if (plain.enum) return "choice";
  if (plain.type === "integer" || plain.type === "number") return plain.type;
  return plain.type === "boolean" ? "switch" : null;
}

/**
 * Of settings as words, those that these fields can have; what equals a default is left out.
 * @param {readonly Field[]} fields @param {Readonly<Record<string, string>>} words
 * @returns {Record<string, unknown>}
 */
export function accepted(fields, words) {
  const read = fields.flatMap((field) => {
    const word = words[field.name];
    const value = word === undefined ? undefined : valueOf(field, word);
    return value === undefined || value === field.initial ? [] : [/** @type {const} */ ([field.name, value])];
  });
  return Object.fromEntries(read);
}

/** @param {Field} field @param {string} word @returns {unknown} undefined if the field cannot have it */
function valueOf({ kind, choices, min, max, open }, word) {
  if (kind === "choice") return choices.includes(word) ? word : undefined;
  if (kind === "switch") return word === "true" ? true : word === "false" ? false : undefined;
  const value = word.trim() === "" ? NaN : Number(word);
  if (!Number.isFinite(value) || (kind === "integer" && !Number.isInteger(value))) return undefined;
  return (min === null || (open ? value > min : value >= min)) && (max === null || value <= max) ? value : undefined;
}
