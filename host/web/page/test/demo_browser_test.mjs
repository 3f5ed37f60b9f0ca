// The first minutes of a new user: rb demo, and the page whose address it prints.
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {mkdtempSync, readFileSync, readdirSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {test} from "node:test";
import {holdEscape, openDemo, picture, scaledPicture, showsBars} from "./browser.mjs";

/** What the simulated car has: sim/demo/scenario.toml. */
const kTruth = [...readFileSync(join(process.env.RB_SOURCE, "sim/demo/scenario.toml"), "utf8")
  .matchAll(/\[\[unbalance\]\]\nwheel = "(\w+)"\nmass_g = ([\d.]+)\nangle_deg = ([\d.]+)/g)]
  .map(([, wheel, mass_g, angle_deg]) => ({wheel, mass_g: Number(mass_g), angle_deg: Number(angle_deg)}));

/** What the page says of each wheel's heavy spot. */
async function known(page) {
  const cards = await page.locator(".card .spot-sentence").allInnerTexts();
  return cards.map((card) => {
    const [, angle_deg, mass_g, sigma_g, sigma_deg] =
      /Heavy spot at (\d+)°.*?, ([\d.]+)\sg, ±\s([\d.]+)\sg ±\s(\d+)°/.exec(card) ?? assert.fail(card);
    return {angle_deg: Number(angle_deg), mass_g: Number(mass_g), sigma_g: Number(sigma_g), sigma_deg: Number(sigma_deg)};
  });
}

test("the truth is of all four wheels", () => {
  assert.deepEqual(kTruth.map(({wheel}) => wheel), ["front_left", "front_right", "rear_left", "rear_right"]);
});

test("rb demo prints where the page is, and the page tells the car's balance before the drive is over", async (t) => {
  const {page, ended} = await openDemo(t, "--drive-seconds", "320", "--rate", "10");
  assert.equal(new URL(page.url()).hash, "", "the token stays in sight");
  await showsBars(page);
  assert.match(await page.locator("#state").innerText(), /RECORDING/);
  await picture(page, "demo-begins");

  await page.waitForFunction(() => document.querySelectorAll(".wheel[data-known=true]").length === 4 &&
    /Clip \d+\sg at .* on the outer flange/.test(document.querySelector("#wheel-1").innerText), null, {timeout: 120_000});
  await picture(page, "demo-knows");
  assert.equal(await page.locator("#lamp-LOSS").getAttribute("data-light"), "good");
  const early = await known(page);
  // All four wheels, done, in one picture: the one of the README (tools/guide/page.png).
  await page.getByText("done: better than").nth(3).waitFor({timeout: 60_000});
  await page.setViewportSize({width: 1366, height: 888});
  await scaledPicture(page, "demo-balanced", 0.75);
  await page.setViewportSize({width: 1366, height: 768});
  let late = early, over = false;
  ended.then(() => { over = true; });
  for (; !over; await new Promise((resolve) => setTimeout(resolve, 500))) late = await known(page);
  assert.equal(await ended, 0);
  for (const found of [early, late])
    for (const [wheel, truth] of kTruth.entries()) {
      // Four of its own standard deviations are missed once in 16 000; and what is shown is rounded.
      const {angle_deg, sigma_deg, mass_g, sigma_g} = found[wheel];
      const off_deg = Math.abs((angle_deg - truth.angle_deg + 540) % 360 - 180), said = JSON.stringify([found[wheel], truth]);
      assert.ok(off_deg <= 4 * sigma_deg + 0.5, said);
      assert.ok(Math.abs(mass_g - truth.mass_g) <= 4 * sigma_g + 0.05, said);
    }
  for (const wheel of kTruth.keys())
    for (const sigma of ["sigma_g", "sigma_deg"])
      assert.ok(late[wheel][sigma] <= early[wheel][sigma], `wheel ${wheel}: ${JSON.stringify([early[wheel], late[wheel]])}`);
  const sum = (found) => found.reduce((all, {sigma_g}) => all + sigma_g, 0);
  assert.ok(sum(late) < 0.9 * sum(early), `the more is driven the better it is known: ${sum(early)} g, ${sum(late)} g`);
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
