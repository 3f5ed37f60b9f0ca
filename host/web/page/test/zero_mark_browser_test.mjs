// A wheel of the simulated car is turned by hand and let stand, again and again: its zero mark is read and set on the page.
import assert from "node:assert/strict";
import {mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {test} from "node:test";
import {busUrl, holdEscape, launch, picture, start, startWeb} from "./browser.mjs";

const kDemo = join(process.env.RB_SOURCE, "sim/demo"), kWithinMs = 90_000;
const kRadius_m = 0.30, kTurning_s = 2.5, kStanding_s = 5, kTurns = 2;  // two turns: the wheel stands alike each time
const kPitch_deg = 360 / 96;

function byHand(folder) {
  const speed_km_h = 3.6 * kTurns * 2 * Math.PI * kRadius_m / kTurning_s;
  const plateau = (speed, seconds) => `[[drive.plateau]]\nspeed_km_h = ${speed.toFixed(9)}\nseconds = ${seconds.toFixed(1)}\n`;
  const drive = `[drive]\nramp_s = 0.5\nwander_km_h = 0.0\n${plateau(0, 2)}` +
    (plateau(speed_km_h, kTurning_s) + plateau(0, kStanding_s)).repeat(60);
  const scenario = readFileSync(join(kDemo, "scenario.toml"), "utf8").replace(/^\[drive\]$[^]*?(?=^\[road\]$)/m, drive)
    .replace("rolling_radius = 0.003", "rolling_radius = 0.0");
  assert.match(scenario, /rolling_radius = 0\.0\b/);
  const file = join(folder, "by-hand.toml");
  writeFileSync(file, scenario);
  return file;
}

test("the zero mark of a wheel that is turned by hand is read on the page, and set", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "rb-zero-mark-")), url = busUrl(), programs = [], browser = await launch();
  t.after(async () => {
    await browser.close();
    for (const program of programs) program.kill();
    rmSync(folder, {recursive: true, force: true});
  });
  const vehicle = join(folder, "vehicles", "car.toml");
  mkdirSync(join(folder, "vehicles"));
  writeFileSync(vehicle, readFileSync(join(kDemo, "vehicle.toml")));
  const scenario = byHand(folder);
  programs.push(start("rb-recorder", "--url", url, "--recordings", join(folder, "recordings"), "--vehicle", vehicle));
  for (const node of ["front", "rear"])
    programs.push(start("rb-node", "--stay", "--url", url, "--vehicle", vehicle, "--node", node,
                        "--front-end", `sim:${scenario}?seed=1&rate=1`));
  const {web, where} = await startWeb(url);
  programs.push(web);
  const page = await browser.newPage({viewport: {width: 1366, height: 768}});
  await page.goto(where);
  const says = (selector, words) => page.waitForFunction(([at, wanted]) =>
    new RegExp(wanted).test(document.querySelector(at)?.innerText ?? ""), [selector, words], {timeout: kWithinMs});
  await says("#state", "^\\s*ARMED");
  await page.keyboard.press("e");
  await page.locator("#tab-equipment").focus();
  await page.keyboard.press("r");
  await says("#state", "^\\s*RECORDING");

  /** Reads a wheel that is seen to stand so, as often as it takes; refused while it turns and until its mark has fired. */
  async function read(where_, counted) {
    const end = performance.now() + kWithinMs;
    do {
      assert.ok(performance.now() < end, await page.locator("#says-reading").innerText());
      await page.locator("#mark-where").fill(where_);
      await page.locator("#set-reading").click();
      await page.waitForFunction(() => !document.querySelector("#set-reading").disabled);
      await page.waitForTimeout(300);
    } while (!counted.test(await page.locator("#says-reading").innerText()));
  }
  async function datumOf(where_) {
    await page.locator("#begin-reading").click();
    await says("#says-reading", "front_left: turn it forward by hand");
    await read(where_, /the first reading says/);
    assert.equal(await page.locator("#mark-where").inputValue(), "", "each reading is a look of its own");
    await read(where_, /2 readings say/);
    return Number(await page.locator("#mark-datum").inputValue());
  }
  await page.locator("#mark-wheel").selectOption("front left");
  const first = await datumOf("40°");
  // A toothed ring of 96 teeth resolves a standing wheel to a tooth, evenly: two readings to pitch / sqrt(12 * 2).
  const sigma_deg = Number(await page.locator("#mark-sigma").inputValue());
  assert.ok(Math.abs(sigma_deg - kPitch_deg / Math.sqrt(24)) <= 0.011, `${sigma_deg}`);
  await page.locator("#zero-mark").scrollIntoViewIfNeeded();
  await picture(page, "equipment-zero-mark-read");
  // The same stands, seen 15 degrees further: so much further fires the mark.
  const further = await datumOf("55°");
  assert.ok(Math.abs(further - first - 15) < 0.011, `${first} became ${further}`);

  await page.locator("#tab-equipment").focus();
  await holdEscape(page);
  await says("#state", "^\\s*ARMED");
  await page.locator("#set-datum").click();
  const words = further.toFixed(2).replace(".", "\\.");
  await says("#says-datum", `front_left: its zero mark fires at ${words} `);
  assert.match(readFileSync(vehicle, "utf8"), new RegExp(`datum_deg = ${words.replace(/0+$/, "")}`));
});
