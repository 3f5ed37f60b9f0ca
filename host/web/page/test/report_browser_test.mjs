// A drive compared with the one before: as a report to print, and live.
import assert from "node:assert/strict";
import {execFileSync, spawnSync} from "node:child_process";
import {cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, truncateSync, utimesSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {busUrl, launch, pages, picture, pictureFile, start, startWeb, weakTexts} from "./browser.mjs";

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
  const [, degrees] = /front left\s+Clip 3\d g at (\d+)° on the outer flange/i.exec(said) ?? assert.fail(said);
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

/** Texts of a table's cells, row by row, of the account's section (and the part of it below a heading of the third level). */
const tableOf = (page, section, part, column) => page.evaluate(([wanted, below, head]) => {
  let [h2, h3] = ["", ""];
  for (const element of document.querySelectorAll(".account h2, .account h3, .account table")) {
    if (element.tagName === "H2") [h2, h3] = [element.textContent, ""];
    else if (element.tagName === "H3") h3 = element.textContent;
    else if (h2 === wanted && h3 === below && (!head || [...element.querySelectorAll("th")].some((th) => th.textContent === head)))
      return [...element.querySelectorAll("tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent));
  }
  return null;
}, [section, part ?? "", column]);
const figure = (value, digits) => value === null ? "–" : value.toFixed(digits);
const withReach = (value, reach, digits) => figure(value, digits) + (value === null || reach === null ? "" : ` ± ${figure(reach, digits)}`);

/** The density that a chart draws: [[Hz, density]], by the figures at its axes. */
const curveOf = (page, channel) => page.evaluate((name) => {
  const chart = [...document.querySelectorAll("figure")].find((one) => one.querySelector("h4").textContent === name).querySelector("svg");
  const ticks = [...chart.querySelectorAll("text")].map((text) => ({text: text.textContent, x: Number(text.getAttribute("x")), y: Number(text.getAttribute("y"))}));
  const scale = (all) => {
    const [[a, u], [b, v]] = [all[0], all.at(-1)];
    return (at) => 10 ** (u + (v - u) * (at - a) / (b - a));
  };
  const hz = scale(ticks.filter(({text}) => /^[\d.]+$/.test(text)).map(({text, x}) => [x, Math.log10(Number(text))]));
  const density = scale(ticks.filter(({text}) => /^1e/.test(text)).map(({text, y}) => [y - 3, Number(text.slice(2))]));
  return [...chart.querySelector(".curve").getAttribute("d").matchAll(/([\d.]+) ([\d.]+)/g)].map(([, x, y]) => [hz(Number(x)), density(Number(y))]);
}, channel);

test("the complete account tells what the commands tell, and prints to A4", async () => {
  const file = join(folder, "account.html");
  rb("report", second, "--before", first, "-o", file, "--complete");
  const page = await browser.newPage({viewport: {width: 688, height: 1032}});  // 182 mm, between the margins of A4
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(`file://${file}`);
  assert.deepEqual(asked, [`file://${file}`], "it takes nothing from elsewhere");
  const json = (...args) => JSON.parse(rb(...args, "--json"));

  const levels = json("levels", second);
  assert.equal(levels.channels.length, 24);
  assert.deepEqual((await tableOf(page, "Levels")).map((row) => row.slice(0, 6)), levels.channels.map((of) =>
    [of.channel, of.node, figure(of.mean, 3), figure(of.rms, 3), figure(of.peak, 3), figure(of.seconds, 1)]));
  assert.deepEqual((await tableOf(page, "Conditions")).map((row) => row.slice(0, 3)), levels.wheels.map((of) =>
    [of.wheel.replace("_", " "), figure(of.seconds, 1), figure(of.turns, 1)]));

  for (const wheel of json("orders", second, "--order", "1", "2", "3", "4").wheels)
    assert.deepEqual(await tableOf(page, "Orders", `${wheel.wheel.replace("_", " ")}, heard by node ${wheel.node}`),
      wheel.channels.map((channel) => [channel.channel, ...channel.orders.map((of) => of.amplitude === null ? "–" :
        `${withReach(of.amplitude, of.amplitude_95, 4)}, ${of.phase_deg === null ? "no phase" : `${withReach(of.phase_deg, of.phase_95_deg, 1)}°`}`)]));

  const found = json("identify", second);
  assert.deepEqual((await tableOf(page, "Identification")).map((row) => row.slice(0, 3)), found.wheels.map((of) =>
    [of.name.replace("_", " "), withReach(of.unbalance_g, of.sigma_g, 2), withReach(of.angle_deg, of.sigma_deg, 1)]));
  const kilo = ({value, sigma}, digits) => withReach(value / 1e3, sigma / 1e3, digits);
  assert.deepEqual((await tableOf(page, "Identification", "", "spring, kN/m")).map((row) => row.slice(1)), found.wheels.map((of, w) =>
    [withReach(of.tyre_stiffness_n_m / 1e3, of.sigma_tyre_stiffness_n_m / 1e3, 1), kilo(found.suspension.spring_n_m[w], 2),
     withReach(found.suspension.damper_n_s_m[w].value, found.suspension.damper_n_s_m[w].sigma, 0)]));
  assert.deepEqual((await tableOf(page, "Weights")).map((row) => row[3]), found.compensation.map((of) => figure(of.residual_g, 1)));

  const proof = json("verify", second);
  assert.deepEqual((await tableOf(page, "Proof of completeness")).map((row) => row.map(String).slice(2, 6)), proof.nodes.map((of) =>
    [of.blocks, of.samples_sent, of.samples_recorded, of.samples_missing].map(String)));

  // Where each bin has a place of its own the picture is the density; half a tenth of a unit on paper is what it is rounded to.
  for (const channel of ["fl_carrier_z", "rr_strut_y"]) {
    const spectrum = json("spectrum", second, "--channel", channel);
    const curve = (await curveOf(page, channel)).filter(([hz]) => hz < 15);
    assert.ok(curve.length > 50);
    for (const [hz, density] of curve) {
      const bin = Math.round(hz / spectrum.step_hz);
      assert.ok(Math.abs(hz - bin * spectrum.step_hz) < 0.03 * spectrum.step_hz + 0.003 * hz, `${hz} Hz is no bin`);
      assert.ok(Math.abs(Math.log10(density / spectrum.density[bin])) < 0.03, `${channel} at ${hz} Hz: ${density}, not ${spectrum.density[bin]}`);
    }
    assert.match(await page.locator("figure").filter({has: page.locator(`h4:text-is("${channel}")`)}).innerText(),
      new RegExp(`${spectrum.averages} averages, noise bandwidth ${spectrum.enbw_hz.toFixed(3)} Hz`));
  }

  assert.deepEqual(await weakTexts(page), []);
  await page.emulateMedia({media: "print"});
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 688, "wider than the paper");
  const beyond = await page.evaluate(() => [...document.querySelectorAll("table, figure, svg, p")]
    .filter((one) => one.getBoundingClientRect().right > 689).map((one) => one.textContent.slice(0, 40)));
  assert.deepEqual(beyond, [], "cut at the right");
  await page.screenshot({path: pictureFile("account"), fullPage: true});
  const printed = pages(await page.pdf({preferCSSPageSize: true}));
  // Share of the height that is used; charts and tables that are not cut leave room at the foot of a page.
  const least = await page.evaluate(() => Math.ceil(document.documentElement.scrollHeight / 1032));
  assert.ok(printed >= least && printed <= 2 * least, `${printed} pages for ${least}`);
  await page.close();
});

test("of a damaged recording there is an account, which says what is missing", async (t) => {
  const apart = mkdtempSync(join(tmpdir(), "rb-broken-"));
  t.after(() => rmSync(apart, {recursive: true}));
  const broken = join(apart, "broken"), file = join(apart, "broken.html");
  cpSync(second, broken, {recursive: true});
  const segment = join(broken, "seg-000001.lcm");
  const bytes = readFileSync(segment);
  bytes.fill(0, 20_000_000, 20_300_000);
  writeFileSync(segment, bytes);
  const page = await browser.newPage({viewport: {width: 688, height: 1032}});
  const accountOf = async () => {
    const {status, stderr} = spawnSync(join(process.env.RB_BIN, "rb"), ["report", broken, "-o", file, "--complete"], {encoding: "utf8"});
    await page.goto(`file://${file}`);
    return {status, stderr, said: (await page.locator("body").innerText()).replace(/\s+/g, " ")};
  };
  let {status, said} = await accountOf();
  assert.equal(status, 0);
  assert.match(said, /The recording is damaged/);
  const {nodes} = JSON.parse(spawnSync(join(process.env.RB_BIN, "rb"), ["verify", broken, "--json"], {encoding: "utf8"}).stdout);
  const holes = nodes.flatMap((node) => node.undeclared_scans.map(({first, last}) => [`${node.node}`, `${first}`, `${last - first + 1}`]));
  assert.ok(holes.length > 0);
  assert.deepEqual((await tableOf(page, "Proof of completeness", "", "cause")).map((row) => row.slice(0, 3)), holes);

  // The setup messages of the nodes' begin are gone.
  writeFileSync(segment, bytes.fill(0, 0, 30_000_000));
  let stderr;
  ({status, stderr, said} = await accountOf());
  assert.equal(status, 1, stderr);
  assert.match(said, /Wheel balance: a vehicle that is not known/);
  assert.match(said, /Not known: levels, spectra and orders: the vehicle is not known/);
  assert.match(said, /The recording is damaged/);
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
    [1, 2].every((wheel) => /NO BETTER.*were the weights fitted\?/s.test(document.querySelector(`#wheel-${wheel} .weight-check`)?.innerText ?? "")),
    null, {timeout: 120_000});
  await tells();
  await picture(page, "weight-check-live");
  const gone = new Promise((resolve) => analyser.once("exit", resolve));
  analyser.kill();
  await gone;
  await page.reload();
  analyser = analyse();
  await tells();
});

const kDesk = {width: 1366, height: 768}, kPhone = {width: 390, height: 844};

/** rb-recordings of a folder, and a page of it. */
async function recordingsPage(t, of, {places = [], ...options} = {}) {
  const url = busUrl();
  const {web, where} = await startWeb(url);
  const results = mkdtempSync(join(tmpdir(), "rb-results-"));
  t.after(() => rmSync(results, {recursive: true}));
  const recordings = start("rb-recordings", "--url", url, "--folder", of, ...(places.length > 0 ? places : ["--results", results]));
  const page = await browser.newPage({viewport: kDesk, ...options});
  t.after(async () => {
    await page.close();
    recordings.kill("SIGKILL");
    web.kill();
  });
  await page.goto(where);
  await page.keyboard.press("l");
  return {page, where};
}
const areListed = (page, count) => page.waitForFunction((wanted) => [...document.querySelectorAll(".recording")]
  .filter(({innerText}) => /COMPLETE/.test(innerText)).length === wanted, count, {timeout: 240_000});
const jobSays = (page, recording, job, words) => page.waitForFunction(([name, kind, wanted]) => {
  const card = [...document.querySelectorAll(".recording")].find((each) => each.querySelector("h3").textContent === name);
  return [...card?.querySelectorAll(`.job[data-job="${kind}"]`) ?? []].some(({innerText}) => new RegExp(wanted, "s").test(innerText));
}, [recording, job, words], {timeout: 240_000});
const card = (page, recording) => page.locator(".recording").filter({has: page.locator(`h3:text-is("${recording}")`)});

test("rb-recordings tells the page which recordings there are, with their receipts", async (t) => {
  const {page} = await recordingsPage(t, folder);
  await areListed(page, 2);
  const said = (await page.locator("#recordings").innerText()).replace(/\s+/g, " ");
  // 160 s of two nodes at 2 kHz.
  assert.match(said, /second COMPLETE demonstration car .* 00:02:40 .* 1 320 000 0 \d+ 00:02:40 0\.0 s not known 2 320 000 0/);
  await picture(page, "recordings-live");
});

test("a recording is verified and identified from the page, by keyboard alone, in the words of the command line", async (t) => {
  const {page} = await recordingsPage(t, folder);
  await areListed(page, 2);
  await card(page, "second").locator("button[data-ask=Verify]").focus();
  await page.keyboard.press("Enter");
  await jobSays(page, "second", "Verify", "done.*node 1 epoch .*complete");
  await card(page, "second").locator("button[data-ask=Verify]").focus();
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await jobSays(page, "second", "Identify", "done.*heavy spot");  // its words come behind it
  const shown = await card(page, "second").locator(".job[data-job=Identify] pre").innerText();
  assert.equal(shown, rb("identify", second).trimEnd());
});

for (const [name, options] of [["dark", {colorScheme: "dark"}], ["light", {colorScheme: "light"}],
                               ["phone", {viewport: kPhone, hasTouch: true}]])
  test(`the report of two drives is made on the page and saved, ${name}`, async (t) => {
    const results = mkdtempSync(join(tmpdir(), "rb-results-"));
    t.after(() => rmSync(results, {recursive: true}));
    const {page} = await recordingsPage(t, folder, {acceptDownloads: true, places: ["--results", results], ...options});
    await areListed(page, 2);
    const of = card(page, "second");
    await of.locator("button[data-ask=Report]").click();
    const form = of.locator("form[aria-label='Report of its drive']");
    await form.getByLabel("Compared with").selectOption("first");
    await picture(page, `report-form-${name}`);
    await form.locator("button").click();
    await jobSays(page, "second", "Report", "compared with “first”: done");
    await of.locator("button[data-ask=Verify]").click();
    await jobSays(page, "second", "Verify", "done.*complete");
    const [download] = await Promise.all([page.waitForEvent("download"), of.locator(".job[data-job=Report] button:has-text('Save')").click()]);
    assert.equal(download.suggestedFilename(), "report second.html");
    const file = join(folder, `saved-${name}.html`);
    await download.saveAs(file);
    const printed = join(folder, "printed.html");
    rb("report", second, "--before", first, "-o", printed);
    assert.equal(readFileSync(file, "utf8"), readFileSync(printed, "utf8"));
    // The account of the whole drive: a file, the same as the command line's.
    await of.locator("button[data-ask=Report]").click();
    await form.getByLabel("What").selectOption("yes");
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `report-form-complete-${name}`);
    await form.locator("button").click();
    await jobSays(page, "second", "Report", `complete account, compared with “first”: done.*${results}/second-report.html, \\d+\\.\\d MB`);
    rb("report", second, "--before", first, "--complete", "-o", printed);
    assert.equal(readFileSync(join(results, "second-report.html"), "utf8"), readFileSync(printed, "utf8"));
    assert.deepEqual(await weakTexts(page), []);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${wide} pixels too wide`);
    const small = await of.locator("button, select").evaluateAll((all) => all.filter((each) => each.checkVisibility() &&
      each.getBoundingClientRect().height < 48).map(({innerText}) => innerText));
    assert.deepEqual(small, [], "too small for a finger");
    await of.scrollIntoViewIfNeeded();
    await picture(page, `jobs-${name}`);
  });

/** Tab until the focus is there: what cannot be reached so cannot be used without a mouse. */
async function tabTo(page, what) {
  for (let k = 0; k < 200; ++k) {
    if (await page.evaluate((selector) => document.activeElement?.matches(selector) && document.activeElement.checkVisibility(), what)) return;
    await page.keyboard.press("Tab");
  }
  assert.fail(`${what} cannot be reached by the keyboard`);
}
const isNotTooWide = async (page) => {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `${wide} pixels too wide`);
};
const areLargeEnough = async (of) => assert.deepEqual(await of.locator("button, select, input").evaluateAll((all) => all
  .filter((each) => each.checkVisibility() && each.getBoundingClientRect().height < 48).map(({outerHTML}) => outerHTML)), [], "too small for a finger");

for (const [name, options] of [["night", {colorScheme: "dark"}], ["day", {colorScheme: "light"}], ["phone", {viewport: kPhone, hasTouch: true}]])
  test(`a recording is exported, selected, reduced and transferred from the page by keyboard alone, ${name}`, async (t) => {
    const place = mkdtempSync(join(tmpdir(), "rb-places-"));
    t.after(() => rmSync(place, {recursive: true}));
    const [results, disk] = [join(place, "results"), join(place, "disk")];
    mkdirSync(disk);
    const {page} = await recordingsPage(t, folder, {places: ["--results", results, "--transfer-to", disk], ...options});
    await areListed(page, 2);
    const of = card(page, "second");
    await of.locator("button[data-ask=Verify]").focus();
    await tabTo(page, "button[data-ask=Export]");
    await page.keyboard.press("Enter");
    await tabTo(page, ".panel select");
    await page.keyboard.press("h");
    await page.keyboard.press("Tab");
    await page.keyboard.type("10");
    await page.keyboard.press("Tab");
    await page.keyboard.type("12.5");
    await page.keyboard.press("Tab");
    await page.keyboard.type("front");
    await areLargeEnough(of);
    await isNotTooWide(page);
    assert.deepEqual(await weakTexts(page), []);
    await of.scrollIntoViewIfNeeded();
    await picture(page, `jobs-export-${name}`);
    await page.keyboard.press("Enter");
    await jobSays(page, "second", "Export", `hdf5, from 10 s, to 12.5 s, channels front: done.*${results}/second.h5, \\d+\\.\\d MB`);
    assert.equal(await page.evaluate(() => document.activeElement?.dataset.ask), "Export", "the focus is where it was");
    // 2.5 s of 2 kHz from 10 s on, as a reader that we did not write finds them.
    const read = execFileSync(process.env.RB_SCIPY_PYTHON, ["-c",
      "import h5py, sys; g = h5py.File(sys.argv[1])['all']; t = g['time_s']; print(len(t), round(t[0], 6), round(t[-1], 6))",
      join(results, "second.h5")], {encoding: "utf8"});
    assert.equal(read.trim(), "5000 10.0 12.4995");

    await tabTo(page, "button[data-ask=Select]");
    await page.keyboard.press("Enter");
    await tabTo(page, ".panel input");
    await page.keyboard.type("20");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Tab");
    await page.keyboard.type("30");
    await picture(page, `jobs-select-${name}`);
    await page.keyboard.press("Enter");
    await jobSays(page, "second", "Select", `from 20 s, to 30 s: done.*${results}/second-selected, `);
    await areListed(page, 3);
    assert.match(await card(page, "second-selected").innerText(), new RegExp(`in ${results}.*00:00:10`, "s"));
    // 10 s of two nodes at 2 kHz, all there; of them half as many are left, but for what the filter reaches at both ends.
    const samples = (name) => JSON.parse(rb("verify", join(results, name), "--json")).nodes.map((node) => {
      assert.ok(node.complete);
      return node.samples_recorded;
    });
    assert.deepEqual(samples("second-selected"), [20000, 20000]);

    await of.locator("button[data-ask=Select]").focus();
    await tabTo(page, "button[data-ask=Reduce]");
    await page.keyboard.press("Enter");
    await tabTo(page, ".panel select");
    assert.equal(await page.evaluate(() => document.activeElement.selectedOptions[0].text), "1000 Hz: every 2nd");
    // At 2000 Hz, with a filter of 200 Hz: the rates that rb reduce accepts, and no others.
    assert.deepEqual(await of.locator(".panel:visible option").allTextContents(), ["1000 Hz: every 2nd", "666.666667 Hz: every 3rd", "500 Hz: every 4th"]);
    await picture(page, `jobs-reduce-${name}`);
    await page.keyboard.press("Tab");
    await page.keyboard.press("Enter");
    await jobSays(page, "second", "Reduce", `1000 Hz: done.*${results}/second-reduced-1000Hz, `);
    await areListed(page, 4);
    for (const left of samples("second-reduced-1000Hz")) assert.ok(left <= 160000 && left >= 160000 - 2 * 35, `${left} samples`);

    await of.locator("button[data-ask=Reduce]").focus();
    await tabTo(page, "button[data-ask=Transfer]");
    await page.keyboard.press(" ");
    assert.match(await of.locator(".panel:visible").innerText(), new RegExp(`Copies it to ${disk} and reads the copy back`));
    await tabTo(page, ".panel button");
    await page.keyboard.press("Enter");
    await jobSays(page, "second", "Transfer", `done.*${disk}/second: .*read back and equal`);
    execFileSync("sha256sum", ["--quiet", "-c", "sha256.txt"], {cwd: join(disk, "second")});
    await areLargeEnough(of);
    await isNotTooWide(page);
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `jobs-made-${name}`);
  });

test("what is typed into a recording's form stays with it when a result comes before it in the list", async (t) => {
  const {page} = await recordingsPage(t, folder);
  await areListed(page, 2);
  await card(page, "second").locator("button[data-ask=Reduce]").click();
  await card(page, "second").locator(".panel:visible select").selectOption({label: "500 Hz: every 4th"});
  await card(page, "second").locator(".panel:visible button").click();
  await card(page, "first").locator("button[data-ask=Select]").click();
  await card(page, "first").locator(".panel:visible input").first().fill("17");
  await areListed(page, 3);
  assert.deepEqual(await page.locator(".recording h3").allTextContents(), ["second-reduced-500Hz", "second", "first"]);
  assert.equal(await page.locator(".panel:visible").count(), 1);
  assert.equal(await card(page, "first").locator(".panel:visible input").first().inputValue(), "17");
  assert.equal(await page.evaluate(() => document.activeElement.value), "17", "and the focus");
});

test("where nothing may be transferred to the page says how to allow it, and what rb refuses is said", async (t) => {
  const {page} = await recordingsPage(t, folder);
  await areListed(page, 2);
  const of = card(page, "second");
  await of.locator("button[data-ask=Transfer]").click();
  assert.match(await of.locator(".panel:visible").innerText(), /start rb-recordings with --transfer-to FOLDER/);
  assert.equal(await of.locator(".panel:visible button").isDisabled(), true);
  await of.locator("button[data-ask=Select]").click();
  await of.locator(".panel:visible input[type=text]").fill("middle");
  await of.locator(".panel:visible button").click();
  await jobSays(page, "second", "Select", "channels middle: failed.*middle: no such channel or node; allowed: front rear");
  assert.equal(await of.locator(".job button:text-is('Begin anew')").isVisible(), true);
});

test("a long job shows how far it is, another is refused meanwhile, and it can be cancelled", async (t) => {
  const long = mkdtempSync(join(tmpdir(), "rb-long-"));
  t.after(() => rmSync(long, {recursive: true}));
  mkdirSync(join(long, "long"));
  const segment = join(long, "long", "seg-000001.lcm");
  writeFileSync(segment, "");
  truncateSync(segment, 40e9);  // zeros without a disk: nothing in them is an event
  const hourAgo = Date.now() / 1000 - 3600;
  utimesSync(segment, hourAgo, hourAgo);
  const {page, where} = await recordingsPage(t, long);
  const verify = card(page, "long").locator("button[data-ask=Verify]");
  await verify.click();
  await jobSays(page, "long", "Verify", "under way");
  await page.waitForFunction(() => document.querySelector(".job progress").value > 0, null, {timeout: 60_000});
  assert.ok(await page.evaluate(() => document.querySelector(".job progress").value) < 1);
  await jobSays(page, "long", "Verify", "\\d+ %: \\d+\\.\\d of about 40\\.0 GB read, [0-9.]+ MB/s, about \\d\\d:\\d\\d:\\d\\d left");
  assert.equal(await verify.isDisabled(), true);
  await picture(page, "jobs-running");
  const token = /#token=(.+)$/.exec(where)[1];
  await page.evaluate((secret) => fetch("/request", {method: "POST", headers: {
    "Content-Type": "application/json", "X-Roadbalance-Token": secret},
    body: JSON.stringify({asker: 5, request: 6, operation: "job", value: [1], text: "long"})}), token);
  await card(page, "long").locator("button:text-is('Cancel'):visible").click();
  await jobSays(page, "long", "Verify", "cancelled");
  assert.equal(await page.locator(".job").filter({visible: true}).count(), 1, "the second was not begun");
});

test("without the token nothing can be asked, and the page says why", async (t) => {
  const {page, where} = await recordingsPage(t, folder);
  await page.evaluate(() => sessionStorage.clear());
  await page.goto("about:blank");
  await page.goto(where.replace(/#.*/, ""));
  await page.keyboard.press("l");
  await areListed(page, 2);
  assert.match(await page.locator("#recordings-why").innerText(), /opened without #token=/);
  assert.equal(await card(page, "second").locator("button[data-ask=Verify]").isDisabled(), true);
});
