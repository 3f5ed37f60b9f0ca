// Every function of the page has a key.

export interface Key {
  readonly key: string;
  readonly does: string;
  run(): void;
}

/** Whoever types into a field means the field; Space and Enter press the button that has the focus. */
function isForElement(event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : undefined;
  if (target?.closest("input, select, textarea")) return true;
  return (event.key === " " || event.key === "Enter") && target?.closest("button, summary, a") != null;
}

/** Not while a modifier makes it the browser's.
    @param keys  those that are valid at the moment */
export function listenToKeys(keys: () => readonly Key[]): void {
  // A button that finger or mouse has pressed must not catch the next Space or Enter; focus by keyboard stays.
  document.addEventListener("click", ({target, detail}) => {
    const pressed = target instanceof Element ? target.closest("button, summary") : null;
    if (detail > 0 && pressed instanceof HTMLElement) pressed.blur();
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || isForElement(event)) return;
    const found = keys().find(({key}) => key.toLowerCase() === event.key.toLowerCase());
    if (!found) return;
    event.preventDefault();
    found.run();
  });
}
