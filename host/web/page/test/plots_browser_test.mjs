// The plots in a real browser, beside the real rb-web and the analyser's live view; rb-web-plot-scene is the car.
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {after, before, test} from "node:test";
import {busUrl, launch, picture, showsBars, start, startWeb, weakTexts} from "./browser.mjs";

const kDesk = {width: 1366, height: 768}, kPhone = {width: 390, height: 844};
const kThemes = {night: "dark", day: "light"};
const kPlots = ["spectrum", "transfer", "time", "waterfall", "polar", "speed"];
const kTurnsHz = 29 * 2000 / 4096;  // as rb-web-plot-scene

let browser, car, web, where;
before(async () => {
  browser = await launch();
  const url = busUrl();
  car = start("rb-web-plot-scene", url);
  ({web, where} = await startWeb(url));
});
after(async () => {
  await browser?.close();
  car?.kill();
  web?.kill();
});

/** The page with one of the plots; every complaint of the browser fails the test. */
async function open(t, plot, options = {}) {
  const page = await browser.newPage({viewport: kDesk, acceptDownloads: true, ...options});
  const complaints = [];
  page.on("console", (message) => {
    const isOurs = /willReadFrequently/.test(message.text());  // this test looks at pixels
    if (["error", "warning"].includes(message.type()) && !isOurs) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(error.message));
  t.after(async () => {
    await page.close();
    assert.deepEqual(complaints, []);
  });
  await page.goto(where);
  await showsBars(page);
  await page.keyboard.press("p");
  await page.locator(`#plot-${plot}`).click();
  return page;
}
const says = (page, selector, pattern, timeout = 30_000) => page.waitForFunction(
  ([where, wanted]) => new RegExp(wanted).test(document.querySelector(where)?.textContent ?? ""), [selector, pattern.source], {timeout});
const text = (page, selector) => page.locator(selector).innerText();
/** What a plot says when it is drawn from what the scene has sent. */
const kDrawn = {spectrum: ["#spectrum-caption", /[2-9] blocks/], transfer: ["#transfer-caption", /Mean delay/],
                time: ["#time-figure .reading", /fr_carrier_z greatest/], waterfall: ["#waterfall-caption", /amplitude/],
                polar: [".polar:nth-child(4) .polar-text", /40 blocks/], speed: ["#speed-caption", /s of driving used/]};
/** Shows another plot, and what it needs to be seen whole. */
async function turnTo(page, plot) {
  await page.locator(`#plot-${plot}`).click();
  await says(page, ...kDrawn[plot]);
  await drawsMore(page, 2);
}
/** The page has drawn so many times more. */
async function drawsMore(page, times, timeout = 30_000) {
  const from = await page.evaluate(() => Number(document.body.dataset.drawn));
  await page.waitForFunction((end) => Number(document.body.dataset.drawn) >= end, from + times, {timeout});
}

/** What the CSV button saves: {head, rows of numbers}. */
async function table(page) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#plot-csv").click()]);
  const lines = readFileSync(await download.path(), "utf8").trim().split("\r\n");
  return {name: download.suggestedFilename(), head: lines[0].split(","),
          rows: lines.slice(1).map((line) => line.split(",").map((value) => (value === "" ? NaN : Number(value))))};
}
const column = ({head, rows}, pattern) => {
  const at = head.findIndex((name) => pattern.test(name));
  assert.ok(at >= 0, `${pattern} in ${head}`);
  return rows.map((row) => row[at]);
};

test("a spectrum tells the amplitude of a tone and the density of noise, with channel names and units", async (t) => {
  const page = await open(t, "spectrum");
  await says(page, "#spectrum-caption", /[3-9] blocks/);
  assert.match(await text(page, "#spectrum-channels summary"), /fl_carrier_z, fr_carrier_z, rl_carrier_z, rr_carrier_z/);
  const density = await table(page);
  assert.match(density.name, /^roadbalance-spectrum-.*\.csv$/);
  assert.equal(density.head[1], "fl_carrier_z (m/s2)^2/Hz");
  const hz = column(density, /frequency/), front = column(density, /fl_carrier_z/);
  assert.ok(Math.abs(hz[1] - 2000 / 4096) < 1e-6);
  // 1.5 cos: 1.125 m2/s4; noise of 0.25 over 1000 Hz, of which 100 are shown.  The part on the tone's own bin adds to
  // it or takes from it 2 sqrt(1.125 * 2.5e-4 * 0.73) = 0.03 in one block.
  const square = front.reduce((sum, value) => sum + value * hz[1], 0);
  assert.ok(Math.abs(square - (1.125 + 0.025)) < 0.06, `${square}`);
  assert.match(await text(page, "#spectrum-caption"), /Hann window, 4096 samples, 50 % overlap.*0\.488 Hz apart.*noise bandwidth 0\.732 Hz/);

  await page.locator("#plot-spectral summary").click();
  // A picture saved before the next frame shows the old data, and is marked so.
  const [download] = await Promise.all([page.waitForEvent("download"), page.evaluate(() => {
    const quantity = document.querySelector("#spectrum-quantity");
    quantity.value = "peak";
    quantity.dispatchEvent(new Event("change", {bubbles: true}));
    document.querySelector("#plot-csv").click();
  })]);
  const [head, row] = readFileSync(await download.path(), "utf8").split("\r\n").flatMap((line, k) => (k === 0 || k === 60 ? [line.split(",")] : []));
  // Beside the tone, at 28.8 Hz: a density of 2.5e-4, as an amplitude sqrt(2 2.5e-4 0.73) = 0.02.
  assert.equal(Number(row[1]) < 2.5e-3, /Hz/.test(head[1]), `${head[1]}: ${row[1]}`);
  await page.locator("#plot-window").selectOption("2");
  await says(page, "#spectrum-caption", /flat top window.*noise bandwidth 1\.86 Hz.*; [2-9] blocks/);
  const peak = await table(page);
  const most = Math.max(...column(peak, /fl_carrier_z/));
  assert.ok(Math.abs(most - 1.5) < 0.05, `${most}`);  // noise: sqrt(2 2.5e-4 1.86) = 0.03 beside it
  assert.ok(Math.abs(Math.max(...column(peak, /fr_carrier_z/)) - 0.75) < 0.025);
  await picture(page, "plot-spectrum-peak");
});

test("the cursor reads the curves, by mouse and by keys, and the orders of the wheel are marked", async (t) => {
  const page = await open(t, "spectrum");
  await says(page, "#spectrum-caption", /[3-9] blocks/);
  await page.locator("#plot-freeze").click();
  const data = await table(page);
  const over = await page.locator("#spectrum-figure .u-over").boundingBox();
  const hz = column(data, /frequency/);
  const at = over.x + over.width * kTurnsHz / hz.at(-1);
  await page.mouse.move(at, over.y + 100);
  await says(page, "#spectrum-figure .reading", /14\.16 Hz/);
  const said = Number(/fl_carrier_z (\S+)/.exec(await text(page, "#spectrum-figure .reading"))[1]);
  const expected = column(data, /fl_carrier_z/)[29];
  assert.ok(Math.abs(said / expected - 1) < 0.01, `${said} ${expected}`);
  // With the order of 14.16 Hz under the cursor there is the marker's colour.
  const isMarked = await page.evaluate(([x, y]) => {
    const canvas = document.querySelector("#spectrum-figure canvas"), box = canvas.getBoundingClientRect();
    const ctx = canvas.getContext("2d"), scale = canvas.width / box.width;
    const wanted = getComputedStyle(document.documentElement).getPropertyValue("--spot").trim();
    const [r, g, b] = [1, 3, 5].map((k) => parseInt(wanted.slice(k, k + 2), 16));
    const {data: pixels} = ctx.getImageData((x - box.left) * scale - 4, (y - box.top) * scale, 8, 200);
    for (let k = 0; k < pixels.length; k += 4)
      if (Math.abs(pixels[k] - r) + Math.abs(pixels[k + 1] - g) + Math.abs(pixels[k + 2] - b) < 60) return true;
    return false;
  }, [at, over.y + 5]);
  assert.ok(isMarked, "no marker of the first order");
  await page.locator("#spectrum-figure .figure-box").focus();
  const before = await text(page, "#spectrum-figure .reading");
  await page.keyboard.press("Shift+ArrowRight");
  await page.waitForFunction((was) => document.querySelector("#spectrum-figure .reading").innerText !== was, before);
});

test("transfer function, phase, coherence and delay of a pair stand on one axis", async (t) => {
  const page = await open(t, "transfer");
  await says(page, "#transfer-caption", /Mean delay of the output 1\.[45]\d ms/);
  const below = await page.evaluate(() => document.querySelector("#transfer-caption").getBoundingClientRect().bottom - innerHeight);
  assert.ok(below <= 0, `the caption ends ${below} px below the window`);
  const data = await table(page);
  const coherence = column(data, /coherence/), size = column(data, /H1 fl_carrier_z → fr_carrier_z magnitude/);
  const [least, greatest] = [column(data, /95 % from/), column(data, /95 % to/)];
  const input = column(data, /input/), output = column(data, /output/);
  const good = coherence.map((value, k) => [value, k]).filter(([value]) => value > 0.95).map(([, k]) => k);
  assert.ok(good.length > 0.9 * coherence.length, `${good.length} of ${coherence.length}`);
  let inside = 0;
  for (const k of good) {
    assert.ok(Math.abs(size[k] - 0.5) < 0.08, `${size[k]}`);
    inside += least[k] <= 0.5 && 0.5 <= greatest[k] ? 1 : 0;
    assert.ok(Math.abs(output[k] / input[k] - 0.25) < 0.08);
  }
  assert.ok(inside > 0.85 * good.length, `${inside} of ${good.length} bands hold the truth`);
  const lefts = await page.evaluate(() => [...document.querySelectorAll("#transfer-magnitude, #transfer-phase, #transfer-coherence")]
    .map((figure) => figure.querySelector(".u-over").getBoundingClientRect()).map(({left, right}) => [left, right]));
  assert.deepEqual(lefts[1], lefts[0]);
  assert.deepEqual(lefts[2], lefts[0]);
  await page.locator("#transfer-estimator").selectOption("h2");
  await says(page, "#transfer-readings", /H2 fl_carrier_z → fr_carrier_z/);
  await page.locator("#transfer-input").selectOption("1.1");
  await says(page, "#transfer-readings", /fl_carrier_x → fr_carrier_z/);
});

test("time shows the extremes, and a hole where samples are missing", async (t) => {
  const page = await open(t, "time");
  await says(page, "#time-figure .reading", /fr_carrier_z greatest/);
  await page.locator("#time-channels summary").click();
  await page.locator("#time-channels [data-key='2.3']").click();  // rl_carrier_z, whose node lacks half a second each 8 s
  await page.locator("#time-channels summary").click();
  await page.waitForFunction(() => document.querySelector("#time-channels summary").textContent.includes("rl_carrier_z"));
  // Half a second each 8 s; one may be under way.  The live view may lose a block besides, on a computer that has else to do.
  const holesOf = (rear) => rear.map((value) => (Number.isNaN(value) ? "-" : "x")).join("").match(/(?<=x)-+(?=x)/g) ?? [];
  const isHole = ({length}) => length >= 48 && length <= 53;  // times 10 ms
  let data, high, known = [], holes = [];
  for (let k = 0; k < 30 && !(holes.some(isHole) && known.length > 500); ++k) {
    await drawsMore(page, 20);
    data = await table(page);
    high = column(data, /fl_carrier_z greatest/);
    known = high.filter((value) => !Number.isNaN(value));
    holes = holesOf(column(data, /rl_carrier_z greatest/));
  }
  const times = column(data, /time_s/), low = column(data, /fl_carrier_z least/);
  assert.ok(known.length > 500, `${known.length}`);
  assert.ok(Math.max(...known) > 1.8 && Math.max(...known) < 4.5, `${Math.max(...known)}`);  // 1.5 + up to 5 sigma of 0.5
  assert.ok(high.every((value, k) => Number.isNaN(value) || value >= low[k]));
  assert.ok(times.at(-1) <= 0 && times[0] >= -10.1, `${times[0]} .. ${times.at(-1)}`);
  assert.ok(holes.some(isHole), `of ${holes.map(({length}) => length)} times 10 ms`);
  await picture(page, "plot-time-hole");
});

test("orders over speed stand at their order and in the class of their speed", async (t) => {
  const page = await open(t, "waterfall");
  await says(page, "#waterfall-caption", /fl_carrier_z, front left wheel: amplitude/);
  const data = await table(page);
  const kmh = data.head.at(-1).match(/([\d.]+)\.\.([\d.]+) km\/h/).slice(1).map(Number);
  // 14.16 turns a second on wheels of 0.31 m or so.
  assert.ok(kmh[0] > 80 && kmh[1] < 120, `${kmh}`);
  const order = column(data, /^order/), size = column(data, /km\/h/);
  const first = order.findIndex((value) => Math.abs(value - 1) < 1e-9);
  assert.ok(Math.abs(size[first] - 1.5) < 0.1, `${size[first]}`);
  assert.ok(size[2 * first] < 0.2);
  await page.locator("#waterfall-plot canvas").focus();
  await page.keyboard.press("ArrowRight");
  await says(page, "#waterfall-reading", /order 1\.031 at/);
});

test("polar shows the vector of each wheel with what holds it with 95 %", async (t) => {
  const page = await open(t, "polar");
  await says(page, ".polar:nth-child(1) .polar-text", /fl_carrier_z: 1\.5 ± 0\.075 m\/s², 40\.0° ± 2\.9° \(95 %\), 40 blocks/);
  assert.match(await text(page, ".polar:nth-child(2) .polar-text"), /fr_carrier_z: 0\.75 ± 0\.075/);
  assert.match(await text(page, ".polar:nth-child(4) .polar-text"), /rr_carrier_z: 0\.375 ± 0\.075 m\/s², its phase is not known, 40 blocks/);
  // The arrow points where 40 degrees are: right and up.
  const isThere = await page.evaluate(() => {
    const canvas = document.querySelector(".polar canvas"), scale = canvas.width / 300;
    const wanted = getComputedStyle(document.documentElement).getPropertyValue("--curve-1").trim();
    const rgb = [1, 3, 5].map((k) => parseInt(wanted.slice(k, k + 2), 16));
    const at = (degrees) => {
      const [x, y] = [150 + 40 * Math.cos(degrees * Math.PI / 180), 150 - 40 * Math.sin(degrees * Math.PI / 180)];
      const pixel = canvas.getContext("2d").getImageData(x * scale, y * scale, 1, 1).data;
      return rgb.every((value, k) => Math.abs(value - pixel[k]) < 40);
    };
    return [at(40), at(-40), at(140)];
  });
  assert.deepEqual(isThere, [true, false, false]);
});

test("speed classes tell how long the car was driven in each, and the wheels how they turn", async (t) => {
  const page = await open(t, "speed");
  await says(page, "#speed-caption", /100 s of driving used/);
  const rows = await page.locator("#speed-classes tbody tr").allInnerTexts();
  assert.deepEqual(rows.map((row) => row.trim().split(/\s+/).slice(0, 3)), [["90.0", "60", "60"], ["100.8", "10", "10"], ["111.6", "30", "30"]]);
  await page.keyboard.press("u");
  await says(page, "#speed-classes", /Speed, mph.*55\.960/);  // 25 m/s, 60 s
  await page.keyboard.press("u");
  await says(page, "#speed-wheels", /front left14\.160\.00 %115°/);
});

test("frozen it stands still, and goes on", async (t) => {
  const page = await open(t, "time");
  await says(page, "#time-figure .reading", /greatest/);
  await page.keyboard.press("f");
  await says(page, "#plot-freeze", /FROZEN/);
  const first = await table(page);
  await drawsMore(page, 20);
  assert.deepEqual((await table(page)).rows, first.rows);
  await picture(page, "plot-frozen");
  await page.keyboard.press("f");
  await drawsMore(page, 10);
  assert.notDeepEqual((await table(page)).rows, first.rows);
});

test("frozen it changes its colours with the theme", async (t) => {
  for (const [plot, canvas, name] of [["spectrum", "#spectrum-figure canvas", "--grid"], ["waterfall", "#waterfall-plot canvas", "--ground"],
                                      ["polar", ".polar canvas", "--card"]]) {
    const page = await open(t, plot, {colorScheme: "dark"});
    if (plot === "spectrum") await says(page, "#spectrum-caption", /\d blocks/);
    if (plot === "waterfall") await says(page, "#waterfall-caption", /amplitude/);
    await page.keyboard.press("f");
    const colour = () => page.evaluate((of) => {
      const hex = getComputedStyle(document.documentElement).getPropertyValue(of).trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
      return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
    }, name);
    const painted = (rgb) => page.evaluate(([where, wanted]) => {
      const one = document.querySelector(where);
      const {data} = one.getContext("2d").getImageData(0, 0, one.width, one.height);
      let count = 0;
      for (let k = 0; k < data.length; k += 4)
        if (data[k + 3] === 255 && wanted.every((value, c) => data[k + c] === value)) ++count;
      return count;
    }, [canvas, rgb]);
    const night = await colour();
    assert.ok(await painted(night) > 100, `${plot} by night`);
    await page.keyboard.press("n");
    const day = await colour();
    assert.notDeepEqual(day, night);
    assert.ok(await painted(day) > 100, `${plot} by day`);
    assert.equal(await painted(night), 0, `${plot} is still of the night`);
  }
});

test("what was plotted is kept beside what comes, until it is dropped", async (t) => {
  const page = await open(t, "spectrum");
  await says(page, "#spectrum-caption", /[2-9] blocks/);
  await page.keyboard.press("f");  // between reading and keeping nothing new comes
  const kept = column(await table(page), /fl_carrier_z/);
  await page.keyboard.press("c");
  await page.keyboard.press("f");
  await says(page, "#spectrum-figure .reading", /fl_carrier_z \(reference\)/);
  await says(page, "#spectrum-caption", /\d\d blocks/);
  const after_ = await table(page);
  const reference = column(after_, /fl_carrier_z \(reference\)/);
  assert.deepEqual(reference, kept);
  assert.notEqual(column(after_, /^fl_carrier_z \(m/)[40], reference[40]);
  await picture(page, "plot-reference");
  // In the unit that is shown, also when the plot was left meanwhile.
  await page.keyboard.press(".");
  await page.keyboard.press(",");
  await page.locator("#spectrum-quantity").selectOption("rms");
  await drawsMore(page, 2);
  await says(page, "#spectrum-figure .reading", /reference/);
  const rms = column(await table(page), /fl_carrier_z \(reference\)/);
  assert.ok(Math.abs(rms[29] / Math.sqrt(reference[29] * 1.5 * 2000 / 4096) - 1) < 1e-6, `${rms[29]}`);
  await page.locator("#spectrum-figure .figure-box").focus();
  await page.keyboard.press("c");
  await page.waitForFunction(() => !document.querySelector("#spectrum-figure .reading").textContent.includes("reference"));
});

test("the picture holds the plot and what it says", async (t) => {
  for (const plot of ["spectrum", "transfer", "polar"]) {
    const page = await open(t, plot);
    if (plot === "spectrum") await says(page, "#spectrum-caption", /[2-9] blocks/);
    if (plot === "transfer") await says(page, "#transfer-caption", /Mean delay/);
    if (plot === "polar") await says(page, ".polar-text", /1\.5 ±/);
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#plot-picture").click()]);
    const path = `${process.env.RB_PAGE_PICTURES}/saved-${plot}.png`;
    await download.saveAs(path);
    const bytes = readFileSync(path);
    assert.equal(bytes.subarray(1, 4).toString(), "PNG");
    assert.ok(bytes.readUInt32BE(16) >= 600 && bytes.readUInt32BE(20) >= 300);
    assert.ok(bytes.length > 10_000, `${bytes.length}`);
  }
});

test("only what is seen is asked for, and each page gets its own", async (t) => {
  const views = [];
  const page = await browser.newPage({viewport: kDesk});
  t.after(() => page.close());
  page.on("request", (request) => { if (request.url().endsWith("/view")) views.push(request.postDataBuffer().length); });
  await page.goto(where);
  await showsBars(page);
  assert.deepEqual(views, []);
  await page.keyboard.press("p");
  await page.locator("#plot-spectrum").click();
  await says(page, "#spectrum-caption", /[2-9] blocks/);
  const other = await open(t, "spectrum");
  await other.locator("#plot-spectral summary").click();
  assert.deepEqual(await other.locator("#plot-block option").evaluateAll((options) => options.map(({value}) => Number(value))),
                   [1024, 2048, 4096, 8192, 16_384, 32_768, 65_536]);
  await other.locator("#plot-block").selectOption("65536");
  await says(other, "#spectrum-caption", /fl_carrier_z: not yet: a block of 65536 samples.*full first, 32\.8 s/);
  await other.locator("#plot-block").selectOption("1024");
  await says(other, "#spectrum-caption", /1024 samples.*1\.95 Hz apart/);
  assert.match(await text(page, "#spectrum-caption"), /4096 samples.*0\.488 Hz apart/);
  await page.keyboard.press("b");
  const asked = views.length;
  await page.waitForTimeout(2500);
  assert.equal(views.length, asked);
});

test("says that it is old when the analyser falls silent", async (t) => {
  const url = busUrl();
  const mortal = start("rb-web-plot-scene", url);
  const {web: its, where: there} = await startWeb(url);
  const page = await browser.newPage({viewport: kDesk});
  t.after(() => { mortal.kill(); its.kill(); return page.close(); });
  await page.goto(there);
  await showsBars(page);
  await page.keyboard.press("p");
  await page.locator("#plot-time").click();
  await says(page, "#time-figure .reading", /greatest/);
  assert.equal(await text(page, ".plots > .trouble"), "");
  mortal.kill("SIGKILL");
  await says(page, ".plots > .trouble", /OLD: no analyser is heard/);
  await picture(page, "plot-old");
});

test("every plot is worked by keys alone", async (t) => {
  const page = await open(t, "spectrum");
  await page.locator("#plot-spectral summary").click();
  for (const plot of [...kPlots.slice(1), "spectrum"]) {
    await page.keyboard.press(".");
    assert.equal(await page.locator(`#plot-${plot}`).getAttribute("aria-pressed"), "true", plot);
  }
  const reached = new Set();
  for (let k = 0; k < 45; ++k) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.className || document.activeElement.tagName));
  }
  for (const id of [...kPlots.map((plot) => `plot-${plot}`), "plot-freeze", "plot-compare", "plot-picture", "plot-csv", "plot-window",
                    "plot-block", "plot-overlap", "plot-average", "plot-highest", "SUMMARY", "spectrum-quantity", "spectrum-orders", "figure-box"])
    assert.ok(reached.has(id), `${id} among ${[...reached].join(" | ")}`);
});

/** Nothing is wider than the window, and what can be pressed is large enough for a finger. */
async function fits(page, plot) {
  const {wide, window} = await page.evaluate(() => ({wide: document.documentElement.scrollWidth, window: innerWidth}));
  assert.ok(wide <= window, `${plot}: ${wide} in ${window}`);
  const small = await page.evaluate(() => [...document.querySelectorAll("button, select, summary")].filter((one) => {
    const {width, height} = one.getBoundingClientRect();
    return one.checkVisibility() && (width < 48 || height < 48);
  }).map((one) => one.textContent));
  assert.deepEqual(small, [], "too small for a finger");
}

for (const [theme, colorScheme] of Object.entries(kThemes))
  test(`can be read by ${theme} and fits a small window: every plot`, async (t) => {
    const page = await open(t, "spectrum", {colorScheme});
    for (const plot of kPlots) {
      await turnTo(page, plot);
      await fits(page, plot);
      if (plot === "spectrum") await page.locator("#spectrum-channels summary").click();
      await picture(page, `plot-${plot}-${theme}`);
      assert.deepEqual(await weakTexts(page), [], plot);
      // Text on a canvas has the colour of a text, or of one of the curves: as strong.
      const weak = await page.evaluate(() => {
        const style = getComputedStyle(document.documentElement);
        const light = (name) => {
          const hex = style.getPropertyValue(name).trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
          const [r, g, b] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255)
            .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
          return 0.2126 * r + 0.7152 * g + 0.0722 * b;
        };
        const contrast = (a, b) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        return ["--text", "--quiet", "--spot", ...[1, 2, 3, 4, 5, 6].map((k) => `--curve-${k}`)]
          .flatMap((name) => ["--ground", "--card"].map((ground) => [name, ground, contrast(light(name), light(ground))]))
          .filter(([, , value]) => value < 4.5);
      });
      assert.deepEqual(weak, []);
    }
  });

test("fits a phone: every plot", async (t) => {
  const page = await open(t, "spectrum", {viewport: kPhone, hasTouch: true});
  for (const plot of kPlots) {
    await turnTo(page, plot);
    await picture(page, `plot-${plot}-phone`);
    await fits(page, plot);
  }
});

test("the browser's memory is flat while the plots go on", async (t) => {
  const page = await open(t, "time");
  await says(page, "#time-figure .reading", /greatest/);
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Performance.enable");
  const heap = async () => {
    await cdp.send("HeapProfiler.collectGarbage");
    const {metrics} = await cdp.send("Performance.getMetrics");
    return metrics.find(({name}) => name === "JSHeapUsedSize").value;
  };
  await drawsMore(page, 60);
  // A leak shows in each of them; a cache that fills, or a late collection, in one.
  const grown = [];
  for (let before = await heap(); grown.length < 3 && !grown.some((bytes) => bytes < 500_000);) {
    await drawsMore(page, 150, 90_000);
    const now = await heap();
    grown.push(now - before);
    before = now;
  }
  assert.ok(Math.min(...grown) < 500_000, `${grown} B in 150 frames each`);
});
