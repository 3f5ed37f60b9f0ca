// Start, mark and stop on the page, beside the real rb-web, rb-recorder and nodes of the simulated car.
import assert from "node:assert/strict";
import {execFileSync, spawnSync} from "node:child_process";
import {once} from "node:events";
import {mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {busUrl, holdEscape, launch, picture, start, startWeb, stopIsHeld, tooSmall, weakTexts} from "./browser.mjs";

const kDesk = {width: 1366, height: 768}, kPhone = {width: 390, height: 844};
const kWithinMs = 60_000;
const kDemo = join(process.env.RB_SOURCE, "sim/demo/vehicle.toml"), kRb = join(process.env.RB_BIN, "rb");

let browser, where;
const programs = [], url = busUrl(), folder = mkdtempSync(join(tmpdir(), "rb-operation-"));
const recordings = join(folder, "recordings"), vehicles = join(folder, "vehicles"), vehicle = join(vehicles, "car.toml");
mkdirSync(vehicles);
const car = readFileSync(kDemo, "utf8");
writeFileSync(vehicle, car);
// A count of the first channel of the front node is a hundred times as much by this file, so that the simulated device, which goes
// by the file that its node has, sends a hundredth of the counts.
const kHundredfold = `calibration = { scale_m_s2_per_count = ${100 * 200 / 2 ** 23} }\n`;
writeFileSync(join(vehicles, "winter.toml"), car.replace("demonstration car", "winter tyres")
  .replace(/range_m_s2 = 200\n/, (range) => range + kHundredfold));
const runRecorder = () => {
  const recorder = start("rb-recorder", "--url", url, "--recordings", recordings, "--vehicle", vehicle);
  programs.push(recorder);
  return recorder;
};
let recorder;
before(async () => {
  browser = await launch();
  recorder = runRecorder();
  for (const node of ["front", "rear"])
    programs.push(start("rb-node", "--stay", "--url", url, "--vehicle", vehicle, "--node", node,
                        "--front-end", "sim:?seed=1&rate=1&seconds=3600"));
  programs.push(start("rb-analyser", "--url", url, "--recordings", recordings, "--vehicle", vehicle));
  const web = await startWeb(url);
  programs.push(web.web);
  where = web.where;
});
after(async () => {
  await browser?.close();
  for (const program of programs) program.kill();
  rmSync(folder, {recursive: true, force: true});
});

async function open(t, options = {}, address = where) {
  const page = await browser.newPage({viewport: kDesk, ...options});
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  t.after(async () => {
    await page.close();
    assert.deepEqual(complaints, []);
  });
  await page.goto(address);
  return page;
}
/// A process that is killed holds its folder until it is gone.
const killRecorder = async () => {
  const gone = once(recorder, "exit");
  recorder.kill("SIGKILL");
  await gone;
};
const says = (page, selector, words) => page.waitForFunction(
  ([where_, wanted]) => new RegExp(wanted).test(document.querySelector(where_)?.innerText ?? ""), [selector, words], {timeout: kWithinMs});
const isState = (page, word) => says(page, "#state", `^\\s*${word}`);
const verify = (name) => spawnSync(kRb, ["verify", join(recordings, name)], {encoding: "utf8"});

test("a recording started and stopped by the keyboard alone has its receipt with 0 lost", async (t) => {
  const page = await open(t);
  await isState(page, "ARMED");
  // The first node that is heard arms the recorder, whenever the second comes.
  await says(page, "header", "2 nodes wait for the start");
  await page.keyboard.press("r");
  await isState(page, "RECORDING");
  await says(page, "#operation-says", "is being recorded");
  await page.keyboard.press("Space");
  await says(page, "#operation-says", "mark 1 is on the disk");
  // A mark with words: Tab to the field, Enter sets it.
  await page.locator("#mark").focus();
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.id), "mark-text");
  await page.keyboard.type("R bridge <b>1</b>");
  await page.keyboard.press("Enter");
  await says(page, "#operation-says", "mark 2 is on the disk");
  await picture(page, "operation-recording");
  // A touch in passing stops nothing.
  await page.keyboard.down("Escape");
  await page.waitForTimeout(300);
  await page.keyboard.up("Escape");
  await page.waitForTimeout(1000);
  await isState(page, "RECORDING\\s+00:0");
  await holdEscape(page);
  await says(page, "#receipt", "0 lost");
  await isState(page, "ARMED");
  await picture(page, "operation-receipt");
  const receipt = await page.locator("#receipt").innerText();
  assert.match(receipt, /is on the disk: 0 lost/);
  assert.match(receipt, /2 marks/);
  assert.equal(await page.locator("#receipt tbody tr[data-whole=true]").count(), 2);
  assert.equal((receipt.match(/[0-9a-f]{8} agrees/g) ?? []).length, 2);
  const name = /“(.+)”/.exec(receipt)[1];
  const proof = verify(name);
  assert.equal(proof.status, 0, proof.stdout);
  assert.match(proof.stdout, /mark 1\n/);
  assert.match(proof.stdout, /mark 2: R bridge <b>1<\/b>/);
  assert.match(proof.stdout, /asked: stop/);
});

test("works by finger, with a name, and refuses a name that is taken", async (t) => {
  const page = await open(t, {viewport: kPhone, hasTouch: true});
  await isState(page, "ARMED");
  await page.locator("#recording-name").fill("by finger");
  await page.locator("#start").tap();
  await isState(page, "RECORDING");
  assert.match(await page.locator(".amounts").innerText(), /^by finger · /);
  await picture(page, "operation-phone");
  assert.deepEqual(await tooSmall(page), [], "too small for a finger");
  await page.locator("#tab-equipment").tap();
  await page.locator("#zero-mark").waitFor();
  assert.deepEqual(await tooSmall(page), [], "too small for a finger, of the equipment");
  await page.locator("#stop").tap();
  await page.waitForTimeout(1200);
  await isState(page, "RECORDING");
  const {x, y, width, height} = await page.locator("#stop").boundingBox();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  await stopIsHeld(page);
  await page.mouse.up();
  await says(page, "#receipt", "“by finger” is on the disk: 0 lost");
  assert.equal(verify("by finger").status, 0);
  await page.locator("#recording-name").fill("by finger");
  await page.keyboard.press("Enter");
  await says(page, "#operation-says", "there is a recording \"by finger\": choose another name");
  await isState(page, "ARMED");
});

test("two pages and the command line see one recording", async (t) => {
  const [first, second] = [await open(t), await open(t)];
  await isState(first, "ARMED");
  await isState(second, "ARMED");
  execFileSync(kRb, ["start", "shared", "--url", url]);
  await isState(first, "RECORDING");
  await isState(second, "RECORDING");
  await first.keyboard.press("Space");
  await says(first, "#operation-says", "mark 1 is on the disk");
  assert.equal(await second.locator("#operation-says").innerText(), "");
  const stopped = JSON.parse(execFileSync(kRb, ["stop", "--json", "--url", url], {encoding: "utf8"}));
  assert.equal(stopped.recording, "shared");
  assert.deepEqual(stopped.nodes.map(({samples_lost}) => samples_lost), [0, 0]);
  await says(second, "#receipt", "“shared” is on the disk: 0 lost");
});

test("a recorder that is killed between command and answer goes on, and nothing is lost", async (t) => {
  const page = await open(t);
  await isState(page, "ARMED");
  await page.locator("#recording-name").fill("killed");
  await page.keyboard.press("Enter");
  await isState(page, "RECORDING");
  for (let k = 0; k < 3; ++k) {
    await page.keyboard.press("Space");
    await killRecorder();
    await page.waitForTimeout(100);
    recorder = runRecorder();
    await says(page, "#operation-says", `mark ${k + 1} is on the disk`);
  }
  await holdEscape(page);
  await killRecorder();
  recorder = runRecorder();
  await says(page, "#receipt", "“killed” is on the disk: 0 lost");
  const proof = verify("killed");
  assert.equal(proof.status, 0, proof.stdout);
  for (const mark of [1, 2, 3]) assert.match(proof.stdout, new RegExp(`mark ${mark}\\n`));
});

test("sets range, filter, zeros and vehicle file between recordings, and each answer is shown", async (t) => {
  const page = await open(t);
  await isState(page, "ARMED");
  await page.keyboard.press("e");
  // By keyboard: from field to field, Enter sets.
  await page.locator("#range-channel").focus();
  await page.keyboard.type("2.5");
  await page.keyboard.press("Tab");
  await page.keyboard.type("80");
  await page.keyboard.press("Enter");
  await says(page, "#says-range", "channel 2.5 has a range of 80 m/s²");
  await page.locator("#filter-corner").fill("150");
  await page.locator("#set-filter").click();
  await says(page, "#says-filter", "every node filters above 150 Hz");
  await page.locator("#set-zero").click();
  await says(page, "#says-zero", "the car must stand still|too little has been heard");  // it drives
  await page.locator("#scale-channel").fill("2.5");
  await page.locator("#set-scale-down").click();
  await says(page, "#says-scale", "the car must stand still|too little has been heard");
  await page.locator("#vehicle-name").fill("../car.toml");
  await page.locator("#set-vehicle").click();
  await says(page, "#says-vehicle", "there are: car.toml, winter.toml");
  await picture(page, "equipment");
  assert.deepEqual(await weakTexts(page), []);
  const level = () => page.evaluate(() => Number(document.querySelector(".bar .value").textContent));
  await page.locator("#tab-balance").click();
  await page.waitForFunction(() => Number(document.querySelector(".bar .value")?.textContent) > 0);
  const before = await level();
  await page.locator("#tab-equipment").click();
  await page.locator("#vehicle-name").fill("winter.toml");
  await page.locator("#set-vehicle").click();
  await says(page, "#says-vehicle", "winter.toml is in force");
  assert.match(readFileSync(vehicle, "utf8"), /range_m_s2 = 80\n/);
  // Levels between recordings go by the file in force: by the one before they would be a hundredth.
  await page.locator("#tab-balance").click();
  await page.waitForTimeout(4000);
  const now = await level();
  assert.ok(before / 10 < now && now < 10 * before, `${before} became ${now}`);
  await page.locator("#tab-equipment").click();
  await page.locator("#tab-equipment").focus();
  await page.keyboard.press("r");
  await isState(page, "RECORDING");
  await says(page, "#equipment-why", "Not while a recording is under way");
  assert.equal(await page.locator("#set-range").isDisabled(), true);
  await holdEscape(page);
  await says(page, "#receipt", "0 lost");
});

// The simulated car drives, so no reading counts; that counting is right is mark_readings_test's.
test("a zero mark is read while a recording is under way, and set when it is over", async (t) => {
  const page = await open(t);
  await isState(page, "ARMED");
  await page.keyboard.press("e");
  await says(page, "#says-reading", "start a recording first");
  assert.equal(await page.locator("#begin-reading").isDisabled(), true);
  await page.locator("#mark-wheel").selectOption("rear right");
  await page.locator("#tab-equipment").focus();
  await page.keyboard.press("r");
  await isState(page, "RECORDING");
  await page.locator("#mark-where").fill("10:30");
  await page.locator("#set-reading").click();
  await says(page, "#says-reading", "begin with this wheel first");
  await page.locator("#begin-reading").click();
  await says(page, "#says-reading", "rear_right: turn it forward by hand until its zero mark fires");
  await page.locator("#mark-where").fill("10:30");
  await page.waitForTimeout(1500);
  await page.locator("#set-reading").click();
  await says(page, "#says-reading", "it turns, or has just come to a stand");
  assert.equal(await page.locator("#set-datum").isDisabled(), true);
  await says(page, "#says-datum", "Not while a recording is under way");
  // A look at this wheel loses nothing in another wheel's fields.
  await page.locator("#mark-datum").fill("12.5");
  await page.locator("#mark-wheel").selectOption("front left");
  assert.equal(await page.locator("#mark-datum").inputValue(), "");
  await page.locator("#mark-wheel").selectOption("rear right");
  assert.equal(await page.locator("#mark-datum").inputValue(), "12.5");
  // An hour, or degrees?  Nobody guesses.
  await page.locator("#mark-where").fill("10");
  await page.locator("#set-reading").click();
  assert.match(await page.locator("#mark-where").evaluate((field) => field.validationMessage), /not 10, which may be either/);
  await page.locator("#mark-where").fill("10:30");
  await page.locator("#zero-mark").scrollIntoViewIfNeeded();
  await picture(page, "equipment-zero-mark");
  await page.getByRole("button", {name: /Day\/night/}).click();
  await page.locator("#zero-mark").scrollIntoViewIfNeeded();
  await picture(page, "equipment-zero-mark-night");
  assert.deepEqual(await weakTexts(page), []);
  await page.locator("#tab-equipment").focus();
  await holdEscape(page);
  await isState(page, "ARMED");
  await page.locator("#mark-datum").fill("-107.25");
  await page.locator("#mark-sigma").fill("0.5");
  await page.locator("#set-datum").click();
  await says(page, "#says-datum", "rear_right: its zero mark fires at -107\\.25 ± 0\\.50 deg \\(at node 1, 2\\)");
  const winter = readFileSync(join(vehicles, "winter.toml"), "utf8");
  assert.match(winter.slice(winter.indexOf('name = "rear_right"')), /^[^[]*\[wheel\.encoder\][^[]*datum_deg = -107\.25\n[^[]*datum_sigma_deg = 0\.5\n/);
  await page.keyboard.press("s");
  await says(page, "#setup", "rear right\\s+2 line 2\\s+96\\s+[^\\n]*\\s+-107\\.[23]° ± 0\\.5°");
});

test("a page without the token may watch, and says why it may do no more", async (t) => {
  const page = await open(t, {}, where.replace(/#.*/, ""));
  await isState(page, "ARMED");
  await says(page, "#operation-says", "opened without #token=");
  assert.equal(await page.locator("#start").isDisabled(), true);
  await page.keyboard.press("r");
  await page.waitForTimeout(1000);
  await isState(page, "ARMED");
});

for (const colorScheme of ["dark", "light"])
  test(`can be read while it works, ${colorScheme}`, async (t) => {
    const page = await open(t, {colorScheme});
    await isState(page, "ARMED");
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `operation-armed-${colorScheme}`);
    await page.keyboard.press("r");
    await isState(page, "RECORDING");
    await page.keyboard.down("Escape");
    await page.waitForTimeout(400);
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `operation-held-${colorScheme}`);
    await stopIsHeld(page);
    await page.keyboard.up("Escape");
    await says(page, "#receipt", "0 lost");
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `operation-stopped-${colorScheme}`);
  });
