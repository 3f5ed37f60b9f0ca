#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/bus/weight_check.hpp"
#include "common/clock/datagram.hpp"
#include "common/process/temporary_folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment_index.hpp"
#include "common/test/source.hpp"
#include "hil_tests/fuzz/true_node.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recording/formats/candump_writer.hpp"
#include "host/recording/formats/hdf5_writer.hpp"
#include "host/recording/formats/uff58_writer.hpp"
#include "host/recording/formats/wav_writer.hpp"
#include "host/recordings/job_book.hpp"

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
  const Job job{.job = 1,
                .kind = JobKind::kSelect,
                .state = JobState::kDone,
                .recording = "drive",
                .options = "from=1"};
  write("jobs", "book",
        encode_job_book({{.job = job, .asker = 1, .request = 2, .result = "drive-selected"}}));
  const std::string host = "127.0.0.1:8080\nhttp://127.0.0.1:8080\n";
  write("post", "head", "POST\n/request\n" + host + "roadbalance, viewer.7, token.correct-horse-battery");
  write("post", "feed", "GET\n/feed\n" + host + "roadbalance, token.correct-horse-battery\n");
}

void write_session_states() {
  const SessionState state{
      .active = ActiveRecording{.name = "drive",
                                .began_us = 1'700'000'000'000'000,
                                .start = {1, 2},
                                .stop = RequestKey{3, 4},
                                .marks = 2,
                                .durable_marks = 1,
                                .mark = {{.number = 2, .asked = {5, 6}, .text = "bridge"}}},
      .finished = Finished{.start = {7, 8},
                           .stop = {9, 10},
                           .receipt = {Receipt{.name = "before"}},
                           .durable_marks = 3,
                           .mark = {{.number = 4, .asked = {7, 11}, .text = "kerb"}}},
      .pending = {{"before", 2, -77}},
      .past = {{"before", 1'700'000'000'000, 1'700'000'000'009}},
      .set_up =
          AskedSetUp{.asked = {11, 12}, .node = 1, .value = {150.25, 4}, .nodes = {1, 2}, .text = "waits"}};
  write("session_state", "all", text_of(state));
  write("session_state", "empty", text_of({}));
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
        encode(TransferFunctionPart{.viewer = 1, .bin = {{1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 0.5F}}}));
  write("results", "envelope", encode(Envelope{.node = 1, .channel = 2, .bucket = {{-1.0F, 2.0F}}}));
  write("results", "waterfall",
        encode(WaterfallRow{.of = {2, {1, 1}}, .blocks = 3, .amplitude = {0.5F, 2.0F}}));
  write("results", "compensation",
        encode(Compensation{
            .wheel = 2, .plan = {.step = {WeightStep{}, WeightStep{}}}, .verdict = {.incurable = "bent"}}));
  write("results", "remark", encode(Remark{.remarks = 1, .text = "static only"}));
  write("results", "verification",
        encode(WeightCheck{.wheel = 1, .state = WeightCheckState::kKnown, .text = "before"}));
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

/// Six rows of two channels; of one a sample is missing.
ExportTable table() {
  ExportChannel body{.name = "body_z", .unit = "m/s^2", .node = "front", .scale = 1e-5, .mount = "body"};
  ExportChannel wheel = body;
  wheel.name = "wheel_z";
  wheel.offset_counts = 3.0;
  ExportTable table{.vehicle = "car", .program = "seeds", .start_utc_us = 1'700'000'000'000'000};
  table.group = {{.name = "all",
                  .rate_hz = 1000.0,
                  .rows = 6,
                  .period_ps = 1'000'000'000,
                  .shared_time = true,
                  .channel = {body, wheel}}};
  return table;
}

/// A file of that table as `make` writes it.
template <typename Make>
std::string exported(Make make) {
  constexpr std::int64_t kPeriod_ns = 1'000'000;
  std::vector<std::int64_t> time_ns;
  std::vector<std::int32_t> counts;
  for (std::int32_t row = 0; row < 6; ++row) {
    time_ns.push_back(row * kPeriod_ns);
    counts.insert(counts.end(), {100 * row - 250, row == 4 ? kMissingCounts : -row});
  }
  const TemporaryFolder work("rb-fuzz-seeds");
  const auto path = work.path() / "table";
  const auto writer = make(path, table());
  writer->add(0, {.time_ns = time_ns, .counts = counts});
  writer->close();
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_exports() {
  write("uff58", "exported", exported(make_uff58_writer));
  write("wav", "exported", exported(make_wav_writer));
  write("hdf5", "exported", exported(make_hdf5_writer));
  write("candump", "exported", candump_dbc(table()) + '\0' + exported(make_candump_writer));
}

/// Wired, with weights on a wheel and a rotor.
std::string wired_vehicle() {
  std::string vehicle = test::read_source("hil_tests/players/demo/vehicle.toml");
  vehicle.insert(vehicle.find("[[wheel]]\nname = \"front_right\""),
                 "[[wheel.weight]]\nmass_g = 20\nangle_deg = 30\nplane = \"inner\"\n");
  return vehicle +
         "\n[[rotor]]\nname = \"shaft\"\nwheel = [\"rear_left\", \"rear_right\"]\nratio = 3.5\n"
         "[[rotor.plane]]\nname = \"flange\"\nposition_m = [0, 0, 0]\nweight_radius_m = 0.05\n";
}

void write_texts() {
  const std::string vehicle = test::read_source("sim/demo/vehicle.toml");
  write("vehicle", "demo", vehicle);
  write("vehicle", "wired", wired_vehicle());
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
  write("dbc", "frame", std::string("(1700000000.000100) can0 12345678##1112233"));
  write("dbc", "car", test::read_source("common/dbc/test/data/rav4.dbc"));
  write("csv", "all", samples + '\0' + pulses + '\0' + "time_s,number,text\n0.002,1,\"a \"\"bridge\"\"\"\n");
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
    roadbalance::write_session_states();
    roadbalance::write_texts();
    roadbalance::write_exports();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-fuzz-seeds: %s\n", error.what());
    return 4;
  }
  return 0;
}
