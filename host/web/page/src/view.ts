// The views, of which one is visible at a time: balance, plots, set-up, ...; and the tabs that choose.
import type {Key} from "./keys";
import {el, setAttributes} from "./dom";

export interface View {
  /** Of its panel; its tab is "tab-" and this. */
  readonly id: string;
  readonly title: string;
  /** That shows it, and what the help says of it. */
  readonly key: string;
  readonly does: string;
  readonly element: HTMLElement;
  /** It covers all, tabs too: none of them is its own. */
  readonly coversAll?: boolean;
  /** The strip of levels stands beside it where there is room. */
  readonly withLevels?: boolean;
  /** Valid while it is seen. */
  readonly keys?: readonly Key[];
  /** With each frame of the page while it is seen. */
  draw(nowMs: number): void;
  /** It is seen from now on, or no longer. */
  seen?(is: boolean): void;
}

/** Outlives a reload, as does the token. */
const kKept = "view";

export class Views {
  readonly tabs: HTMLElement;
  readonly panels: HTMLElement;
  private now: View;
  private before: View;

  /** @param views  at least one; the first is shown at first */
  constructor(private readonly views: readonly View[], private readonly beside: HTMLElement) {
    const [first] = views;
    if (!first) throw new Error("no view");
    this.now = this.before = first;
    this.tabs = el("div", {class: "tabs", role: "tablist", "aria-label": "Views"}, this.tabbed().map((view) => this.tab(view)));
    this.tabs.onkeydown = (event) => this.step(event);
    this.panels = el("main", {}, [...views.map((view) => {
      setAttributes(view.element, {id: view.id, role: view.coversAll ? "region" : "tabpanel", "aria-label": view.title});
      view.element.hidden = true;
      return view.element;
    }), beside]);
  }

  /** Shows what was seen before a reload, or else the first. */
  begin(): void {
    const kept = sessionStorage.getItem(kKept);
    this.show((this.views.find(({id}) => id === kept) ?? this.now).id);
  }

  /** One each, and those of the view that is seen. */
  keys(): Key[] {
    return [...this.views.map(({id, key, does}) => ({key, does, run: () => this.show(id)})), ...(this.now.keys ?? [])];
  }

  show(id: string): void {
    const found = this.views.find((view) => view.id === id);
    if (!found) return;
    if (found !== this.now) this.before = this.now;
    this.now.seen?.(false);
    this.now = found;
    for (const view of this.views) {
      const is = view === found;
      view.element.hidden = !is;
      const tab = this.tabs.querySelector(`#tab-${view.id}`);
      if (tab) setAttributes(tab, {"aria-selected": String(is), tabindex: is ? 0 : -1});
    }
    this.beside.hidden = found.withLevels !== true;
    document.body.dataset["view"] = id;
    sessionStorage.setItem(kKept, id);
    found.seen?.(true);
    found.draw(performance.now());
  }

  isShown(id: string): boolean {
    return this.now.id === id;
  }

  /** To the one that was seen before this one. */
  back(): void {
    this.show(this.before.id);
  }

  draw(nowMs: number): void {
    this.now.draw(nowMs);
  }

  private tabbed(): View[] {
    return this.views.filter(({coversAll}) => !coversAll);
  }

  private tab(view: View): HTMLElement {
    const tab = el("button", {type: "button", role: "tab", id: `tab-${view.id}`, "aria-controls": view.id,
                              "aria-keyshortcuts": view.key}, [view.title]);
    tab.onclick = () => this.show(view.id);
    return tab;
  }

  /** Arrows go from tab to tab (WAI-ARIA, tabs). */
  private step(event: KeyboardEvent): void {
    const by = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (by === undefined) return;
    event.preventDefault();
    const tabbed = this.tabbed();
    const next = tabbed[(tabbed.indexOf(this.now) + by + tabbed.length) % tabbed.length];
    if (!next) return;
    this.show(next.id);
    this.tabs.querySelector<HTMLElement>(`#tab-${next.id}`)?.focus();
  }
}
