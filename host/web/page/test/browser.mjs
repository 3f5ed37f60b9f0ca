// Helpers for the tests of the page: programs, a browser, and a check of colours.
import {spawn} from "node:child_process";
import {mkdirSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {createRequire} from "node:module";

/** Where npm has put the packages, and where pictures go: both in the build. */
const kPackages = process.env.RB_PAGE_PACKAGES, kPictures = process.env.RB_PAGE_PICTURES, kPrograms = process.env.RB_BIN;
if (!kPackages || !kPictures || !kPrograms) throw new Error("RB_PAGE_PACKAGES, RB_PAGE_PICTURES and RB_BIN must be set");

const {chromium} = createRequire(join(kPackages, "package.json"))("playwright-core");

export const kChromium = "/usr/bin/chromium";
export const kChromiumArguments = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync"];
export const launch = () => chromium.launch({executablePath: kChromium, args: kChromiumArguments});

let bus = 0;
/** A bus of this process's own, each time another: only the port isolates. */
export const busUrl = () => `udpm://239.255.76.67:${12_000 + (process.pid + 4_799 * bus++) % 20_000}?ttl=0`;

export function start(program, ...args) {
  const child = spawn(join(kPrograms, program), args, {stdio: ["ignore", "pipe", "inherit"]});
  const end = () => child.kill();
  process.once("exit", end);
  child.once("exit", () => process.off("exit", end));
  return child;
}

/** The first line that a program says. */
export const firstLine = (child) => new Promise((resolve, reject) => {
  child.stdout.once("data", (data) => resolve(String(data).trim()));
  child.once("exit", (code) => reject(new Error(`ended with code ${code}`)));
});

export async function startWeb(url, ...args) {
  const web = start("rb-web", "--url", url, "--port", "0", ...args);
  return {web, where: await firstLine(web)};
}

/** rb demo with a page in a browser; `ended` is its exit code.  Both end with the test. */
export async function openDemo(t, ...args) {
  const demo = start("rb", "demo", "--seed", "1", ...args);
  const ended = new Promise((resolve) => demo.once("exit", resolve));
  const browser = await launch();
  t.after(async () => {
    await browser.close();
    demo.kill("SIGINT");
    await ended;
  });
  let said = "";
  const where = await new Promise((resolve, reject) => {
    demo.stdout.on("data", (data) => {
      said += data;
      const found = /Watch it in a browser: (\S+)/.exec(said);
      if (found) resolve(found[1]);
    });
    ended.then((code) => reject(new Error(`rb demo ended with code ${code}: ${said}`)));
  });
  const page = await browser.newPage({viewport: {width: 1366, height: 768}});
  await page.goto(where);
  return {page, ended};
}

/** The level of every channel of the demonstration car. */
export const showsBars = (page, timeout = 60_000) =>
  page.waitForFunction(() => document.querySelectorAll(".bar").length === 24, null, {timeout});

/** Until the page has had its stop held long enough, by whatever is down. */
export const stopIsHeld = (page) => page.waitForFunction(() => document.querySelector("#stop").dataset.held === undefined);
export async function holdEscape(page) {
  await page.keyboard.down("Escape");
  await stopIsHeld(page);
  await page.keyboard.up("Escape");
}

/** Of all that a finger can press now, in whatever view: what is smaller than 48 px. */
export const tooSmall = (page) => page.evaluate(() =>
  [...document.querySelectorAll("button, input, select, summary, a[href], [role=tab]")].filter((one) => {
    const {width, height} = one.getBoundingClientRect();
    return one.checkVisibility() && (width < 48 || height < 48);
  }).map((one) => `${one.tagName} ${one.id || one.textContent}`));

export function pictureFile(name) {
  mkdirSync(kPictures, {recursive: true});
  return join(kPictures, `${name}.png`);
}
export const picture = (page, name) => page.screenshot({path: pictureFile(name)});

/** Drawn smaller or larger, not resampled. */
export async function scaledPicture(page, name, scale) {
  const session = await page.context().newCDPSession(page);
  const {data} = await session.send("Page.captureScreenshot", {clip: {x: 0, y: 0, ...page.viewportSize(), scale}});
  await session.detach();
  writeFileSync(pictureFile(name), Buffer.from(data, "base64"));
}

/** Of a document that chromium has printed. */
export const pages = (pdf) => pdf.toString("latin1").match(/\/Type\s*\/Page\b(?!s)/g)?.length;

/** Texts whose contrast is below 4.5 : 1 (WCAG 2.1, 1.4.3), in the page: ["text 3.9"]. */
export const weakTexts = (page) => page.evaluate(() => {
  const rgba = (text) => {
    const [r, g, b, a = 1] = text.match(/[\d.]+/g).map(Number);
    return [r, g, b, a];
  };
  const luminance = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((value) => {
      const c = value / 255;
      return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const weak = [];
  for (const element of document.querySelectorAll("body *")) {
    const text = [...element.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE)
      .map((node) => node.textContent.trim()).join("");
    if (!text || element.getClientRects().length === 0) continue;
    const style = getComputedStyle(element);
    let opacity = 1;
    for (let at = element; at; at = at.parentElement) opacity *= Number(getComputedStyle(at).opacity);
    const below = ground(element);
    const faded = (colour) => colour.slice(0, 3).map((value, k) => opacity * value + (1 - opacity) * below[k]);
    const [a, b] = [luminance(faded(rgba(element instanceof SVGElement ? style.fill : style.color))), luminance(ground(element))]
      .sort((x, y) => y - x);
    const contrast = (a + 0.05) / (b + 0.05);
    if (contrast < 4.5) weak.push(`${text} ${contrast.toFixed(2)}`);
  }
  return weak;
});

/** Times that the page draws in a second: the most of ten seconds, as a machine may have else to do. */
export const updatesPerSecond = (page) => page.evaluate(async () => {
  const drawn = () => Number(document.body.dataset.drawn);
  let most = 0;
  for (let k = 0; k < 10 && most < 10; ++k) {
    const [count, from] = [drawn(), performance.now()];
    await new Promise((done) => setTimeout(done, 1000));
    most = Math.max(most, 1000 * (drawn() - count) / (performance.now() - from));
  }
  return most;
});

/** What the page's thread does for a picture of what is measured, in ms: of three seconds. */
export async function frameCost_ms(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable");
  const look = async () => {
    const {metrics} = await session.send("Performance.getMetrics");
    return [metrics.find(({name}) => name === "TaskDuration").value, Number(await page.evaluate(() => document.body.dataset.drawn))];
  };
  const [busy_s, drawn] = await look();
  await new Promise((done) => setTimeout(done, 3000));
  const [later_s, more] = await look();
  await session.detach();
  return 1e3 * (later_s - busy_s) / (more - drawn);
}

/** Times in a second that the bars of each node's levels change, of the node where they do least: the most of a minute, as
    a machine may have else to do.  A bar is as high as its rms and changes with nothing else. */
export const levelsPerSecond = (page) => page.evaluate(async () => {
  const changes = [...document.querySelectorAll("#levels .node")].map((node) => {
    const pictures = [];  // ms, of each in which a bar changed
    new MutationObserver((mutations) => {
      const now = document.timeline.currentTime;
      if (now !== pictures.at(-1) && mutations.some(({target}) => target.className === "rms")) pictures.push(now);
    }).observe(node, {subtree: true, attributeFilter: ["style"]});
    return pictures;
  });
  const within = (pictures, from) => pictures.filter((at) => at > from && at <= from + 1000).length;
  const most = (pictures) => Math.max(0, ...pictures.map((from) => within(pictures, from)));
  for (const end = performance.now() + 60_000; performance.now() < end && changes.some((pictures) => most(pictures) < 10);)
    await new Promise((done) => setTimeout(done, 200));
  return Math.min(...changes.map(most));
});
