// A drive is recorded while everything is done to rb-web and its pages that people and strangers do: the record has
// every sample, and neither rb-web nor the browser grows.  RB_FULL=1: eight hours (RB_HOURS) at 20 times real time.
import assert from "node:assert/strict";
import {once} from "node:events";
import {spawnSync} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {test} from "node:test";
import {setTimeout as sleep} from "node:timers/promises";
import {BarePage} from "./bare_page.mjs";
import {busUrl, launch, start, startWeb} from "./browser.mjs";
import {MemoryTrend, WebSocketClient, ownMemory, stall, uploads} from "./crowd.mjs";

const kFull = process.env.RB_FULL === "1";
const kDrive = kFull ? {seconds: 3600 * Number(process.env.RB_HOURS ?? 8), rate: 20} : {seconds: 140, rate: 4};
const kRateHz = 2000;  // of the demonstration car's nodes
/** Every view has been seen by then. */
const kSettledMs = kFull ? 120_000 : 12_000;
const kClients = 20, kUploadBytes = 100 << 20, kWithinMs = 60_000;
const kMiB = 1 << 20;
const kViews = ["b", "p", "s", "e", "l", "?", "d"];
const kPlots = ["time", "spectrum", "transfer", "waterfall", "polar", "speed"];

const ended = async (program) => (program.exitCode === null && program.signalCode === null ? once(program, "exit") : undefined);

/** Recorder, analyser and nodes of the simulated car, and two rb-web: one lives from beginning to end, the other is killed
    again and again. */
class Drive {
  folder = mkdtempSync(join(tmpdir(), "rb-crowd-"));
  record = join(this.folder, "record");
  url = busUrl();
  driving = true;
  isCleared = false;
  counts = {stalled: 0, uploads: 0, kills: 0, reloads: 0, crashes: 0};
  mostTaken = 0;
  #programs = [];

  run(program, ...args) {
    const child = start(program, "--url", this.url, ...args);
    this.#programs.push(child);
    return child;
  }
  async begin() {
    this.recorder = this.run("rb-recorder", "--record", this.record);
    this.analyser = this.run("rb-analyser", "--record", this.record, "--exit-at-end");
    this.nodes = ["front", "rear"].map((node) => this.run("rb-node", "--node", node, "--vehicle",
      join(process.env.RB_SOURCE, "sim/demo/vehicle.toml"), "--front-end", `sim:?seed=1&rate=${kDrive.rate}&seconds=${kDrive.seconds}`));
    for (const name of ["steady", "doomed"]) {
      const {web, where} = await startWeb(this.url);
      this.#programs.push(web);
      this[name] = {web, where, port: Number(new URL(where).port), token: /token=([\w-]+)/.exec(where)[1]};
    }
  }
  async untilOver() {
    await Promise.all(this.nodes.map(ended));
    this.driving = false;
  }
  /** Again and again while the car drives. */
  async keep(act) {
    while (this.driving) await act();
  }
  async end() {
    this.recorder.kill("SIGTERM");
    await Promise.all([this.recorder, this.analyser].map(ended));
    this.steady.web.kill("SIGTERM");
    await ended(this.steady.web);
    const {recorder, analyser, nodes, steady} = this;
    assert.deepEqual([recorder, analyser, ...nodes, steady.web].map(({exitCode}) => exitCode), [0, 0, 0, 0, 0]);
  }
  clear() {
    this.driving = false;
    this.isCleared = true;
    for (const program of this.#programs) program.kill("SIGKILL");
    rmSync(this.folder, {recursive: true, force: true});
  }
}

/** A page on which all views are looked at, and what it and its rb-web have in memory after each round. */
class Looker {
  web = new MemoryTrend(kSettledMs);
  nodes = new MemoryTrend(kSettledMs);  // of its document, their number
  heap = new MemoryTrend(kSettledMs, kFull ? 5 : 2);  // scripts are compiled again now and then: 0.6 MiB for one look
  renderer = new MemoryTrend(kSettledMs, kFull ? 5 : 2);
  page = new BarePage({width: 1366, height: 768});
  saidMs = -Infinity;

  toString() {
    return `rb-web: ${this.web}; page: ${this.heap}; its process: ${this.renderer}; ` +
      `${this.nodes.settled} nodes when settled, ${this.nodes.growth} more`;
  }
  async open(drive) {
    this.webPid = drive.steady.web.pid;
    await this.page.open(drive.steady.where);
    await this.hasDrawn(0);
  }
  async hasDrawn(pictures) {
    for (const end = performance.now() + kWithinMs; !(await this.drawn() > pictures); await sleep(100))
      assert.ok(performance.now() < end, "the page does not draw");
  }
  drawn() {
    return this.page.evaluate("Number(document.body?.dataset.drawn)");
  }
  async round() {
    for (const key of kViews) {
      await this.page.press(key);
      for (const plot of key === "p" ? kPlots : []) {
        await this.page.click(`#plot-${plot}`);
        await sleep(500);
        assert.equal(await this.page.evaluate(`document.querySelector("#plot-${plot}").ariaPressed`), "true", plot);
      }
      await sleep(500);
    }
    await this.page.press("Escape");  // the driver's view covers the tabs
    await this.measure();
  }
  async measure() {
    await this.page.send("HeapProfiler.collectGarbage");
    const {metrics} = await this.page.send("Performance.getMetrics");
    const metric = (wanted) => metrics.find(({name}) => name === wanted).value;
    this.heap.add(metric("JSHeapUsedSize"));
    this.nodes.add(metric("Nodes"));
    const {processInfo} = await this.page.browser("SystemInfo.getProcessInfo");
    this.renderer.add(processInfo.filter(({type}) => type === "renderer").reduce((sum, {id}) => sum + ownMemory(id), 0));
    this.web.add(ownMemory(this.webPid));
    if (kFull && performance.now() > this.saidMs + 60_000) {
      this.saidMs = performance.now();
      console.log(`${new Date().toISOString()} ${this}`);
    }
  }
}

/** A page that is reloaded, and whose process is killed, beside an rb-web that is killed. */
async function reload(drive, browser) {
  const page = await browser.newPage();
  for (let k = 0; k < 4 && drive.driving; ++k) {
    await page.goto(drive.doomed.where, {timeout: kWithinMs}).catch(() => {});  // its rb-web may just be away
    await sleep(400);
    await page.reload().catch(() => {});
    ++drive.counts.reloads;
    await sleep(400);
  }
  const {processInfo} = await (await browser.newBrowserCDPSession()).send("SystemInfo.getProcessInfo");
  for (const {id, type} of processInfo) {
    if (type !== "renderer") continue;
    try {
      process.kill(id, "SIGKILL");
      ++drive.counts.crashes;
    } catch {
      // It has just ended by itself.
    }
  }
  await page.close().catch(() => {});
}

async function killWeb(drive) {
  await sleep(3000);
  drive.doomed.web.kill("SIGKILL");
  await ended(drive.doomed.web);
  await sleep(200);
  if (drive.isCleared) return;  // the test has failed elsewhere
  drive.doomed.web = drive.run("rb-web", "--port", String(drive.doomed.port));
  ++drive.counts.kills;
}

async function takeNothing(drive) {
  assert.ok(await stall(drive.steady.port, kWithinMs), "who takes nothing is still served");
  ++drive.counts.stalled;
}

async function pour(drive) {
  for (const {sent, status} of await uploads(drive.steady.port, drive.steady.token, kUploadBytes)) {
    // Bytes under way when the server hung up lay in the kernel.
    drive.mostTaken = Math.max(drive.mostTaken, sent);
    assert.ok(sent < kUploadBytes / 2, `${sent} bytes of an upload were taken`);
    assert.ok([undefined, 413, 101].includes(status), `${status}`);
    ++drive.counts.uploads;
  }
  await sleep(1000);
}

/** The clients get frames still, also from the rb-web that was killed, and the page draws. */
async function allAreWell(looker, clients) {
  const frames = clients.map((client) => client.frames);
  await looker.page.press("b");
  await looker.hasDrawn(await looker.drawn() + 10);
  await looker.page.picture("crowd-end");
  for (const end = performance.now() + kWithinMs; clients.some((client, k) => client.frames < frames[k] + 10); await sleep(100))
    assert.ok(performance.now() < end, "a page gets no frames any more");
}

function verify(t, record) {
  const proof = spawnSync(join(process.env.RB_BIN, "rb"), ["verify", record, "--json"], {encoding: "utf8"});
  assert.equal(proof.status, 0, proof.stdout + proof.stderr);
  for (const {node, samples_sent, samples_recorded, samples_missing} of JSON.parse(proof.stdout).nodes) {
    t.diagnostic(`node ${node}: ${samples_recorded} samples recorded, ${samples_missing} missing`);
    assert.equal(samples_recorded, samples_sent);
    assert.ok(samples_sent > 0.9 * kDrive.seconds * kRateHz, `${samples_sent}`);
  }
}

test("a crowd, sluggards, uploads, kills and reloads cost the record nothing, and memory stays flat", async (t) => {
  const drive = new Drive(), browser = await launch(), clients = [], looker = new Looker();
  t.after(async () => {
    clients.forEach((client) => client.leave());
    await Promise.all([browser.close(), looker.page.close()]);
    drive.clear();
  });
  await drive.begin();
  for (let k = 0; k < kClients; ++k) clients.push(new WebSocketClient((k % 2 ? drive.doomed : drive.steady).port));
  await looker.open(drive);
  const begin = performance.now();
  await Promise.all([drive.untilOver(), drive.keep(() => looker.round()), drive.keep(() => reload(drive, browser)),
                     drive.keep(() => killWeb(drive)), drive.keep(() => takeNothing(drive)), drive.keep(() => pour(drive))]);
  const took_s = (performance.now() - begin) / 1000;
  await allAreWell(looker, clients);
  await drive.end();

  const frames = clients.map((client) => client.frames);
  t.diagnostic(`${kDrive.seconds} s of driving in ${took_s.toFixed(0)} s: ${JSON.stringify(drive.counts)}`);
  t.diagnostic(`${(drive.mostTaken / kMiB).toFixed(1)} MiB of an upload left its sender at most; ` +
    `${Math.min(...frames)} to ${Math.max(...frames)} frames for each of ${kClients} pages`);
  t.diagnostic(`${looker}`);
  verify(t, drive.record);
  for (const [what, count] of Object.entries(drive.counts)) assert.ok(count > 0, what);
  assert.deepEqual(looker.page.complaints, []);
  assert.ok(looker.web.growth < kMiB, `rb-web: ${looker.web}`);
  assert.ok(looker.nodes.growth < 200, `page: ${looker.nodes.growth} nodes more`);
  assert.ok(looker.heap.growth < kMiB, `page: ${looker.heap}`);
  assert.ok(looker.renderer.growth < 16 * kMiB, `page's process: ${looker.renderer}`);
});
