// The tap test with real taps: sensors of a car at rest, the analyser's live view, rb-web and the page.
import assert from "node:assert/strict";
import {spawn} from "node:child_process";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {busUrl, launch, picture, startWeb, weakTexts} from "./browser.mjs";

const kWithinMs = 60_000;
let browser, web, where, car;
before(async () => {
  const url = busUrl();
  browser = await launch();
  ({web, where} = await startWeb(url));
  car = spawn(join(process.env.RB_BIN, "rb-web-tap-scene"), [url], {stdio: ["pipe", "ignore", "inherit"]});
});
after(async () => {
  await browser?.close();
  car?.kill();
  web?.kill();
});

async function open(t, options = {}) {
  const page = await browser.newPage({viewport: {width: 1366, height: 768}, ...options});
  t.after(() => page.close());
  await page.goto(where);
  await page.keyboard.press("s");
  await page.waitForFunction(() => document.querySelectorAll("#tap-channel option").length > 1, null, {timeout: kWithinMs});
  return page;
}
const tapOn = (key) => car.stdin.write(`${key}\n`);
const choose = async (page, name) => {
  const value = await page.locator("#tap-channel option").evaluateAll((all, wanted) =>
    all.find(({textContent}) => textContent.endsWith(wanted)).value, name);
  await page.locator("#tap-channel").selectOption(value);
  const [node, channel] = value.split(" ").map(Number);
  return `${node}.${channel + 1}`;
};
/** The live view must have heard a second of rest, and a page may see an older tap: taps until it shows it. */
async function feels(page, key, words) {
  for (let k = 0; k < 10; ++k) {
    tapOn(key);
    const found = await page.waitForFunction((wanted) => new RegExp(wanted).test(document.querySelector("#knock").innerText),
                                             words, {timeout: 3000}).catch(() => undefined);
    if (found) return;
  }
  assert.fail(`${key}: ${await page.locator("#knock").innerText()}`);
}
const row = (page, name) => page.locator(".setup tbody tr").filter({hasText: name}).first().innerText();

for (const colorScheme of ["dark", "light"])
  test(`a tap proves the sensor that was chosen and its sign, and finds the one that is fitted wrongly, ${colorScheme}`, async (t) => {
    const page = await open(t, {colorScheme});
    const left = await choose(page, "fl_carrier_z");
    await feels(page, left, `Knock on ${left} fl_carrier_z: first swing \\+[0-9.]+ m/s².*Right, if it came from below, upwards`);
    assert.match(await row(page, "fl_carrier_z"), /✓ by knock/);
    const right = await choose(page, "fr_carrier_z");
    await feels(page, right, `Knock on ${right} fr_carrier_z: first swing −[0-9.]+ m/s².*WRONG SIGN`);
    assert.match(await row(page, "fr_carrier_z"), /✗ WRONG SIGN/);
    assert.match(await page.locator(".checks").innerText(), new RegExp(`${right} fr_carrier_z: the knock came with the wrong sign`));
    assert.deepEqual(await weakTexts(page), []);
    await page.locator("#knock").scrollIntoViewIfNeeded();
    await picture(page, `tap-${colorScheme}`);
  });

test("a tap on another sensor than the one that was chosen proves nothing", async (t) => {
  const page = await open(t);
  const left = await choose(page, "fl_carrier_z");
  const right = await choose(page, "fr_carrier_z");
  assert.notEqual(left, right);
  await feels(page, left, `Knock on ${left} fl_carrier_z.*Proves nothing: it is not what was chosen`);
  assert.match(await row(page, "fl_carrier_z"), /not yet/);
});
