// Keys of the viewer: they work wherever the focus is, except where a reader types or chooses.

/** Elements that use letters or arrows themselves. */
const OWN_KEYS = "input:not([type=button]):not([type=submit]):not([type=checkbox]):not([type=range]), textarea, select, [contenteditable], dialog[open]";
const OWN_ARROWS = `${OWN_KEYS}, input, [role=tablist], [role=slider], [role=radiogroup], [role=menu], .menu`;

export const isModified = (event: KeyboardEvent): boolean => event.ctrlKey || event.metaKey || event.altKey;

/** Whether a key belongs to the element that has the focus. */
export function belongsToFocus(event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : null;
  return target?.closest(event.key.startsWith("Arrow") ? OWN_ARROWS : OWN_KEYS) != null;
}

/** Passes keys that nothing else has used on to `host`, wherever the focus is; the function returned stops that. */
export function listenForKeys(host: () => HTMLElement | null): () => void {
  const pass = (event: KeyboardEvent) => {
    const to = host();
    if (!to || event.defaultPrevented || isModified(event) || belongsToFocus(event) || document.querySelector("dialog[open]")) return;
    if (event.target instanceof Node && to.contains(event.target)) return; // it has been there
    const passed = new KeyboardEvent("keydown", { key: event.key, shiftKey: event.shiftKey, bubbles: true, cancelable: true });
    to.dispatchEvent(passed);
    if (passed.defaultPrevented) event.preventDefault();
  };
  addEventListener("keydown", pass);
  return () => removeEventListener("keydown", pass);
}
