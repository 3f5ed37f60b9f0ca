// How old a sample is when it is seen.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {cpus} from "node:os";

const kMostMs = 250;
/** On a machine that has less of its processors to spare, somebody waits for one. */
const kIdleShare = 0.25;

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

/** Time of all processors since the start, and how much of it they had nothing to do. */
function processorTime() {
  const times = cpus().map(({times: each}) => each);
  const sum = (of) => times.reduce((total, each) => total + of(each), 0);
  return {idle: sum(({idle}) => idle), all: sum((each) => Object.values(each).reduce((total, value) => total + value))};
}

/** The time plot of the page shows samples within 250 ms of their being taken: half of them whatever the machine has else
    to do, 95 of 100 on one that is idle. */
export async function seesSamplesInTime(t, page, count) {
  const offset = await clockOffset(page);
  const before = processorTime();
  const samples = await samplesSeen(page, count);
  const after = processorTime();
  const idle = (after.idle - before.idle) / (after.all - before.all);
  const ages_ms = samples.map(([host_ns, page_ms]) => (1e6 * page_ms + offset.ns - host_ns) / 1e6);
  const [least, median, most, worst] = [0, 0.5, 0.95, 1].map((share) => quantile(ages_ms, share));
  t.diagnostic(`newest sample when seen: median ${median.toFixed(0)} ms, 95 % ${most.toFixed(0)} ms, worst ${worst.toFixed(0)} ms, clocks known to ` +
    `${(offset.error_ns / 1e6).toFixed(1)} ms; ${(100 * idle).toFixed(0)} % of the processors idle`);
  assert.ok(least > 0, `${least} ms: before it was taken`);
  assert.ok(median <= kMostMs, `half of the samples: ${median} ms`);
  if (idle >= kIdleShare) assert.ok(most <= kMostMs, `95 of 100 samples: ${most} ms`);
  else t.diagnostic("95 of 100 samples are not judged: the machine is not idle");
}
