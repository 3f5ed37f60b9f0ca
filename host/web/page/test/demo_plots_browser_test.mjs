// The plots beside rb demo: the simulated car, its nodes, recorder and analyser.
import assert from "node:assert/strict";
import {test} from "node:test";
import {openDemo, picture, showsBars} from "./browser.mjs";

const says = (page, selector, pattern, timeout = 60_000) => page.waitForFunction(
  ([where, wanted]) => new RegExp(wanted).test(document.querySelector(where)?.textContent ?? ""), [selector, pattern.source], {timeout});

test("the first order of the simulated car stands in every plot", async (t) => {
  const {page} = await openDemo(t, "--drive-seconds", "960", "--rate", "10");
  await showsBars(page);
  await page.keyboard.press("p");
  await page.locator("#plot-spectrum").click();
  await says(page, "#spectrum-caption", /\d blocks/);
  await picture(page, "demo-plot-spectrum");
  await page.locator("#plot-transfer").click();
  await says(page, "#transfer-caption", /worth/);
  await page.waitForTimeout(2000);
  await picture(page, "demo-plot-transfer");
  await page.locator("#plot-waterfall").click();
  await says(page, "#waterfall-caption", /amplitude \(peak\)/);
  // The car is driven at more than one speed.
  await page.waitForFunction(() => /amplitude/.test(document.querySelector("#waterfall-caption").textContent) &&
    Number(document.querySelector("#waterfall-plot").dataset.classes) >= 3, null, {timeout: 60_000});
  await picture(page, "demo-plot-waterfall");
  await page.locator("#plot-speed").click();
  await says(page, "#speed-caption", /s of driving used/);
  await picture(page, "demo-plot-speed");
  await page.locator("#plot-polar").click();
  await page.locator("#polar-channel").selectOption("1.3");
  await says(page, ".polar-text", /: [\d.]+ ± [\d.]+ m\/s², [\d.]+° ± [\d.]+° \(95 %\)/);
  await picture(page, "demo-plot-polar");
});
