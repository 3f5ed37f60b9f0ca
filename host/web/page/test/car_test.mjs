// The page's state of a car and its conclusions, with a clock set by the test.
import assert from "node:assert/strict";
import {test} from "node:test";
import {load} from "./load.mjs";

const page = await load("alarm", "car", "encode", "wire", "state", "lamps", "preflight", "taps", "directions", "words", "units", "driver_view", "receipt_view", "wheel_place", "events");

/** A frame of rb-web (host/web/feed.hpp). */
function frame(...messages) {
  const parts = messages.map(([type, message, ageMs = 0]) => ({ageMs, bytes: page.encode(type, message)}));
  const view = new DataView(new ArrayBuffer(8 + parts.reduce((sum, {bytes}) => sum + 8 + bytes.length, 0)));
  view.setUint32(0, 0x52424631);
  view.setUint32(4, parts.length);
  let at = 8;
  for (const {ageMs, bytes} of parts) {
    view.setUint32(at, ageMs);
    view.setUint32(at + 4, bytes.length);
    new Uint8Array(view.buffer).set(bytes, at + 8);
    at += 8 + bytes.length;
  }
  return view.buffer;
}
const kStarted = page.NodeState.Started, kHourMs = 3_600_000;
const recorder = [page.kRecorder, {incarnation: 5, state: page.RecorderState.Recording, time_us: 9e6, seconds_left: 9000, recording_s: 4}];
const beat = (node) => [page.kHeartbeat, {node, epoch: 7, state: kStarted, owner: 5}];
const text = (words) => [...new TextEncoder().encode(words)];
const setup = (node, more = {}) => [page.kSetup, {
  node, name: text("front"), vehicle: text("a car"), vehicle_crc32c: 4, channels: 2,
  channel_name: [text("left"), text("right")], role: [0, 0], mount: [0, 1], position_m: [[1, 0.7, 0], [1, -0.7, 0]],
  direction: [[0, 0, 1], [0, 0, -1]], wheel: [0, 1], pulses_per_turn: [48, 48], encoder: [1, 1], ...more}];

test("a silent node is a fault until an hour has passed, and then forgotten", () => {
  const car = new page.Car();
  car.take(frame(recorder, beat(1), beat(2), setup(2)), 0);
  assert.equal(page.stateWord(car, "open", 1000).word, "RECORDING");
  // Node 1 goes on, node 2 does not.
  for (let now = 1000; now <= 10_000; now += 1000) car.take(frame(recorder, beat(1)), now);
  assert.match(page.stateWord(car, "open", 10_000).detail, /Node 2 is silent/);
  car.take(frame(recorder, beat(1)), kHourMs);
  assert.match(page.stateWord(car, "open", kHourMs).detail, /Node 2 is silent/, "nobody may have had time to see it");
  car.take(frame(recorder, beat(1)), kHourMs + 1);
  assert.equal(page.stateWord(car, "open", kHourMs + 1).word, "RECORDING");
  assert.equal(car.setups.size, 0, "and with it what it was");
});

test("a node that the recording lacks is a fault with its cause, and no lamp stays green", () => {
  const car = new page.Car();
  const name = {name: text("drive"), name_size: 5};
  const {AbsenceCause} = page;
  const lacks = (...nodes) => [page.kRecorder, {
    ...recorder[1], ...name, absent: nodes.length, absent_node: [...nodes.map(([node]) => node), ...Array(16 - nodes.length).fill(0)],
    absent_cause: [...nodes.map(([, cause]) => cause), ...Array(16 - nodes.length).fill(0)]}];
  car.take(frame(lacks(), beat(1), beat(2)), 0);
  assert.equal(page.stateWord(car, "open", 0).word, "RECORDING");
  const loss = (now) => page.lamps(car, new page.EventLog(), now)[0];
  assert.equal(loss(0).light, "good");
  car.take(frame(lacks([2, AbsenceCause.ProgramEnded], [3, AbsenceCause.NeverCame]), beat(1)), 1000);
  const state = page.stateWord(car, "open", 1000);
  assert.equal(state.word, "FAULT");
  assert.match(state.detail, /Node 2 is not recorded: its program was ended.*Node 3 is not recorded: it has not been heard/);
  assert.equal(loss(1000).light, "bad");
  assert.equal(loss(1000).number, "nodes 2, 3 missing");
});

test("a receipt of a node that was away is not whole, whatever it counts", () => {
  const words = "never came";
  const receipt = {node: 2, nodes: 2, samples_sent: 0, samples_recorded: 0, end_sums: 1, absence: text(words), absence_size: words.length,
                   unheard: [], unheard_size: 0};
  assert.equal(page.defects([receipt]), "node 2 never came");
});

test("ages that rb-web tells count from when the message was on the bus", () => {
  const car = new page.Car();
  car.take(frame([...recorder, 2000], [...beat(1), kHourMs - 1000]), 0);
  assert.equal(car.heartbeats.size, 1);
  assert.equal(page.stateWord(car, "open", 0).word, "FAULT");
  car.take(frame(recorder), 1001);
  assert.equal(car.heartbeats.size, 0);
});

test("remarks are those of one estimate", () => {
  const car = new page.Car();
  const remark = (time_ns, number, remarks, words) =>
    [page.kRemark, {time_ns, number, remarks, size: text(words).length, text: text(words)}];
  car.take(frame(remark(1, 0, 2, "masses ± 2 %"), remark(1, 1, 2, "static only")), 0);
  assert.deepEqual(page.remarks(car), ["Masses ± 2 %.", "Static only."]);
  car.take(frame(remark(2, 0, 2, "masses")), 0);
  assert.deepEqual(page.remarks(car), ["Masses."], "the second has not come yet");
  car.take(frame(remark(3, 0, 0, "")), 0);
  assert.deepEqual(page.remarks(car), []);
});

test("directions have names, and mirrored pairs that are described as opposite are found", () => {
  assert.equal(page.directionWord([0, 0, 1]), "up");
  assert.equal(page.directionWord([0, -1, 0]), "right");
  assert.equal(page.directionWord([-0.9, 0.1, 0.3]), "about backward");
  const car = new page.Car();
  car.take(frame(setup(1)), 0);
  assert.deepEqual(page.oppositePairs(car.setups.get(1).message), [[0, 1]]);
  car.take(frame(setup(1, {direction: [[0, 0, 1], [0, 0, 1]]})), 0);
  assert.deepEqual(page.oppositePairs(car.setups.get(1).message), []);
  // Both outward, the classic mistake of who mirrors a car in his head.
  car.take(frame(setup(1, {direction: [[0, 1, 0], [0, -1, 0]]})), 0);
  assert.deepEqual(page.oppositePairs(car.setups.get(1).message), [[0, 1]]);
});

test("a knock proves a sensor, or shows that it is the wrong way round", () => {
  const car = new page.Car(), taps = new page.Taps();
  const knock = (number, channel, first) => {
    const swings = [0, 0];
    swings[channel] = first;
    return [page.kKnock, {node: 1, number, channel, first_m_s2: swings, peak_m_s2: swings.map(Math.abs)}];
  };
  const channel = (k) => taps.of(car.setups.get(1).message, k);
  const directions = () => page.preflight(car, taps, 0).find(({name}) => name === "Directions");
  car.take(frame(setup(1)), 0);
  assert.equal(directions().ready, "unknown");
  assert.match(directions().says, /1\.1 left and 1\.2 right/);
  // No sensor was chosen, or another one was tapped, or two felt it: nothing is proven.
  car.take(frame(knock(7, 0, 3)), 0);
  taps.take(car);
  assert.equal(channel(0), undefined);
  taps.meant = {node: 1, channel: 1};
  car.take(frame(knock(8, 0, 3)), 0);
  taps.take(car);
  assert.equal(channel(0), undefined);
  assert.equal(channel(1), undefined);
  taps.meant = {node: 1, channel: 0};
  car.take(frame([page.kKnock, {node: 1, number: 9, channel: 0, first_m_s2: [3, 3], peak_m_s2: [3, 2.9]}]), 0);
  taps.take(car);
  assert.equal(channel(0), undefined);
  assert.equal(taps.last.proves, false);
  // Knocked upwards: the left one points up; the right one is described as pointing down.
  car.take(frame(knock(1, 0, 3)), 0);
  taps.take(car);
  assert.equal(channel(0), "right");
  taps.meant = {node: 1, channel: 1};
  car.take(frame(knock(2, 1, 3)), 0);
  taps.take(car);
  assert.equal(channel(1), "wrong");
  assert.equal(directions().ready, "no");
  assert.match(directions().says, /1\.2 right.*wrong sign/);
  car.take(frame(knock(3, 1, -3)), 0);
  taps.take(car);
  assert.equal(channel(1), "right");
  assert.equal(directions().ready, "yes");
  // Another vehicle.toml begins anew.
  car.take(frame(setup(1, {vehicle_crc32c: 5})), 0);
  assert.equal(channel(0), undefined);
});

test("the pre-flight check names what is to be done", () => {
  const car = new page.Car(), taps = new page.Taps();
  const check = (name, now = 0) => page.preflight(car, taps, now).find((each) => each.name === name);
  assert.equal(check("Nodes").ready, "no");
  assert.equal(check("Disk").ready, "no");
  car.take(frame(setup(1), setup(2, {wheel: [2, 3], vehicle_crc32c: 5})), 0);
  assert.equal(check("Nodes").ready, "yes");
  assert.match(check("Vehicle file").says, /different vehicle\.toml/);
  car.take(frame(setup(2, {wheel: [2, -1]})), 0);
  assert.match(check("Vehicle file").says, /rear right/);
  car.take(frame(setup(2, {wheel: [2, 3]})), 0);
  assert.equal(check("Vehicle file").ready, "yes");
  assert.equal(check("Channels").ready, "unknown");
  const level = (node, more = {}) => [page.kLevel, {node, speed_m_s: NaN, ...more}];
  car.take(frame(level(1, {dead: 2}), level(2, {overload: 1})), 0);
  assert.match(check("Channels").says, /1\.2 right carries no signal; 2\.1 left is beyond its range/);
  car.take(frame(level(1, {clipped: 2}), level(2)), 0);
  assert.match(check("Channels").says, /1\.2 right is clipped/);
  car.take(frame(level(1, {dead: 1 << 17}), level(2)), 0);
  assert.match(check("Channels").says, /1\.2 right stands .* off its zero/);
  car.take(frame(level(1), level(2)), 0);
  assert.equal(check("Channels").ready, "yes");
  assert.equal(check("Encoders").ready, "unknown", "nothing turns");
  car.take(frame(level(1, {speed_m_s: 9}), level(2, {speed_m_s: 9}), beat(1), beat(2)), 0);
  assert.equal(check("Encoders").ready, "yes");
  // A node without a wheel has no angle to wait for.
  car.take(frame(setup(3, {wheel: [-1, -1]}), level(3)), 0);
  assert.equal(check("Encoders").ready, "yes");
  car.take(frame([page.kHeartbeat, {...beat(2)[1], mark_counts: [0, 0, 60, 36]}]), 0);
  assert.match(check("Encoders").says, /rear right: 60 and 36\. Is a second magnet/);
  const lamp = page.lamps(car, car.events, 0).find(({name}) => name === "ENCODER");
  assert.equal(lamp.number, "zero marks name no tooth");
  assert.match(lamp.sentence, /node 2 line 2: 60 and 36 teeth/);
  car.take(frame([page.kHeartbeat, {...beat(2)[1], encoder_faults: [0, 3]}]), 0);
  assert.match(check("Encoders").says, /rear right/);
  car.take(frame([page.kRecorder, {...recorder[1], seconds_left: 600}]), 0);
  assert.match(check("Disk").says, /10 min/);
  assert.equal(check("Nodes", 4000).ready, "no", "silent");
});

test("what weights have done is said of the newest balance only", () => {
  const car = new page.Car();
  car.take(frame([page.kBalance, {wheel: 2, time_ns: 5}], [page.kVerification, {wheel: 2, time_ns: 5}]), 0);
  assert.equal(car.weightCheckOf(2)?.time_ns, 5);
  // The next recording, which nothing is compared with.
  car.take(frame([page.kBalance, {wheel: 2, time_ns: 6}]), 1000);
  assert.equal(car.weightCheckOf(2), undefined);
});

test("a device that is gone lights the lamp of loss as long as it is away, and the next drive waits for it", () => {
  const car = new page.Car();
  const counted = (gone, returned) => [page.kHeartbeat, {...beat(2)[1], device_counts: [gone, returned]}];
  const lamp = () => page.lamps(car, car.events, 0).find(({name}) => name === "LOSS");
  const nodes = () => page.preflight(car, new page.Taps(), 0).find(({name}) => name === "Nodes");
  car.take(frame(recorder, beat(1), counted(3, 3), setup(1), setup(2)), 0);
  assert.equal(lamp().light, "good", "it has come back");
  assert.equal(nodes().ready, "yes");
  car.take(frame(recorder, beat(1), counted(4, 3)), 0);
  assert.equal(lamp().light, "bad");
  assert.equal(lamp().number, "node 2: device gone");
  assert.match(lamp().sentence, /A device of node 2 is gone/);
  assert.equal(nodes().ready, "no");
  assert.match(nodes().says, /A device of node 2 is gone/);
  car.take(frame(recorder, beat(1), counted(4, 4)), 0);
  assert.equal(lamp().light, "good");
});

test("an overload lights its lamp though the page was never drawn, until it is acknowledged", () => {
  const car = new page.Car();
  const overload = (now) => page.lamps(car, car.events, now).find(({name}) => name === "OVERLOAD");
  const level = (more) => [page.kLevel, {node: 1, ...more}];
  // Both in one frame: the second no longer contains it.
  car.take(frame(level({overload: 4}), level({})), 0);
  car.take(frame(level({})), 60_000);
  assert.equal(overload(60_000).light, "bad");
  assert.match(overload(60_000).sentence, /1\.3/);
  car.events.acknowledge();
  car.take(frame(level({})), 61_000);
  assert.equal(overload(61_000).light, "good");
  car.take(frame(level({clipped: 1 << 7}), level({})), 62_000);
  assert.equal(overload(62_000).light, "bad");
  assert.match(overload(62_000).sentence, /^Channel 1\.8 \(node\.channel\) is clipped/);
  car.take(frame(level({overload: 4})), 63_000);
  assert.match(overload(63_000).sentence, /1\.3 .* left its range.* 1\.8 .* is clipped/);
  assert.match(overload(63_000).number, /^2 channels/);
});

test("each thing that is wrong has one of three levels, and the worst comes first", () => {
  const car = new page.Car();
  const said = () => page.warnings(car, 0).map(({level, text}) => `${page.levelWord(level)} ${text.split(/[:.]/)[0]}`);
  car.take(frame(recorder, beat(1)), 0);
  assert.deepEqual(said(), []);
  car.take(frame([recorder[0], {...recorder[1], fallback: 1, on_battery: 3, rivals: 2}]), 0);
  assert.deepEqual(said(), ["WARNING The supply is gone", "WARNING Whether the supply is there cannot be read",
                            "WARNING Two nodes have one number, or one was paused",
                            "NOTICE Records to the fallback folder"]);
  for (const [name, cause] of Object.entries(page.AlarmCause).filter(([, value]) => typeof value === "number"))
    assert.match(page.levelWord(page.levelOf(cause)), /^(ALARM|WARNING|NOTICE)$/, name);
  for (const lamp of ["LOSS", "SYNC", "OVERLOAD", "ENCODER"])
    assert.equal(page.levelWord(page.levelOf(page.causeOf(lamp))), "ALARM", lamp);
});

test("what clocks suffered lights SYNC until it is acknowledged, as the record's alarms say it", () => {
  const car = new page.Car();
  const lamp = (now) => page.lamps(car, car.events, now).find(({name}) => name === "SYNC");
  const busy = (recording_s) => [page.kRecorder, {...recorder[1], name_size: 3, recording_s}];
  const own = (node) => [page.kHeartbeat, {...beat(node)[1], time_base: page.TimeBase.Own}];
  const fit = (node, us, state = page.ClockState.Locked) => [page.kClockFit, {node, epoch: 7, state, uncertainty_s: us * 1e-6}];
  car.take(frame(busy(2), own(1), own(2)), 0);
  assert.equal(lamp(0).light, "unknown", "they are being asked");
  car.take(frame(busy(3), own(1), own(2), fit(1, 400), fit(2, 12)), 1000);
  assert.equal(lamp(1000).light, "warn", "not known well yet");
  car.take(frame(busy(4), own(1), own(2), fit(1, 12), fit(2, 12)), 2000);
  assert.deepEqual([lamp(2000).light, lamp(2000).number], ["good", "12 µs"], "which is no event");
  car.take(frame(busy(5), own(1), own(2), fit(1, 12), fit(2, 51)), 3000);
  assert.deepEqual([lamp(3000).light, lamp(3000).number], ["warn", "51 µs"]);
  car.take(frame(busy(6), own(1), own(2), fit(1, 12, page.ClockState.Holdover), fit(2, 12)), 4000);
  assert.match(lamp(4000).sentence, /clock of node 1 is not heard/);
  car.take(frame(busy(7), own(1), own(2), fit(1, 12), fit(2, 12)), 5000);
  assert.deepEqual([lamp(5000).light, lamp(5000).number], ["warn", "12 µs"], "it is over, and nobody has seen it");
  assert.match(lamp(5000).sentence, /node 1, node 2: clock not heard.*clock known worse than to 50 µs/);
  assert.deepEqual(car.events.of("SYNC").map(({cause}) => page.levelWord(page.levelOf(cause))), ["WARNING", "WARNING"]);
  car.events.acknowledge();
  assert.equal(lamp(5000).light, "good");
  // Node 2 goes on, and its clock is heard no more.
  car.take(frame(busy(30), own(1), own(2), fit(1, 12)), 30_000);
  assert.match(lamp(30_000).sentence, /clock of node 2 is not heard/);
  // Nobody speaks: what was seen to go wrong stays lit though nothing is known now.
  car.take(frame(busy(31), own(1), own(2), fit(1, 12, page.ClockState.Holdover), fit(2, 12)), 31_000);
  assert.equal(lamp(40_000).light, "warn");
});

test("SYNC remembers what the record's alarms are raised for, and nothing else", () => {
  const busy = [page.kRecorder, {...recorder[1], name_size: 3, recording_s: 100}];
  const own = (node) => [page.kHeartbeat, {...beat(node)[1], time_base: page.TimeBase.Own}];
  const fit = (node, us) => [page.kClockFit, {node, epoch: 7, state: page.ClockState.Locked, uncertainty_s: us * 1e-6}];
  const drive = (from_s, to_s, ...messages) => {
    for (let s = from_s; s <= to_s; ++s) car.take(frame(busy, ...messages), 1000 * s);
    return page.lamps(car, car.events, 1000 * to_s).find(({name}) => name === "SYNC");
  };
  const causes = () => car.events.unseen("SYNC").map(({cause, where}) => `${page.AlarmCause[cause]} ${where}`);
  let car = new page.Car();
  drive(0, 20, own(1), own(2), fit(1, 12), fit(2, 12));
  drive(21, 29, own(1), own(2), fit(1, 12));
  assert.deepEqual(causes(), [], "its patience is ten seconds");
  drive(30, 41, own(1), own(2), fit(1, 12));
  assert.equal(drive(42, 45, own(1), own(2), fit(1, 12), fit(2, 12)).light, "warn", "it is over, and nobody has seen it");
  assert.deepEqual(causes(), ["ClockUnheard node 2"]);

  car = new page.Car();
  drive(0, 9, own(1), fit(1, 400));
  assert.deepEqual(causes(), [], "it is becoming known");
  drive(10, 25, own(1), fit(1, 400));
  assert.equal(drive(26, 27, own(1), fit(1, 12)).light, "warn");
  assert.deepEqual(causes(), ["ClockPoor node 1"]);

  // A node that joins late has its own ten seconds, and one that was away has them anew.
  car = new page.Car();
  drive(0, 59, own(1), fit(1, 12));
  assert.equal(drive(60, 63, own(1), fit(1, 12), own(2)).light, "good");
  drive(64, 66, own(1), fit(1, 12), own(2), fit(2, 12));
  drive(67, 99, own(1), fit(1, 12));
  assert.equal(drive(100, 101, own(1), own(2), fit(1, 12)).number, "12 µs");
  assert.deepEqual(causes(), []);
});

test("dead channels and offsets light the lamp while they last, those that are used", () => {
  const car = new page.Car();
  const lamp = (now) => page.lamps(car, car.events, now).find(({name}) => name === "OVERLOAD");
  car.take(frame([page.kLevel, {node: 1, dead: 4 | 1 << 21}], [page.kLevel, {node: 2, dead: 1}]), 0);
  assert.equal(lamp(0).light, "warn");
  assert.equal(lamp(0).number, "2 dead, 1 DC offset");
  assert.match(lamp(0).sentence, /1\.3, 2\.1 .* no signal.*1\.6 .* off its zero/);
  car.take(frame([page.kLevel, {node: 1}], [page.kLevel, {node: 2}]), 100);
  assert.equal(lamp(100).light, "good");
  assert.equal(lamp(100).number, "0 channels");
});

test("the pre-flight check can be all OK before the start, when clocks are not asked yet", () => {
  const car = new page.Car(), taps = new page.Taps();
  const clocks = () => page.preflight(car, taps, 0).find(({name}) => name === "Clocks");
  const beat = [page.kHeartbeat, {node: 1, state: page.NodeState.Preview, time_base: 0}];
  car.take(frame([page.kRecorder, {incarnation: 0, state: page.RecorderState.Armed}], beat), 0);
  assert.equal(clocks(), undefined);
  car.take(frame([page.kRecorder, {incarnation: 5, state: page.RecorderState.Recording, name_size: 5}], beat), 0);
  assert.equal(clocks()?.ready, "unknown");
});

test("the driver hears of the worst, and is done with four plans of the newest balances only", () => {
  const car = new page.Car();
  const wheels = [0, 1, 2, 3];
  const known = (time_ns) => wheels.map((wheel) => [page.kBalance, {wheel, time_ns, state: page.Unknown.None}]);
  car.take(frame(recorder, beat(1), ...known(1), ...wheels.map((wheel) => [page.kCompensation, {wheel, time_ns: 1}])), 0);
  assert.match(page.whatNow(car), /^Done/);
  car.take(frame(...known(2)), 0);
  assert.doesNotMatch(page.whatNow(car), /Done/, "plans of a balance before");
  const plans = (...seconds) => car.take(frame(...known(3), ...seconds.map((seconds_wanted, wheel) => [page.kCompensation, {wheel, time_ns: 3, seconds_wanted}])), 0);
  plans(0, 42, 7, 0);
  assert.equal(page.whatNow(car), "Drive on like this: 42 s more.");
  plans(0, 42, Infinity, 0);
  assert.equal(page.whatNow(car), "Drive on like this: 42 s more. Other speeds are needed for rear left.");
  plans(0, 0, Infinity, Infinity);
  assert.equal(page.whatNow(car), "Other speeds are needed for rear left, rear right.");
  car.take(frame([page.kRecorder, {...recorder[1], seconds_left: 600}]), 0);
  assert.match(page.worry(car, 0), /full in 10 min/);
  // A notice does not hide what a lamp warns of, nor a warning.
  car.take(frame([page.kRecorder, {...recorder[1], fallback: 1}]), 0);
  assert.match(page.worry(car, 0), /fallback/);
  car.take(frame([page.kLevel, {node: 1, dead: 1}]), 0);
  assert.match(page.worry(car, 0), /^OVERLOAD: 1 dead/);
  car.take(frame([page.kRecorder, {...recorder[1], fallback: 1, on_battery: 1}]), 0);
  assert.match(page.worry(car, 0), /supply is gone/);
  car.take(frame([page.kLevel, {node: 1, overload: 1}]), 0);
  assert.match(page.worry(car, 0), /^OVERLOAD: 1 channel/);
});

test("a record that is not whole is not called by its 0 lost", () => {
  const receipt = {node: 2, samples_sent: 5, samples_recorded: 5, gaps: 0, open_epochs: 0, absence: [], absence_size: 0, unheard: [], unheard_size: 0, end_sums: 1};
  assert.equal(page.defects([receipt, {...receipt, end_sums: 0}]), "CRC of node 2 DOES NOT AGREE");
  assert.equal(page.defects([{...receipt, end_sums: 0, open_epochs: 1}]), "its end is missing, CRC of node 2 DOES NOT AGREE");
  assert.equal(page.defects([{...receipt, open_epochs: 1}]), "its end is missing");
  assert.equal(page.defects([{...receipt, samples_recorded: 3, gaps: 1, end_sums: 2}]), "2 lost, 1 gap");
  assert.equal(page.defects([receipt, {...receipt, end_sums: 2}]), "CRC of node 2 is not known");
});

test("another recording begins with plots of its own", () => {
  const car = new page.Car();
  const orders = [page.kOrders, {wheel: 0, node: 1}];
  car.take(frame([page.kRecorder, {incarnation: 5, name_size: 3}], orders), 0);
  car.take(frame([page.kRecorder, {incarnation: 5, name_size: 3}]), 1000);
  assert.equal(car.plots.orders.size, 1);
  car.take(frame([page.kRecorder, {incarnation: 6, name_size: 3}]), 2000);
  assert.equal(car.plots.orders.size, 0);
});

test("sentences of the analyser come in the person's units, and only what has them changes", () => {
  const said = "not separable: 90–130 km/h do not tell; drive at 80 km/h or slower";
  const heavy = "100 ± 20 g is more than the 80 g that a sound wheel needs; 3 grey wheels of 5 kN/m at 49 g·cm, ISO G 40";
  assert.equal(page.inUnits(said), said);
  page.toggleUnits();
  try {
    // 90, 130 and 80 over 1.609344; 100, 20 and 80 over 28.3495.
    assert.equal(page.inUnits(said), "not separable: 56–81\u00a0mph do not tell; drive at 50\u00a0mph or slower");
    assert.equal(page.inUnits(heavy), "3.53 ± 0.71\u00a0oz is more than the 2.82\u00a0oz that a sound wheel needs; " +
      "3 grey wheels of 5 kN/m at 49 g·cm, ISO G 40");
  } finally {
    page.toggleUnits();
  }
});

test("units are those of the person, and of a weight that can be bought", () => {
  assert.equal(page.mass(35), "35.0\u00a0g");
  assert.equal(page.moment(35, 0.19), "665\u00a0g·cm");
  assert.equal(page.speed(31), "112\u00a0km/h");
  page.toggleUnits();
  assert.equal(page.mass(28.349523125), "1.00\u00a0oz");
  assert.equal(page.weightMass(7.0873807), "0.25\u00a0oz");
  assert.equal(page.moment(28.349523125, 0.254), "10.0\u00a0oz·in");
  assert.equal(page.speed(44.704), "100\u00a0mph");
  page.toggleUnits();
});

// 10:30 is 45° left of the top: a left wheel turns that way, a right one the other.
test("a place on a wheel is told by the clock as seen from outside, or by degrees in the direction of rotation", () => {
  const degrees = (wheel, words) => Math.round(page.angleOf(wheel, words) * 180 / Math.PI * 1e6) / 1e6;
  for (const left of [0, 2]) {
    assert.equal(degrees(left, "10:30"), 45);
    assert.equal(degrees(left + 1, "10:30"), 315);
    assert.equal(degrees(left, " 3:00 "), 270);
    assert.equal(degrees(left + 1, "3:00"), 90);
    for (const wheel of [left, left + 1]) {
      assert.equal(degrees(wheel, "12:00"), 0);
      assert.equal(degrees(wheel, "6:00"), 180);
      assert.equal(degrees(wheel, "45"), 45);
      assert.equal(degrees(wheel, "-30.5°"), -30.5);
      for (const words of ["10°", "7:30", "217°"])
        assert.equal(page.clockPosition(wheel, page.angleOf(wheel, page.clockPosition(wheel, page.angleOf(wheel, words)))),
                     page.clockPosition(wheel, page.angleOf(wheel, words)), "back and forth");
    }
  }
  for (const words of ["", "valve", "13:01", "10:60", "361", "1e2", "4 5", "10", "1", "12", " 09 "]) assert.equal(page.angleOf(0, words), undefined, words);
});
