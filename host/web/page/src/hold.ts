// A button, or key, that must be held, so that a touch in passing does nothing.

/** Long enough to be meant. */
export const kHoldMs = 800;

/** Calls `done` once the button has been held, by finger, Space or Enter, or one of `keys` anywhere on the page. */
export function onHold(button: HTMLButtonElement, keys: readonly string[], done: () => void): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const release = () => {
    clearTimeout(timer);
    timer = undefined;
    delete button.dataset["held"];
  };
  const hold = () => {
    if (timer !== undefined || button.disabled || !button.checkVisibility()) return;
    button.dataset["held"] = "";
    timer = setTimeout(() => {
      release();
      if (!button.disabled && button.checkVisibility()) done();
    }, kHoldMs);
  };
  const isMeant = (event: KeyboardEvent) =>
    keys.includes(event.key) || (event.target === button && (event.key === " " || event.key === "Enter"));
  button.addEventListener("pointerdown", (event) => {
    if (event.button === 0) hold();
  });
  for (const end of ["pointerup", "pointerleave", "pointercancel"]) button.addEventListener(end, release);
  button.addEventListener("contextmenu", (event) => event.preventDefault());  // opened by a long touch
  button.addEventListener("click", (event) => event.preventDefault());
  document.addEventListener("keydown", (event) => {
    if (isMeant(event) && !event.repeat && !event.ctrlKey && !event.altKey && !event.metaKey) hold();
  });
  document.addEventListener("keyup", (event) => {
    if (isMeant(event)) release();
  });
  addEventListener("blur", release);  // the key may be let go where this page does not see it
}
