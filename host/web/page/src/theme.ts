// Day and night.  Called before the first paint, so that nothing flashes; the choice is kept.

type Theme = "day" | "night";

export function startTheme(): void {
  const saved = localStorage.getItem("theme");
  const night = saved ? saved === "night" : !matchMedia("(prefers-color-scheme: light)").matches;
  set(night ? "night" : "day");
}

function set(theme: Theme): void {
  document.documentElement.dataset["theme"] = theme;
}

export function toggleTheme(): void {
  const theme: Theme = document.documentElement.dataset["theme"] === "night" ? "day" : "night";
  set(theme);
  localStorage.setItem("theme", theme);
}
