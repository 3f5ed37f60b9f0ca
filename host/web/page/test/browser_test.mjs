// The page in a real browser, beside the real rb-web; rb-web-scene is the car.
import assert from "node:assert/strict";
import {mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {busUrl, launch, pages, picture, showsBars, start, startWeb, weakTexts, tooSmall} from "./browser.mjs";

const kDesk = {width: 1366, height: 768}, kPhone = {width: 390, height: 844};
const kThemes = {night: "dark", day: "light"};

let browser;
const scenes = {};
before(async () => {
  browser = await launch();
  for (const scene of ["known", "armed", "unknown", "checked", "trouble", "disk away"]) {
    const url = busUrl();
    scenes[scene] = {car: start("rb-web-scene", url, scene), ...await startWeb(url)};
  }
});
after(async () => {
  await browser?.close();
  for (const {car, web} of Object.values(scenes)) {
    car.kill();
    web.kill();
  }
});

/** A page that shows the scene; every complaint of the browser fails the test. */
async function open(t, scene, options = {}) {
  const page = await browser.newPage({viewport: kDesk, ...options});
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(error.message));
  t.after(async () => {
    await page.close();
    assert.deepEqual(complaints, []);
  });
  await page.goto(scenes[scene].where);
  await showsBars(page);
  return page;
}
const text = (page, selector) => page.locator(selector).innerText().then((found) => found.replace(/\s+/g, " "));
/** All views that there are. */
const viewsOf = (page) => page.evaluate(() => [...document.querySelectorAll("[role=tab]")].map((tab) =>
  ({id: tab.getAttribute("aria-controls"), key: tab.getAttribute("aria-keyshortcuts")})).concat({id: "driver", key: "d"}));
const light = (page, lamp) => page.locator(`#lamp-${lamp}`).getAttribute("data-light");

test("no bar is ever without its number", async (t) => {
  const page = await open(t, "known");
  const numbers = await page.locator(".bar .value").allTextContents();
  assert.equal(numbers.length, 24);
  assert.ok(numbers.every((number) => number !== ""), numbers.join(" "));
});

test("says in one word whether everything is recorded", async (t) => {
  const page = await open(t, "known");
  assert.equal(await text(page, "#state"), "RECORDING 01:23:45");
  assert.equal(await text(page, ".amounts"), "Autobahn · 4.56 GB · 5.5 h left");
  for (const lamp of ["LOSS", "SYNC", "OVERLOAD", "ENCODER"]) assert.equal(await light(page, lamp), "good", lamp);
  assert.equal(await text(page, "#lamp-LOSS .number"), "0 lost, 6 repaired");
  assert.equal(await text(page, "#lamp-SYNC .number"), "12 µs");
});

test("places heavy spot and weight right on both sides of the car", async (t) => {
  const page = await open(t, "known");
  // Seen from outside driving forward a left wheel turns counter-clockwise: 12 - 217/30 = 4:46, 12 - 37/30 = 10:46;
  // a right one clockwise: 217/30 = 7:14, 37/30 = 1:14.
  assert.match(await text(page, "#wheel-1"), /Clip 35 g at 37° \(clock 10:46\) on the outer flange\..*Heavy spot at 217° \(clock 4:46\), 35\.0 g/);
  assert.match(await text(page, "#wheel-2"), /Stick 35 g at 37° \(clock 1:14\) in the inner plane\. 123 mm ahead of the valve; behind the wheel.*Heavy spot at 217° \(clock 7:14\), 35\.0 g/);
  // And on the drawing: 4:46 is below and to the right of the hub, 7:14 below and to the left; weights opposite.
  for (const [card, right] of [[1, 1], [2, -1]]) {
    const {hub, spot, weight} = await page.evaluate((id) => {
      const centre = (selector) => {
        const {left, right, top, bottom} = document.querySelector(`#wheel-${id} ${selector}`).getBoundingClientRect();
        return {x: (left + right) / 2, y: (top + bottom) / 2};
      };
      return {hub: centre(".rim"), spot: centre(".spot"), weight: centre(".weight")};
    }, card);
    const angle = (a) => Math.atan2(right * (a.x - hub.x), -(a.y - hub.y)) * 180 / Math.PI;  // clockwise from 12, mirrored
    assert.ok(Math.abs(angle(spot) - 143) < 1.5, `spot of wheel ${card} at ${angle(spot)}`);
    assert.ok(Math.abs(angle(weight) + 37) < 1.5, `weight of wheel ${card} at ${angle(weight)}`);
  }
});

test("says what to do with weights that are on the wheel, and when they will not help", async (t) => {
  const page = await open(t, "known");
  assert.match(await text(page, ".legend"), /□ behind the wheel ■ red dashed: take off/);
  assert.match(await text(page, "#wheel-3"), /WEIGHTS WILL NOT CURE THIS: force that does not grow with speed/);
  assert.match(await text(page, "#wheel-3"), /Move the 20 g clip from 30° \(clock 11:00\) on the outer flange to 90° \(clock 9:00\) on the inner flange\. to 298 mm ahead of the valve; behind the wheel Remove the 5 g clip at 200° \(clock 5:20\) on the outer flange/);
  assert.match(await text(page, "#wheel-4"), /Leave it: the unbalance is within its own uncertainty/);
  assert.match(await text(page, "#wheel-1"), /leaves 2\.6 g \(49 g·cm\), within the 7 g that a shop leaves/);
});

test("shows how far each wheel is from the wanted sigma, and what the estimates rest on", async (t) => {
  const page = await open(t, "known");
  assert.match(await text(page, "#wheel-1"), /42 s more for ± 2 g/);
  assert.match(await text(page, "#wheel-2"), /done: better than ± 2 g/);
  assert.match(await text(page, "#wheel-3"), /± 2 g is wanted; driving on like this does not reach it/);
  // 280 s of 322.
  assert.equal(await page.locator("#wheel-1 .ring").textContent(), "86%");
  assert.equal(await page.locator("#wheel-2 .ring").getAttribute("data-done"), "true");
  assert.match(await text(page, "#remarks"), /The scale of grams and N\/m rests on the wheels' masses.*Static unbalance only/);
});

test("tells a place on the rim by degrees, clock and ruler, and what is left in g, g·cm and at the seats", async (t) => {
  const page = await open(t, "known");
  // 37 degrees of a circle of 190 mm: 122.7 mm.
  assert.match(await text(page, "#wheel-1"), /Clip 35 g at 37° \(clock 10:46\) on the outer flange\. 123 mm ahead of the valve/);
  // 200 degrees are 160 the other way: 530.6 mm.
  assert.match(await text(page, "#wheel-3"), /Remove the 5 g clip at 200° \(clock 5:20\) on the outer flange\. 531 mm behind the valve/);
  assert.match(await text(page, "#wheel-1"), /leaves 2\.6 g \(49 g·cm\), within.*At the seats 0\.052 → 0\.0043 m\/s²/);
});

test("says what to do while nothing is known", async (t) => {
  const page = await open(t, "unknown");
  assert.match(await text(page, "#wheel-1"), /18 s at a steady speed, 42 s more for a first estimate/);
  assert.match(await text(page, "#wheel-4"), /speed up to 115 km\/h or more/);
  assert.equal(await page.locator("#wheel-1 .ring").textContent(), "30%");
  await page.keyboard.press("d");
  assert.match(await text(page, "#driver"), /18 s at a steady speed, 42 s more/);
});

test("tells what weights have done, and which mistake was made", async (t) => {
  const page = await open(t, "checked");
  assert.match(await text(page, "#wheel-1"), /Before 35\.0 g, now 2\.0 g: 94 % less, ± 4 %\. GOOD.*changed as the weights should/);
  assert.match(await text(page, "#wheel-2"), /WORSE than before.*MIRRORED at the valve/);
  assert.match(await text(page, "#wheel-3"), /AT the heavy spot/);
  assert.match(await text(page, "#wheel-4"), /NO BETTER.*were the weights fitted\?/);
  // The state is the analyser's: a reload loses nothing.
  await page.reload();
  await page.waitForFunction(() => /GOOD/.test(document.querySelector("#wheel-1")?.innerText ?? ""));
});

test("has a view for the driver with nothing to press, left by Escape or a tap", async (t) => {
  const page = await open(t, "known");
  for (const leave of [() => page.keyboard.press("Escape"), () => page.locator("#driver").click()]) {
    await page.keyboard.press("d");
    assert.match(await text(page, "#driver"), /RECORDING 01:23:45 Drive on like this: 42 s more\./);
    assert.equal(await page.locator("button:visible, a:visible, input:visible, select:visible").count(), 0);
    const {high, window} = await page.evaluate(() => ({high: document.documentElement.scrollHeight, window: innerHeight}));
    assert.ok(high <= window, `${high} in ${window}: it would have to be scrolled`);
    await leave();
    assert.equal(await page.locator("#balance").isVisible(), true);
  }
});

test("keeps units as its person likes them", async (t) => {
  const page = await open(t, "known");
  await page.keyboard.press("u");
  await page.waitForFunction(() => /Clip 1\.23 oz at 37° \(clock 10:46\) on the outer flange\. 4\.8 in ahead/.test(document.querySelector("#wheel-1").innerText.replace(/\s+/g, " ")));
  assert.match(await text(page, "#levels"), /69 mph/);
  await page.reload();
  await page.waitForFunction(() => /1\.23\soz/.test(document.querySelector("#wheel-1")?.innerText ?? ""));
});

const rowsOf = (page) => page.locator("#setup tbody").first().locator("tr")
  .evaluateAll((all) => all.map(({innerText}) => innerText.replace(/\s+/g, " ")));

test("shows what is wired how, what a knock has proven, and whether all is ready", async (t) => {
  const page = await open(t, "known");
  await page.keyboard.press("s");
  await page.waitForFunction(() => document.querySelectorAll("#setup .checks li").length === 7);
  const checks = await page.locator("#setup .checks li").evaluateAll((lines) => lines.map(({dataset, innerText}) => `${dataset.ready} ${innerText.replace(/\s+/g, " ")}`));
  assert.match(checks.join("\n"), /yes OK Nodes 1 front, 2 rear/);
  assert.match(checks.join("\n"), /yes OK Vehicle file demonstration car: the same on all nodes/);
  assert.match(checks.join("\n"), /yes OK Channels All 24 are alive/);
  assert.match(checks.join("\n"), /unknown not known Directions .*1\.11 left_6 and 1\.12 right_6; 2\.11 left_6 and 2\.12 right_6/);
  assert.match((await rowsOf(page))[23], /2\.12 right_6 .* not yet/, "nobody has said what is knocked on");
  await page.selectOption("#tap-channel", {label: "1.1 left_1"});
  await page.waitForFunction(() => /2\.12 right_6.*Proves nothing: it is not what was chosen/.test(document.querySelector("#knock").innerText));
  await page.selectOption("#tap-channel", {label: "2.12 right_6"});
  await page.waitForFunction(() => /by knock/.test(document.querySelector("#setup").innerText));
  // The upward knock came with a minus sign from a sensor that is described as pointing down.
  assert.match(await text(page, "#knock"), /2\.12 right_6: first swing −4\.0 m\/s²\. Right, if it came from below, upwards\./);
  const rows = await rowsOf(page);
  assert.equal(rows.length, 24);
  assert.match(rows[23], /2\.12 right_6 body down from below, upwards 50 .* ✓ by knock/);
  assert.match(rows[0], /1\.1 left_1 front left up from below, upwards 200 2\.3842e-5 0 0 0\.20 not yet/);
  assert.match(await text(page, "#setup"), /rb datum --wheel front_left --before DRIVE1/);
});

test("says what is not ready, and what to do", async (t) => {
  const page = await open(t, "trouble");
  await page.keyboard.press("s");
  await page.selectOption("#tap-channel", {label: "2.2 right_1"});
  await page.waitForFunction(() => /WRONG SIGN/.test(document.querySelector("#setup")?.innerText ?? ""));
  const said = await text(page, "#setup");
  assert.match(said, /TO DO Channels 1\.3 left_2 is beyond its range; 1\.5 left_3 carries no signal/);
  assert.match(said, /TO DO Directions 2\.2 right_1: the knock came with the wrong sign/);
  assert.match(said, /TO DO Disk/);
});

test("lists recordings with their receipts, and can delete none", async (t) => {
  const page = await open(t, "trouble");
  await page.keyboard.press("l");
  await page.waitForFunction(() => document.querySelectorAll(".recording").length === 3);
  const said = await text(page, "#recordings");
  assert.match(said, /drive-0 being written/);
  assert.match(said, /drive-1 COMPLETE .* Complete\. Every CRC is right\..*3 600 000 0 3 00:30:00 0\.0 s 12 µs.*weights fitted/);
  assert.match(said, /drive-2 DAMAGED .* 2 blocks with a wrong CRC/);
  assert.equal(await page.locator("#recordings a").count(), 0);
  assert.deepEqual([...new Set(await page.locator("#recordings button").allTextContents())].sort(),
                   ["Begin: export", "Begin: reduce", "Begin: report", "Begin: select", "Begin: transfer", "Export", "Identify", "Reduce", "Report", "Select",
                    "Transfer", "Verify"]);
});

test("a mark beyond those that are told is chosen by its number", async (t) => {
  const page = await open(t, "armed");
  await page.keyboard.press("l");
  await page.waitForFunction(() => document.querySelectorAll(".recording").length === 3);
  const of = page.locator(".recording").filter({has: page.locator("h3:text-matches('drive-2$')")});
  await of.locator("button[data-ask=Select]").click();
  const from = of.locator(".panel:visible select").first(), number = of.locator(".panel:visible input[placeholder='its number']");
  assert.equal((await from.locator("option").allTextContents()).at(-1), "one of the other 3: by its number");
  assert.equal(await number.filter({visible: true}).count(), 0);
  await from.selectOption({label: "one of the other 3: by its number"});
  assert.equal(await number.filter({visible: true}).count(), 1);
  await of.locator(".panel:visible button[type=submit]").click();
  assert.equal(await of.locator(".panel").filter({visible: true}).count(), 1, "it waits for the number");
  await number.first().fill("8");
  const asked = page.waitForRequest((request) => request.method() === "POST");
  await of.locator(".panel:visible button[type=submit]").click();
  assert.match(JSON.parse((await asked).postData()).text, /drive-2\/from-mark=8$/);
});

test("does not say that a recording is being written when nobody says so any more", async (t) => {
  const url = busUrl(), car = start("rb-web-scene", url, "known"), {web, where} = await startWeb(url);
  const page = await browser.newPage({viewport: kDesk});
  t.after(async () => {
    await page.close();
    car.kill();
    web.kill();
  });
  await page.goto(where);
  await page.keyboard.press("l");
  await page.waitForFunction(() => /being written/.test(document.querySelector(".recording .word")?.innerText ?? ""));
  car.kill();
  await page.waitForFunction(() => /rb-recordings has been silent for 00:00:1/.test(document.querySelector("#recordings").innerText));
  assert.equal(await page.locator(".recording .word").first().innerText(), "was being written");
  // Nor is what is old harder to read.
  for (const key of ["b", "p", "l"]) {
    await page.keyboard.press(key);
    if (key === "b") await page.waitForFunction(() => document.querySelectorAll(".node[data-old=true]").length === 2);
    if (key === "p") await page.waitForFunction(() => /OLD/.test(document.querySelector("#plots").innerText));
    assert.deepEqual(await weakTexts(page), [], key);
    await picture(page, `old-${key}`);
  }
});

for (const colorScheme of ["dark", "light"])
  test(`says how old the balance of a car that drives on without an analyser is, ${colorScheme}`, async (t) => {
    const url = busUrl(), cars = [start("rb-web-scene", url, "known")], {web, where} = await startWeb(url);
    const page = await browser.newPage({viewport: kDesk, colorScheme});
    t.after(async () => {
      await page.close();
      for (const program of [...cars, web]) program.kill();
    });
    await page.goto(where);
    await page.waitForFunction(() => document.querySelectorAll(".wheel[data-known=true]").length === 4);
    assert.doesNotMatch(await text(page, ".balance"), /OLD/);
    cars[0].kill();
    cars.push(start("rb-web-scene", url, "unanalysed"));
    await page.waitForFunction(() => document.querySelectorAll(".card[data-old=true]").length === 4);
    for (const wheel of [1, 2, 3, 4]) {
      // It counts on; what was known is not hidden.
      const age = await text(page, `#wheel-${wheel} .age`);
      const [, seconds] = /^OLD: from 00:00:(\d\d) ago$/.exec(age) ?? assert.fail(age);
      assert.ok(Number(seconds) >= 3, age);
      await page.waitForFunction(([card, before]) => document.querySelector(card).innerText > before, [`#wheel-${wheel} .age`, age]);
      assert.match(await text(page, `#wheel-${wheel}`), /clock|Leave it/);
    }
    assert.deepEqual(await weakTexts(page), []);
    await picture(page, `old-balance-${colorScheme}`);
    cars[1].kill();
    cars.push(start("rb-web-scene", url, "known"));
    await page.waitForFunction(() => document.querySelectorAll(".card[data-old=true]").length === 0 &&
      !/OLD/.test(document.querySelector(".balance").innerText));
  });

test("gives the reason of what is not known, and no angle", async (t) => {
  const page = await open(t, "unknown");
  for (const [card, reason] of [[1, "42 s more for a first estimate"], [2, "change lanes or take a bend"], [3, "has no angle"],
                                [4, "speed up to 115"]]) {
    const said = await text(page, `#wheel-${card}`);
    assert.match(said, new RegExp(`Not known: .*${reason}`));
    assert.doesNotMatch(said, /clock/);
    assert.equal(await page.locator(`#wheel-${card} .spot`).isVisible(), false);
  }
});

test("says what is wrong and what to do about it", async (t) => {
  const page = await open(t, "trouble");
  assert.equal(await text(page, "#state"), "FAULT");
  assert.match(await text(page, "header"), /The disk is full\. .* make space/);
  assert.deepEqual(await Promise.all(["LOSS", "SYNC", "OVERLOAD", "ENCODER"].map((lamp) => light(page, lamp))),
                   ["bad", "warn", "bad", "bad"]);
  await page.locator("#lamp-LOSS").click();
  await page.waitForFunction(() => /80 samples are lost for good in node 1, node 2/.test(document.body.innerText));
  // A lamp that is opened, on small windows too.
  for (const [name, viewport] of [["day", kDesk], ["phone", kPhone], ["phone-night", kPhone], ["night", kDesk]]) {
    await page.setViewportSize(viewport);
    if (name === "phone-night") await page.keyboard.press("n");
    await picture(page, `lamp-open-${name}`);
    assert.deepEqual(await weakTexts(page), [], name);
    const {wide, window} = await page.evaluate(() => ({wide: document.documentElement.scrollWidth, window: innerWidth}));
    assert.ok(wide <= window, `${name}: ${wide} in ${window}`);
    const list = await page.evaluate(() => {
      const {scrollWidth, clientWidth} = document.querySelector(".events");
      return {scrollWidth, clientWidth};
    });
    assert.ok(list.scrollWidth <= list.clientWidth, `${name}: events ${list.scrollWidth} in ${list.clientWidth}`);
  }
  // The events: time, node, remedy.
  const events = await page.locator(".events li").allInnerTexts();
  assert.equal(events.length, 2);
  for (const [k, event] of events.sort().entries())
    assert.match(event.replace(/\s+/g, " "), /^ALARM \d\d:\d\d:\d\d node [12] 40 samples lost: declared in the record; look at/, `event ${k}`);
  const spoiled = await page.locator(".bar[data-light=bad]").allInnerTexts();
  const warned = await page.locator(".bar[data-light=warn]").allInnerTexts();
  assert.deepEqual(spoiled.map((bar) => /OVER|CLIP/.exec(bar)?.[0]).sort(), ["CLIP", "CLIP", "OVER", "OVER"]);
  assert.deepEqual(warned.map((bar) => /dead|DC/.exec(bar)?.[0]).sort(), ["DC", "DC", "dead", "dead"]);
});

test("says why the disk fails, on small windows too", async (t) => {
  const page = await open(t, "disk away");
  assert.equal(await text(page, "#state"), "FAULT");
  assert.match(await text(page, "header"),
               /The disk fails \(17 times\): recording .*Autobahn \(mount the disk that it is on.*No such device\. The nodes keep what they measure/);
  assert.equal((await text(page, "header")).split("mount the disk").length, 2, "once");
  for (const [name, viewport] of [["day", kDesk], ["phone", kPhone], ["phone-night", kPhone], ["night", kDesk]]) {
    await page.setViewportSize(viewport);
    if (name === "phone-night") await page.keyboard.press("n");
    await picture(page, `disk-away-${name}`);
    assert.deepEqual(await weakTexts(page), [], name);
    const {wide, window} = await page.evaluate(() => ({wide: document.documentElement.scrollWidth, window: innerWidth}));
    assert.ok(wide <= window, `${name}: ${wide} in ${window}`);
  }
});

test("keeps a lamp lit until it is acknowledged", async (t) => {
  const page = await open(t, "trouble");
  assert.equal(await light(page, "LOSS"), "bad");
  await page.keyboard.press("a");
  await page.waitForFunction(() => document.querySelector("#lamp-LOSS").dataset.light === "good");
  // Losses are past; the overload goes on, and lights its lamp again.
  await page.waitForFunction(() => document.querySelector("#lamp-OVERLOAD").dataset.light === "bad");
});

test("is worked by the keyboard alone, with its focus in sight", async (t) => {
  const page = await open(t, "known");
  for (const wheel of ["1", "2", "3", "4"]) {
    await page.keyboard.press(wheel);
    assert.equal(await page.evaluate(() => document.activeElement.id), `wheel-${wheel}`);
    const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineWidth);
    assert.ok(parseFloat(outline) >= 2, outline);
  }
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  const before = await theme();
  await page.keyboard.press("n");
  assert.notEqual(await theme(), before);
  await page.keyboard.press("?");
  assert.equal(await page.locator("#help").isVisible(), true);
  await picture(page, "help");
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#help").isVisible(), false);
  // Arrows go from tab to tab, and round.
  await page.locator("#tab-balance").focus();
  const tabs = await page.locator("[role=tab]").count();
  for (let k = 0; k < tabs; ++k) {
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.locator("[role=tab][aria-selected=true]").count(), 1);
    const id = await page.evaluate(() => document.activeElement.getAttribute("aria-controls"));
    assert.equal(await page.locator(`#${id}`).isVisible(), true);
    assert.equal(await page.locator("[role=tabpanel]:visible").count(), 1);
  }
  assert.equal(await page.evaluate(() => document.activeElement.id), "tab-balance");
  // Everything that can be pressed can be reached.
  const reached = new Set();
  for (let k = 0; k < 20; ++k) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.textContent));
  }
  for (const id of ["lamp-LOSS", "lamp-SYNC", "lamp-OVERLOAD", "lamp-ENCODER", "tab-balance", "Day/night (N)"])
    assert.ok(reached.has(id), `${id} among ${[...reached]}`);
});

test("sets a mark by Space, whatever was clicked before", async (t) => {
  const page = await open(t, "known");
  for (const clicked of ["#tab-setup", "#lamp-LOSS", "#tab-balance"]) {
    await page.locator(clicked).click();
    const asked = page.waitForRequest((request) => request.url().endsWith("/request"));
    await page.keyboard.press(" ");
    assert.equal((await asked).postDataJSON().operation, "mark", clicked);
    await page.waitForFunction(() => !document.querySelector("#mark").disabled);
  }
  assert.equal(await page.locator("#lamp-LOSS").getAttribute("aria-expanded"), "true", "clicked once, not pressed by Space");
});

test("shows the same view after a reload", async (t) => {
  const page = await open(t, "known");
  await page.keyboard.press("?");
  await page.reload();
  await page.waitForFunction(() => document.querySelector("#help")?.checkVisibility());
  assert.equal(await page.locator("#balance").isVisible(), false);
  await page.keyboard.press("b");
  assert.equal(await page.locator("#balance").isVisible(), true);
});

test("keeps the theme that was chosen, without a flash", async (t) => {
  const page = await open(t, "known", {colorScheme: "light"});
  await page.keyboard.press("n");
  // From the very first frame the ground is dark.
  await page.addInitScript(() => {
    globalThis.grounds = new Set();
    const look = () => {
      if (document.body) globalThis.grounds.add(getComputedStyle(document.documentElement).backgroundColor);
      requestAnimationFrame(look);
    };
    look();
  });
  await page.reload();
  await page.waitForFunction(() => Number(document.body.dataset.drawn) > 5);
  assert.deepEqual(await page.evaluate(() => [...globalThis.grounds]), ["rgb(0, 0, 0)"]);
});

for (const [theme, colorScheme] of Object.entries(kThemes))
  for (const scene of ["known", "armed", "unknown", "checked", "trouble"])
    test(`can be read: ${scene}, by ${theme}`, async (t) => {
      const page = await open(t, scene, {colorScheme});
      if (scene === "trouble") await page.locator("#lamp-SYNC").click();
      for (const view of await viewsOf(page)) {
        await page.keyboard.press(view.key);
        await page.waitForFunction((id) => document.querySelector(`#${id}`).checkVisibility(), view.id);
        await picture(page, `${scene}-${view.id}-${theme}`);
        assert.deepEqual(await weakTexts(page), [], view.id);
        if (view.id !== "driver") continue;
        assert.ok(await isWhole(page), "the driver does not scroll");
        await page.keyboard.press("Escape");
      }
    });

test("prints the balance on one sheet of A4, dark theme or not", async (t) => {
  for (const scene of ["known", "checked"]) {
    const page = await open(t, scene, {colorScheme: "dark", viewport: {width: 794, height: 1123}});
    await page.waitForFunction(() => document.querySelectorAll(".wheel[data-known=true]").length === 4);
    await page.emulateMedia({media: "print", colorScheme: "dark"});
    await picture(page, `${scene}-printed`);
    assert.equal(pages(await page.pdf({preferCSSPageSize: true})), 1, scene);
    assert.deepEqual(await weakTexts(page), []);
    assert.match(await text(page, ".paper"), /Wheel balance: demonstration car.*Node 1: 1000000 samples, 0 lost, 3 blocks repaired/);
    assert.equal(await page.locator(".tab-bar, .levels, .print").evaluateAll((all) => all.some((each) => each.checkVisibility())), false);
  }
});

/** All of it is in the window. */
const isWhole = (page) => page.evaluate(() => document.documentElement.scrollHeight <= innerHeight);

test("fits a laptop, a phone, a small window and 200 %", async (t) => {
  for (const [name, options] of Object.entries({
    desk: {viewport: kDesk}, phone: {viewport: kPhone, hasTouch: true}, zoomed: {viewport: {width: kDesk.width / 2, height: kDesk.height / 2}, deviceScaleFactor: 2}})) {
    const page = await open(t, "known", options);
    for (const view of await viewsOf(page)) {
      await page.keyboard.press(view.key);
      await picture(page, `${name}-${view.id}`);
      const {wide, window} = await page.evaluate(() => ({wide: document.documentElement.scrollWidth, window: innerWidth}));
      assert.ok(wide <= window, `${name} ${view.id}: ${wide} in ${window}`);
      // Forms that are folded away are pressed, too.
      await page.evaluate(() => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
      assert.deepEqual(await tooSmall(page), [], `${name} ${view.id}: too small for a finger`);
      if (view.id !== "driver") continue;
      assert.ok(await isWhole(page), `${name}: the driver does not scroll`);
      await page.keyboard.press("Escape");
    }
    await page.keyboard.press("b");
    const {wide, window} = await page.evaluate(() => ({wide: document.documentElement.scrollWidth, window: innerWidth}));
    assert.ok(wide <= window, `${name}: ${wide} in ${window}`);
  }
});

test("says that it is cut off, and comes back by itself", async (t) => {
  const url = busUrl();
  const car = start("rb-web-scene", url, "known");
  const first = await startWeb(url);
  const port = new URL(first.where).port;
  const page = await browser.newPage();
  t.after(() => { car.kill(); return page.close(); });
  await page.goto(first.where);
  const says = (word) => page.waitForFunction((wanted) => document.querySelector("#state")?.innerText.includes(wanted), word);
  await says("RECORDING");
  first.web.kill("SIGKILL");
  await says("NO CONNECTION");
  await picture(page, "cut-off");
  const again = start("rb-web", "--url", url, "--port", port);
  t.after(() => again.kill());
  await says("RECORDING");
  // The recorder falls silent: its last message must not look current.
  car.kill("SIGKILL");
  await says("FAULT");
});

test("asks for the token where others reach the address, and puts it out of sight", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "rb-page-"));
  const file = join(folder, "token");
  writeFileSync(file, "correct-horse-battery\n");
  const url = busUrl();
  const car = start("rb-web-scene", url, "known");
  const {web, where} = await startWeb(url, "--listen", "0.0.0.0", "--token-file", file);
  const page = await browser.newPage();
  t.after(async () => {
    await page.close();
    car.kill();
    web.kill();
    rmSync(folder, {recursive: true});
  });
  const address = `http://127.0.0.1:${new URL(where).port}/`;
  const says = (words) => page.waitForFunction((wanted) => document.querySelector("header")?.innerText.includes(wanted), words);
  await page.goto(address);
  await says("open its whole address, with #token=");
  await page.goto(`${address}#token=correct-horse-battery`);
  await says("RECORDING");
  assert.equal(page.url(), address);
  await page.reload();
  await says("RECORDING");
});
