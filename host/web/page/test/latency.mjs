// How old a sample is when it is seen.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {setTimeout as sleep} from "node:timers/promises";

const kMostMs = 250;
/** A machine that wakes sleepers later than this has more to do than a page's machine may have. */
const kIdleMs = 10;

/** What is to be added to the page's performance.now() in ns to have the machine's raw monotonic clock, on which samples are
    stamped, and how well that is known. */
async function clockOffset(page) {
  let quickest = Infinity, ns = 0;
  for (let k = 0; k < 50; ++k) {
    const asked = Number(process.hrtime.bigint());
    const page_ms = await page.evaluate(() => performance.now());
    const took = Number(process.hrtime.bigint()) - asked;
    if (took < quickest) [quickest, ns] = [took, asked + took / 2 - 1e6 * page_ms];
  }
  // process.hrtime() is CLOCK_MONOTONIC, which is slewed.
  const raw = Number(execFileSync("python3", ["-c",
    "import time; print(time.clock_gettime_ns(time.CLOCK_MONOTONIC_RAW) - time.clock_gettime_ns(time.CLOCK_MONOTONIC))"]));
  return {ns: ns + raw, error_ns: quickest / 2};
}

/** [host clock of the newest sample of the time plot, page's ms when it was on the screen], so many times. */
const samplesSeen = (page, count) => page.evaluate((wanted) => new Promise((done) => {
  const found = [];
  let last = "";
  // In the animation frame after the one that drew it, it is on the screen.
  const look = () => {
    const newest = document.querySelector("#time-figure").parentElement.dataset.newestHostNs;
    if (newest && newest !== last) found.push([Number(newest), performance.now()]);
    last = newest;
    if (found.length < wanted) requestAnimationFrame(look);
    else done(found);
  };
  requestAnimationFrame(look);
}), count);

const quantile = (values, share) => [...values].sort((a, b) => a - b)[Math.floor(share * (values.length - 1))];

/** How late this machine wakes who sleeps 10 ms, of 100 times the fifth worst, until `over` is. */
async function latenessMs(over) {
  const late = [];
  let isOver = false;
  over.finally(() => (isOver = true)).catch(() => {});
  while (!isOver) {
    const from = performance.now();
    await sleep(10);
    late.push(performance.now() - from - 10);
  }
  return quantile(late, 0.95);
}

/** The time plot of the page shows samples within 250 ms of their being taken: half of them whatever the machine has else
    to do, 95 of 100 on one that is idle. */
export async function seesSamplesInTime(t, page, count) {
  const offset = await clockOffset(page);
  const seen = samplesSeen(page, count);
  const [late_ms, samples] = await Promise.all([latenessMs(seen), seen]);
  const ages_ms = samples.map(([host_ns, page_ms]) => (1e6 * page_ms + offset.ns - host_ns) / 1e6);
  const [least, median, most] = [0, 0.5, 0.95].map((share) => quantile(ages_ms, share));
  t.diagnostic(`newest sample when seen: median ${median.toFixed(0)} ms, 95 % ${most.toFixed(0)} ms, clocks known to ` +
    `${(offset.error_ns / 1e6).toFixed(1)} ms; the machine wakes sleepers ${late_ms.toFixed(0)} ms late (95 %)`);
  assert.ok(least > 0, `${least} ms: before it was taken`);
  assert.ok(median <= kMostMs, `half of the samples: ${median} ms`);
  if (late_ms <= kIdleMs) assert.ok(most <= kMostMs, `95 of 100 samples: ${most} ms`);
  else t.diagnostic("95 of 100 samples are not judged: the machine is not idle");
}
