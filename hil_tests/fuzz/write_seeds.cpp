#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/results.hpp"
#include "common/bus/transfer_report.hpp"
#include "common/clock/datagram.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment_index.hpp"
#include "common/test/source.hpp"
#include "hil_tests/fuzz/true_node.hpp"

// Writes what the fuzzers begin with: one real encoding of each kind.  Usage: rb-fuzz-seeds FOLDER
namespace roadbalance {
namespace {

std::filesystem::path folder;

template <typename Bytes>
void write(const std::string& what, const std::string& name, const Bytes& bytes) {
  std::filesystem::create_directories(folder / what);
  std::ofstream file(folder / what / name, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + (folder / what / name).string());
}

void write_blocks() {
  const fuzz::TrueNode node{.node = 2, .epoch = 99, .last = 5};
  for (const std::int64_t sequence : {1, 2, 3, 4, 5})
    write("block", "sequence-" + std::to_string(sequence), node.block(sequence).bytes());
  SealedBlock gap;
  seal(GapBlock{.header = {.node = 2, .epoch = 99, .sequence = 5, .first_scan = 40, .scans = 7}}, gap);
  write("block", "gap", gap.bytes());

  std::vector<std::uint8_t> log{0};  // how the target reads it: as it is
  for (const std::int64_t sequence : {1, 3, 5}) {
    const SealedBlock block = node.block(sequence);
    const std::string channel = block_channel(node.node, block.kind);
    const auto header = encode_log_header({.channel = channel, .data = block.bytes()});
    log.insert(log.end(), header.begin(), header.end());
    log.insert(log.end(), channel.begin(), channel.end());
    log.insert(log.end(), block.bytes().begin(), block.bytes().end());
  }
  write("segment", "three-events", log);
  // Logs that the targets build: each 1 is the next block of a node, whole turns of all kinds.
  write("segment", "built", std::string(2 * fuzz::TrueNode::kPerTurn, '\x01'));
  write("recover", "two-places", std::string(6 * fuzz::TrueNode::kPerTurn, '\x01'));

  SegmentIndex index{.segment = 3, .bytes = log.size()};
  index.epoch[{2, 99}] = {
      .position = {.contiguous = 4, .next_scan = 20, .ended = true}, .samples = 20, .blocks = 4};
  write("index", "one-epoch", encode(index));
}

void write_posts() {
  const std::string ids = R"({"asker":1,"request":9007199254740991,"operation":)";
  write("post", "mark", ids + R"("mark","text":"R br\u00fccke 1"})");
  write("post", "range", ids + R"("range","node":2,"channel":4,"value":[80,-1.5e3]})");
  write("post", "start", ids + R"("start","text":""})");
  write("post", "job", ids + R"("job","text":"drive","value":[1]})");
  write("jobs", "order", std::string("drive/format=csv/from=-1.5/to=2e3/channels=a,b"));
  write("jobs", "order-marks", std::string("drive/from-mark=1/to-mark=2/rate=500"));
  write("jobs", "book",
        std::string(
            R"([{"job":1,"kind":5,"state":7,"recording":"drive","options":"from=1","ended_us":0,"text":"t",)"
            R"("asked":[1,2],"result":"drive-selected"}])"));
  const std::string host = "127.0.0.1:8080\nhttp://127.0.0.1:8080\n";
  write("post", "head", "POST\n/request\n" + host + "roadbalance, viewer.7, token.correct-horse-battery");
  write("post", "feed", "GET\n/feed\n" + host + "roadbalance, token.correct-horse-battery\n");
}

void write_messages() {
  write("control", "heartbeat", encode(Heartbeat{.node = 1, .epoch = 2, .base = 3, .next = 9}));
  write("control", "ack",
        encode(Ack{.node = 1,
                   .epoch = 2,
                   .incarnation = 3,
                   .number = 4,
                   .received = 9,
                   .durable = 7,
                   .credit = 99,
                   .missing = {{11, 12}, {15, 15}}}));
  write("control", "command", encode(Command{.node = 1, .request = 5, .incarnation = 3}));
  write("control", "reply", encode(Reply{.node = 1, .epoch = 2, .request = 5, .text = "no such range"}));
  write("control", "vehicle",
        encode(VehiclePart{.node = 1, .incarnation = 3, .parts = 2, .text = "name = \"car\"\n"}));
  write("control", "request",
        encode(Request{.asker = 7, .request = 8, .operation = Operation::kMark, .text = "bridge"}));
  write("control", "answer",
        encode(Answer{.asker = 7, .request = 8, .state = AnswerState::kDone, .text = "mark 1"}));
  write("control", "receipt",
        encode(Receipt{.incarnation = 3, .nodes = 1, .node = 1, .epochs = 1, .name = "drive"}));
  write("notes", "journal", encode(Journal{.node = 1, .epoch = 2, .last_sequence = 7, .scans = 100}));
  write("notes", "note", encode(Note{.kind = NoteKind::kFallback, .text = "/mnt/spare"}));
  write("notes", "commit", encode(Commit{.bytes = 4096, .headers_from = 2048, .headers_crc32c = 7}));
  write("notes", "exchange", encode(ClockExchange{.node = 1, .number = 4, .asked_ns = 5, .heard_ns = 9}));
  write("notes", "fit", encode(ClockFit{.node = 1, .number = 4, .drift = 1e-5}));
  write("notes", "recorder", encode(RecorderStatus{.segment = 3}));
  write("results", "level", encode(Level{.node = 1, .seconds = 1}));
  write("results", "spectrum", encode(SpectrumPart{.node = 1, .step_hz = 0.5, .density = {1.0f, 2.0f}}));
  write("results", "identification", encode(Identification{.speed_class = {{20.0, 60.0}}}));
  write("results", "balance", encode(Balance{.unbalance_g = 35}));
  write("results", "orders", encode(OrderReport{.wheel = 2, .node = 1, .seconds = 60}));
  write("results", "view", encode(View{.viewer = 1, .pair = {{{1, 2}, {2, 3}}}}));
  write("results", "transfer",
        encode(TransferPart{.viewer = 1, .bin = {{1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 0.5F}}}));
  write("results", "envelope", encode(Envelope{.node = 1, .channel = 2, .bucket = {{-1.0F, 2.0F}}}));
  write("results", "waterfall",
        encode(WaterfallRow{.of = {2, {1, 1}}, .blocks = 3, .amplitude = {0.5F, 2.0F}}));
  write("results", "compensation",
        encode(Compensation{
            .wheel = 2, .plan = {.step = {WeightStep{}, WeightStep{}}}, .verdict = {.incurable = "bent"}}));
  write("results", "job",
        encode(Job{.jobs = 1,
                   .job = 2,
                   .recording = "drive",
                   .options = "format=csv",
                   .progress = 0.5,
                   .parts = 1,
                   .text = "reads"}));
  write("results", "document", encode(parts_of("complete\n", 0, 2).front()));
  write("clock", "question", encode(ClockDatagram{.node = 1, .epoch = 2, .number = 3}));
  write("clock", "answer",
        encode(ClockDatagram{
            .kind = ClockDatagramKind::kAnswer, .node = 1, .received_ns = 4, .answered_ns = 5}));
}

void write_texts() {
  const std::string vehicle = test::read_source("sim/demo/vehicle.toml");
  write("vehicle", "demo", vehicle);
  write("vehicle", "weights",
        vehicle +
            "\n[weights]\nstep_g = 5\nheaviest_g = 60\nmost = 2\nraster_deg = 10\nlength_mm_per_g = 2\n"
            "[limits]\nshop_g = 7\n[[seat]]\nname = \"driver\"\nposition_m = [0, 0.4, 0]\n");
  for (const char* name : {"descriptions/quarter_car", "test/data/hub_axis", "test/data/swing_arm"})
    write("description", std::filesystem::path(name).filename(),
          test::read_source(std::string("common/multibody/") + name + ".toml"));
  write("scenario", "demo", test::read_source("sim/demo/scenario.toml"));
  write("address", "all", std::string("drive.toml?seed=7&rate=20&seconds=320&start_ns=123&from=12.5"));
  write("address", "max", std::string("?rate=max"));
  const std::string samples = "time_s,body_z,wheel_z\ns,m/s^2,g\n0.0,1.5,-0.25\n0.01,1.25,1e-3\n";
  const std::string pulses = "time_s,wheel,kind\n0.001,front_left,tooth\n0.002,front_left,zero\n";
  write("dbc", "car", test::read_source("firmware/backends/test/data/rav4.dbc"));
  write("csv", "both", samples + '\0' + pulses);
}

}  // namespace
}  // namespace roadbalance

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: rb-fuzz-seeds FOLDER\n");
    return 2;
  }
  try {
    roadbalance::folder = arguments[1];
    roadbalance::write_blocks();
    roadbalance::write_messages();
    roadbalance::write_posts();
    roadbalance::write_texts();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-fuzz-seeds: %s\n", error.what());
    return 4;
  }
  return 0;
}
