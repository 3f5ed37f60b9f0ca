// Makes elements without markup, so that no text from the network can become a script.

type Children = readonly (Node | string)[];

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Readonly<Record<string, string>> = {}, children: Children = []): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K, attributes: Readonly<Record<string, string | number>> = {}, children: Children = []): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

/** Touches only what changes: twenty times a second that is most of the work. */
export function setAttributes(element: Element, attributes: Readonly<Record<string, string | number>>): void {
  for (const [name, value] of Object.entries(attributes))
    if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
}

export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** One paragraph each. */
export function setLines(element: Element, lines: readonly string[]): void {
  while (element.children.length > lines.length) element.lastElementChild?.remove();
  while (element.children.length < lines.length) element.append(el("p"));
  lines.forEach((line, k) => setText(element.children[k] as Element, line));
}

export interface Cell {
  readonly text: string;
  /** Of the cell's colour and weight: "good", "bad", ... */
  readonly tone?: string;
}

/** The body of a table, touched only where it changes. */
export function setRows(body: Element, rows: readonly (readonly Cell[])[]): void {
  while (body.children.length > rows.length) body.lastElementChild?.remove();
  while (body.children.length < rows.length) body.append(el("tr"));
  rows.forEach((cells, r) => {
    const row = body.children[r] as Element;
    while (row.children.length > cells.length) row.lastElementChild?.remove();
    while (row.children.length < cells.length) row.append(el("td"));
    cells.forEach(({text, tone}, c) => {
      const cell = row.children[c] as Element;
      setText(cell, text);
      setAttributes(cell, {"data-tone": tone ?? ""});
    });
  });
}

/** A table that scrolls by itself where it is too wide. */
export function table(caption: string, heads: readonly string[], body: HTMLElement): HTMLElement {
  return el("div", {class: "table", tabindex: "0", role: "region", "aria-label": caption}, [
    el("table", {}, [el("thead", {}, [el("tr", {}, heads.map((head) => el("th", {scope: "col"}, [head])))]), body])]);
}
