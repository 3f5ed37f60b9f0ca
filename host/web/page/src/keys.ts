// The keyboard does all that a finger does.

export interface Key {
  readonly key: string;
  readonly does: string;
  run(): void;
}

/** Not while a modifier makes it the browser's. */
export function listenToKeys(keys: readonly Key[]): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
    const found = keys.find(({key}) => key.toLowerCase() === event.key.toLowerCase());
    if (!found) return;
    event.preventDefault();
    found.run();
  });
}
