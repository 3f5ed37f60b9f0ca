// What the first user sees: rb demo, and the page whose address it prints.
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {mkdtempSync, readdirSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {test} from "node:test";
import {holdEscape, openDemo, picture, showsBars} from "./browser.mjs";

test("rb demo prints where the page is, and the page tells the car's balance before the drive is over", async (t) => {
  const {page, ended} = await openDemo(t, "--drive-seconds", "320", "--rate", "10");
  assert.equal(new URL(page.url()).hash, "", "the token stays in sight");
  await showsBars(page);
  assert.match(await page.locator("#state").innerText(), /RECORDING/);
  await picture(page, "demo-begins");

  await page.waitForFunction(() => document.querySelectorAll(".wheel[data-known=true]").length === 4 &&
    /Clip \d+\sg at .* on the outer flange/.test(document.querySelector("#wheel-1").innerText), null, {timeout: 120_000});
  await picture(page, "demo-knows");
  // The truth is 35 g at 217 degrees; an early estimate may be a few degrees off.
  const [, degrees] = /Heavy spot at (\d+)°/.exec(await page.locator("#wheel-1").innerText());
  assert.ok(Math.abs(degrees - 217) <= 12, `${degrees}°`);
  assert.equal(await page.locator("#lamp-LOSS").getAttribute("data-light"), "good");

  assert.equal(await ended, 0);
});

test("a recording of rb demo is stopped on the page with 0 lost, and another started", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "rb-demo-page-"));
  t.after(() => rmSync(folder, {recursive: true, force: true}));
  const {page, ended} = await openDemo(t, "--drive-seconds", "320", "--rate", "10", "--record", join(folder, "drive"));
  const says = (selector, words) => page.waitForFunction(
    ([where, wanted]) => new RegExp(wanted).test(document.querySelector(where)?.innerText ?? ""), [selector, words], {timeout: 60_000});
  await says("#state", "RECORDING\\s+\\d\\d:\\d\\d:(?!00)");
  await holdEscape(page);
  await says("#receipt", "“drive” is on the disk: 0 lost");
  await says("#state", "ARMED");
  await picture(page, "demo-stopped");
  await page.locator("#tab-recordings").click();
  await says("#recordings", "drive");
  await page.locator("#recording-name").fill("rest of the drive");
  await page.keyboard.press("Enter");
  await says("#state", "RECORDING");
  assert.equal(await ended, 0);
  assert.deepEqual(readdirSync(folder).sort(), ["drive", "recorder.json", "rest of the drive"]);
  for (const name of ["drive", "rest of the drive"]) {
    const proof = spawnSync(join(process.env.RB_BIN, "rb"), ["verify", join(folder, name)], {encoding: "utf8"});
    assert.equal(proof.status, 0, proof.stdout);
  }
});
