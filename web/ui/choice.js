/** A select of the title bar: one scene of the server's, or one camera of the scene's. */

/** @typedef {{value: string, label: string, group?: string}} Choice */

/**
 * Lists the options, keeping what is chosen; disabled unless there is a choice.
 * @param {HTMLSelectElement} select
 * @param {readonly Choice[]} options
 */
export function offer(select, options) {
  const chosen = select.value;
  const groups = new Map(options.map(({ group }) => [group, /** @type {Choice[]} */ ([])]));
  for (const option of options) groups.get(option.group)?.push(option);
  const nodes = [...groups].flatMap(([label, members]) => {
    const entries = members.map((option) => new Option(option.label, option.value));
    if (label === undefined || groups.size === 1) return entries;
    const group = document.createElement("optgroup");
    group.label = label;
    group.append(...entries);
    return [group];
  });
  select.replaceChildren(...nodes);
  select.value = chosen;
  select.disabled = options.length < 2;
}
