// Computations of the plots in the browser, against closed forms.
import assert from "node:assert/strict";
import {test} from "node:test";
import {load} from "./load.mjs";

const page = await load("plot_ring", "plot_data", "plot_ask", "encode", "decode", "transfer_function", "wire", "colour_map", "plot_time");

const envelope = (first, values, epoch = 1) => ({
  node: 1, channel: 0, epoch, first, scans: 10, time_ns: first * 5e6, period_ps: 500_000_000, buckets: values.length,
  least: values.map((value) => -value), greatest: values});

test("an instant of a node is one of the host's only once its clock is known", () => {
  const fit = {number: 3, host_ns: 5e9, node_ns: 2e9, drift: 1e-3};
  const hostNs = (state) => page.hostNs({clocks: new Map([[1, {message: {...fit, state}}]])}, 1, 2e9 + 1.001e9);
  assert.equal(hostNs(page.ClockState.Acquire), undefined);
  for (const known of [page.ClockState.Locked, page.ClockState.Holdover]) assert.ok(Math.abs(hostNs(known) - 6e9) < 1e-3);
  assert.equal(page.hostNs({clocks: new Map()}, 1, 2e9), undefined);
});

test("the ring joins messages that overlap, and leaves holes where nothing came", () => {
  const ring = new page.EnvelopeRing();
  ring.take(envelope(100, [1, 2, 3]));
  ring.take(envelope(101, [2, 3, 4]));  // two of them were known
  ring.take(envelope(106, [7]));
  const {least, greatest, end} = ring.last(7, 1);
  assert.equal(end, 107);
  assert.deepEqual(greatest, [1, 2, 3, 4, null, null, 7]);
  assert.deepEqual(least, [-1, -2, -3, -4, null, null, -7]);
  assert.equal(ring.endNs, 107 * 5e6);
});

test("the ring's groups hold the extremes of their buckets, and say nothing of those that lack one", () => {
  const ring = new page.EnvelopeRing();
  ring.take(envelope(0, [1, 5, 2, 3, 4, NaN, 6, 7, 8]));
  const {least, greatest, end} = ring.last(8, 2);
  assert.equal(end, 8);
  assert.deepEqual(greatest, [5, 3, null, 7]);
  assert.deepEqual(least, [-5, -3, null, -7]);
});

test("the ring begins anew with a node's epoch, and after more than it holds", () => {
  const ring = new page.EnvelopeRing();
  ring.take(envelope(0, [1, 2, 3]));
  ring.take(envelope(0, [9], 2));
  assert.deepEqual(ring.last(2, 1).greatest, [null, 9]);
  ring.take(envelope(10 * page.kRingBuckets, [4], 2));
  const {greatest} = ring.last(page.kRingBuckets, 1);
  assert.equal(greatest.filter((value) => value !== null).length, 1);
});

/** A message as it would come. */
const arrival = (type, message) => {
  const bytes = page.encode(type, message);
  return {fingerprint: type.fingerprint, ageMs: 0, bytes: new DataView(bytes.buffer)};
};

test("what is asked is what the analyser reads", () => {
  const spectral = {segment: 8192, window: 2, memory: 20, holdPeaks: true, overlap: 0.75, highestHz: 250};
  const a = {node: 1, channel: 2}, b = {node: 3, channel: 11};
  const view = page.viewOf(2 ** 52, spectral, {pairs: [[a, b]], spectra: [b], envelopes: [a, b], waterfalls: [{wheel: 3, channel: b}]});
  const got = page.decode(page.kView, arrival(page.kView, view));
  assert.equal(got.viewer, 2 ** 52);
  assert.equal(got.hold_peaks, 1);
  assert.equal(got.overlap, 0.75);
  assert.deepEqual([got.pairs, got.input_node[0], got.input_channel[0], got.output_node[0], got.output_channel[0]], [1, 1, 2, 3, 11]);
  assert.deepEqual([got.spectra, got.spectrum_node[0], got.spectrum_channel[0]], [1, 3, 11]);
  assert.deepEqual([got.envelopes, got.envelope_node.slice(0, 2)], [2, [1, 3]]);
  assert.deepEqual([got.waterfalls, got.waterfall_wheel[0], got.waterfall_channel[0]], [1, 3, 11]);
  const many = page.viewOf(1, spectral, {spectra: Array.from({length: 40}, () => a)});
  assert.equal(many.spectra, page.kMostChannels);
});

const spectrum = (viewer, part, parts, time_ns, value) => ({
  viewer, node: 1, channel: 4, time_ns, part, parts, bins: 2, first_hz: 2 * part, step_hz: 1, enbw_hz: 1.5, averages: 3, held: 0,
  density: [value, value]});

test("a spectrum is shown when all parts of one time are there, and only one's own", () => {
  const data = new page.PlotData();
  data.want(["1.5"], [], [], []);
  const shown = () => page.joined(data.spectra.get("1.5").whole, ({density}) => density);
  const take = (...args) => assert.equal(data.take(arrival(page.kSpectrum, spectrum(...args))), true);
  take(data.viewer, 0, 2, 10, 1);
  assert.deepEqual(shown(), []);
  take(data.viewer + 1, 1, 2, 10, 99);
  assert.deepEqual(shown(), []);
  take(data.viewer, 1, 2, 10, 2);
  assert.deepEqual(shown(), [1, 1, 2, 2]);
  assert.deepEqual(page.frequencies(data.spectra.get("1.5").whole), [0, 1, 2, 3]);
  take(data.viewer, 0, 2, 20, 5);  // half of the next one does not mix with it
  assert.deepEqual(shown(), [1, 1, 2, 2]);
  take(data.viewer, 1, 2, 20, 6);
  assert.deepEqual(shown(), [5, 5, 6, 6]);
  data.want([], [], [], []);
  assert.equal(data.spectra.size, 0);
});

test("what is held does not grow, however much comes", () => {
  const data = new page.PlotData();
  data.want(["1.5"], [], ["1.1"], ["0:1.1"]);
  const row = (speed_class) => ({
    wheel: 0, node: 1, channel: 0, time_ns: 1, state: 0, speed_class, from_m_s: 0, to_m_s: 2, way_m: 2, blocks: 1, step: 1 / 32,
    noise_bandwidth: 0.1, lines: 272, amplitude: Array.from({length: 272}, () => 1)});
  const feed = (from, to) => {
    for (let k = from; k < to; ++k) {
      data.take(arrival(page.kEnvelope, envelope(10 * k, Array.from({length: 96}, () => k))));
      data.take(arrival(page.kSpectrum, spectrum(data.viewer, k % 2, 2, k >> 1, 1)));
      data.take(arrival(page.kSpectrum, {...spectrum(data.viewer, 0, 1, k, 1), node: k}));  // not asked for
      data.take(arrival(page.kEnvelope, {...envelope(0, [1]), node: 2 + k}));
      data.take(arrival(page.kWaterfall, row(k % 1000)));
    }
  };
  feed(0, 2000);
  const size = data.size();
  feed(2000, 6000);
  assert.equal(data.size(), size);
  assert.equal(data.envelopes.size, 1);
  assert.ok(data.waterfalls.get("0:1.1").size <= 101);
});

/** A pure delay of half the size with a coherence. */
const transfer = (coherence, delay_s, step_hz = 0.5, bins = 48) => {
  const phase = Array.from({length: bins}, (_, k) => -2 * Math.PI * k * step_hz * delay_s);
  return [{
    viewer: 1, state: 0, time_ns: 1, part: 0, parts: 1, bins, first_hz: 0, step_hz, enbw_hz: 0.75, independent_averages: 20,
    coherence_by_chance: 0.15, input: phase.map(() => 4), output: phase.map(() => 1 / coherence),
    h1_re: phase.map((p) => 0.5 * Math.cos(p)), h1_im: phase.map((p) => 0.5 * Math.sin(p)),
    radius_95: phase.map(() => 0.1), coherence: phase.map(() => coherence)}];
};

test("H1, H2 and Hv are as far apart as the coherence says", () => {
  const of = (estimator) => page.transferFunctionCurves(transfer(0.25, 0), estimator);
  const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-12, `${a} ${b}`);
  near(of("h1").magnitude[7], 0.5);
  near(of("h2").magnitude[7], 2);    // |H1| / coherence
  near(of("hv").magnitude[7], 1);    // |H1| / sqrt(coherence)
  near(of("h1").least[7], 0.4);
  near(of("h1").greatest[7], 0.6);
  near(of("hv").greatest[7], 1.2);
  // sqrt(Gyy / Gxx) is Hv's size, whatever the coherence.
  near(of("hv").magnitude[7], Math.sqrt(4 / 4));
  near(of("h1").phase_deg[7], 0);
  const lost = transfer(0.25, 0);
  lost[0].radius_95[7] = 0.6;
  assert.equal(page.transferFunctionCurves(lost, "h1").phase_deg[7], null, "the circle holds 0");
  assert.equal(page.transferFunctionCurves(lost, "h1").least[7], 0);
  assert.ok(page.transferFunctionCurves(lost, "h1").least_drawn[7] > 0, "the band reaches down beyond the picture");
  lost[0].radius_95[7] = Infinity;
  assert.equal(page.transferFunctionCurves(lost, "h1").greatest[7], null);
});

test("the delay is the slope of the phase, where there is coherence", () => {
  for (const delay_s of [0.0123, -0.004, 0.4])
    assert.ok(Math.abs(page.meanDelay_s(transfer(0.9, delay_s)) - delay_s) < 1e-9);
  assert.equal(page.meanDelay_s(transfer(0.1, 0.01)), undefined);
  const half = transfer(0.9, 0.01);
  for (let k = 20; k < 48; ++k) [half[0].h1_im[k], half[0].coherence[k]] = [0.5 * Math.sin(k * k), 0.05];
  assert.ok(Math.abs(page.meanDelay_s(half) - 0.01) < 1e-9, "what is by chance does not count");
  assert.equal(page.meanDelay_s([]), undefined);
});

test("the map goes from its darkest to its lightest colour", () => {
  const light = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const steps = Array.from({length: 21}, (_, k) => light(page.mapColour(k / 20)));
  assert.ok(steps.every((value, k) => k === 0 || value > steps[k - 1]), steps.join(" "));
  assert.deepEqual(page.mapColour(-1), page.mapColour(0));
  assert.deepEqual(page.mapColour(7), page.mapColour(1));
});

const view = await load("plot_save", "plot_spectrum", "plot_polar", "plot_speed", "plot_figure");

test("a line's amplitude comes of its density and the noise bandwidth", () => {
  // A sine of amplitude A has G B = A^2 / 2 on its bin (WelchPsd).
  const A = 1.5, B = 0.73, G = A * A / 2 / B;
  assert.ok(Math.abs(view.amplitude(G, 25, B, "peak") - A) < 1e-12);
  assert.ok(Math.abs(view.amplitude(G, 25, B, "rms") - A / Math.SQRT2) < 1e-12);
  // A constant is no sine.
  assert.ok(Math.abs(view.amplitude(G, 0, B, "peak") - A / Math.SQRT2) < 1e-12);
  assert.equal(view.amplitude(G, 25, B, "density"), G);
});

test("a table is saved so that others read it", () => {
  const text = view.csv({head: ["f, Hz", 'a "b"'], columns: [[1, 2], [null, 0.25]]});
  assert.equal(text, '"f, Hz","a ""b"""\r\n1,\r\n2,0.25\r\n');
  const x = [0, 1], other = [0, 2];
  const curve = (name, of) => ({name, colour: 0, x: of, y: [3, 4]});
  assert.deepEqual(view.curvesTable("hz", [curve("a", x), curve("b", [...x]), curve("c", other)], "g").head,
                   ["hz", "a g", "b g", "hz", "c g"]);
});

test("pictures stand side by side as far as they fit", () => {
  const size = (width, height) => ({width, height});
  assert.deepEqual(view.placed([size(300, 300), size(300, 200), size(300, 100)], 700),
                   {at: [[0, 0], [300, 0], [0, 300]], width: 600, height: 400});
  assert.deepEqual(view.placed([size(900, 100), size(900, 50)], 700), {at: [[0, 0], [0, 100]], width: 900, height: 150});
  assert.deepEqual(view.placed([], 700), {at: [], width: 0, height: 0});
});

test("texts are broken between words", () => {
  assert.deepEqual(view.wrapped("one two three", 7, (text) => text.length), ["one two", "three"]);
  assert.deepEqual(view.wrapped("extraordinary", 7, (text) => text.length), ["extraordinary"]);
});

test("scales are round, slips against the mean, numbers short", () => {
  assert.deepEqual([0.9, 1, 1.1, 3, 7, 0.03].map(view.roundScale), [1, 1, 2, 5, 10, 0.05]);
  assert.deepEqual(view.slips([10, 10, undefined, 11.5]).map((share) => share && Number(share.toFixed(6))),
                   [-0.047619, -0.047619, undefined, 0.095238]);
  assert.deepEqual(view.slips([10, undefined]), [undefined, undefined], "one alone slips against nothing");
  assert.deepEqual([0, 1234.5, 0.000012, 1e6].map(view.figures), ["0", "1230", "1.2e-5", "1e+6"]);
});
