// A drive compared with the one before: as a report to print, and live.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {busUrl, launch, pages, picture, start, startWeb, weakTexts} from "./browser.mjs";

const rb = (...args) => execFileSync(join(process.env.RB_BIN, "rb"), args, {encoding: "utf8"});

let folder, browser, first, second;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "rb-report-"));
  [first, second] = ["first", "second"].map((name) => join(folder, name));
  // The same car twice: nothing was fitted in between, and that is what must be found.
  for (const record of [first, second])
    rb("demo", "--headless", "--rate", "max", "--drive-seconds", "160", "--seed", "1", "--record", record);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true});
});

test("the report prints to one A4 page", async () => {
  const file = join(folder, "report.html");
  const json = JSON.parse(rb("report", second, "--before", first, "-o", file, "--json"));
  const page = await browser.newPage({viewport: {width: 794, height: 1123}});  // A4 at 96 dpi
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(`file://${file}`);
  assert.deepEqual(asked, [`file://${file}`], "it takes nothing from elsewhere");
  const said = await page.locator("body").innerText();
  assert.match(said, /Wheel balance: /);
  assert.match(said, /The recording is complete\. Every CRC is right\./);
  // The truth is 35 g at 217 degrees: the weight belongs at 37, give or take.
  const [, degrees] = /front left\s+Add 3\d g at (\d+)°/i.exec(said) ?? assert.fail(said);
  assert.ok(Math.abs(degrees - 37) <= 12, `${degrees}°`);
  assert.match(said, /front left\s+before \(first\).*NO BETTER.*were the weights fitted\?/i);
  assert.equal(json.verification[0].placement, "no_effect");
  assert.equal(json.nodes[0].samples_lost, 0);
  assert.deepEqual(await weakTexts(page), []);
  await page.emulateMedia({media: "print"});
  await picture(page, "report");
  assert.equal(pages(await page.pdf({preferCSSPageSize: true})), 1);
  await page.close();
});

test("the page tells live what came of the weights, and does so again after the analyser was started again", async (t) => {
  const url = busUrl();
  const {web, where} = await startWeb(url);
  const analyse = () => start("rb-analyser", "--url", url, "--record", second, "--before", first);
  let analyser = analyse();
  const page = await browser.newPage({viewport: {width: 1366, height: 768}});
  t.after(async () => {
    await page.close();
    analyser.kill();
    web.kill();
  });
  await page.goto(where);
  const tells = () => page.waitForFunction(() =>
    [1, 2].every((wheel) => /NO BETTER.*were the weights fitted\?/s.test(document.querySelector(`#wheel-${wheel} .verified`)?.innerText ?? "")),
    null, {timeout: 120_000});
  await tells();
  await picture(page, "verified-live");
  const gone = new Promise((resolve) => analyser.once("exit", resolve));
  analyser.kill();
  await gone;
  await page.reload();
  analyser = analyse();
  await tells();
});

test("rb-recordings tells the page which recordings there are, with their receipts", async (t) => {
  const url = busUrl();
  const {web, where} = await startWeb(url);
  const recordings = start("rb-recordings", "--url", url, "--folder", folder);
  const page = await browser.newPage({viewport: {width: 1366, height: 768}});
  t.after(async () => {
    await page.close();
    recordings.kill();
    web.kill();
  });
  await page.goto(where);
  await page.keyboard.press("l");
  await page.waitForFunction(() => [...document.querySelectorAll(".recording")].filter(({innerText}) =>
    /COMPLETE/.test(innerText)).length === 2, null, {timeout: 60_000});
  const said = (await page.locator("#recordings").innerText()).replace(/\s+/g, " ");
  // 160 s of two nodes at 2 kHz.
  assert.match(said, /second COMPLETE demonstration car .* 1 320 000 0 \d+ 00:02:40 0\.0 s not known 2 320 000 0/);
  await picture(page, "recordings-live");
});
