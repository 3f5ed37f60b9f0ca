#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/text/printable.hpp"
#include "common/types/angle_units.hpp"
#include "common/types/block.hpp"
#include "common/types/scan.hpp"
#include "tools/rb/asking.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/wheel_angle.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct AskOptions {
  std::string url;
  double seconds = 60.0;
  bool json = false;
  Request request{};
};

Json receipt_json(const Receipt& receipt) {
  char crc[16];
  std::snprintf(crc, sizeof crc, "%08x", receipt.blocks_crc32c);
  const bool is_known = receipt.sums_agree == false || (receipt.sums_agree && receipt.open_epochs == 0);
  const Json sums_agree = is_known ? Json(*receipt.sums_agree) : Json(nullptr);
  return {{"node", receipt.node},
          {"epochs", receipt.epochs},
          {"open_epochs", receipt.open_epochs},
          {"samples_sent", receipt.samples_sent},
          {"samples_recorded", receipt.samples_recorded},
          {"samples_lost", receipt.samples_sent - receipt.samples_recorded},
          {"gaps", receipt.gaps},
          {"repaired", receipt.repaired},
          {"overload_s", receipt.overload_s},
          {"sync_us", receipt.sync_us < 0 ? Json(nullptr) : Json(receipt.sync_us)},
          {"crc32c", crc},
          {"sums_agree", sums_agree},
          {"absence", receipt.missing().empty() ? Json(nullptr) : Json(receipt.missing())}};
}

void print_receipt(const Receipt& receipt) {
  if (receipt.nodes == 0) return (void)std::printf("no node has been recorded\n");
  const std::string missing = receipt.missing();
  if (receipt.epochs == 0)  // nothing of it could be lost, or summed up
    return (void)std::printf("node %d: no samples; it %s\n", receipt.node, missing.c_str());
  // Of samples that were never taken none is lost.
  const std::int64_t lost = receipt.samples_sent - receipt.samples_recorded;
  std::string loss = missing.empty() ? "" : "was absent";
  if (missing.empty() || lost != 0) loss += (loss.empty() ? "" : ", ") + std::to_string(lost) + " lost";
  std::printf("node %d: %lld samples, %s, %lld repaired, %.1f s overload, ", receipt.node,
              static_cast<long long>(receipt.samples_recorded), loss.c_str(),
              static_cast<long long>(receipt.repaired), receipt.overload_s);
  if (receipt.sync_us >= 0) std::printf("clock within %.0f us, ", receipt.sync_us);
  const char* const proof =
      receipt.sums_agree == false ? "DOES NOT AGREE"
      : receipt.open_epochs > 0   ? "is not proven: the node has not told its own"
      : receipt.sums_agree        ? "agrees"
                           : "is not proven: blocks were lost, or the node's end says another (rb verify)";
  std::printf("CRC %08x %s\n", receipt.blocks_crc32c, proof);
  if (!missing.empty()) std::printf("node %d %s\n", receipt.node, missing.c_str());
}

Json answer_json(const Answer& answer) {
  return {{"done", answer.state == AnswerState::kDone},
          {"reason", answer.reason == RefusalReason::kNone ? Json(nullptr) : Json(text_of(answer.reason))},
          {"text", answer.text},
          {"time_us", answer.time_us}};
}

int ask(const AskOptions& options) {
  const auto patience = std::chrono::milliseconds(static_cast<std::int64_t>(1000.0 * options.seconds));
  Asking asking(options.url);
  const auto answer = asking.ask(options.request, patience, [&] {
    std::fprintf(stderr, "rb: %s  Asking on, for %.0f s in all (--seconds).\n", asking.silence().c_str(),
                 options.seconds);
  });
  if (!answer) throw std::runtime_error(asking.silence());
  if (answer->state == AnswerState::kUnderWay)
    throw std::runtime_error("not done after " + std::to_string(static_cast<int>(options.seconds)) +
                             " s: " + answer->text);
  const bool done = answer->state == AnswerState::kDone;
  int code = done ? kDone : kAnswerIsNo;
  const bool is_partial = done && options.request.operation == Operation::kStart && answer->value[0] > 0.0;
  if (is_partial) code = kIncomplete;
  Json json = answer_json(*answer);
  if (!options.json)
    std::fprintf(done ? stdout : stderr, "%s%s\n", done ? "" : "rb: refused: ", answer->text.c_str());
  if (done && options.request.operation == Operation::kStop) {
    Json receipts = Json::array();
    const auto& proof = asking.receipts(std::chrono::seconds(5));
    if (!are_whole(proof)) code = kIncomplete;
    if (proof.empty() && !options.json)
      std::fprintf(stderr, "rb: the recorder has sent no receipt: rb verify says what is on the disk\n");
    for (const auto& [place, receipt] : proof) {
      if (!options.json) print_receipt(receipt);
      if (!options.json && place == 0 && receipt.stopped_by != who_asks())
        std::printf("stopped by %s\n", receipt.stopped_by.c_str());
      if (receipt.nodes > 0) receipts.push_back(receipt_json(receipt));
      json["recording"] = receipt.name;
      json["bytes"] = receipt.bytes;
      json["marks"] = receipt.marks;
      json["stopped_by"] = receipt.stopped_by;
    }
    json["nodes"] = receipts;
  }
  if (options.json) std::printf("%s\n", json.dump().c_str());
  return code;
}

/// "2.5": channel 5, counted from 1, of node 2, as the page calls it.
void take_channel(const std::string& text, Request& request) {
  int node = 0, channel = 0, end = 0;
  if (std::sscanf(text.c_str(), "%d.%d%n", &node, &channel, &end) != 2 ||
      static_cast<std::size_t>(end) != text.size() || node < 1 || node > kLastNode || channel < 1 ||
      channel > kAccelerations)
    throw ConfigError("channel " + text + ": allowed: NODE.CHANNEL, channels from 1 to " +
                      std::to_string(kAccelerations) + ", for example 2.5");
  request.node = node;
  request.channel = channel - 1;
}

std::shared_ptr<AskOptions> add_asking(CLI::App& command, Operation operation, int& code) {
  auto options = std::make_shared<AskOptions>();
  options->request.operation = operation;
  add_bus_url(command, options->url);
  command.add_option("--seconds", options->seconds, "how long to wait until it is done")
      ->check(number_within(0.1, 3600.0))
      ->capture_default_str();
  command.add_flag("--json", options->json, "one JSON object on standard output");
  command.callback([options, &code] { code = ask(*options); });
  return options;
}

auto at_most(std::size_t bytes) {
  return [bytes](const std::string& text) {
    return text.size() <= bytes ? std::string() : "longer than " + std::to_string(bytes) + " bytes";
  };
}

/// A message has no control characters; sent as blanks, they would make another text than was typed.
std::string fault_of_text(const std::string& text) {
  const std::string hidden = first_hidden(text);
  return hidden.empty() ? "" : "has the hidden character " + hidden + "; allowed: text that can be seen";
}

void add_text(CLI::App& command, const std::string& name, const std::shared_ptr<AskOptions>& options,
              std::size_t most_bytes, const std::string& help) {
  command.add_option(name, options->request.text, help)->check(at_most(most_bytes))->check(fault_of_text);
}

/// A wheel by its name, as requests count them.
void add_wheel(CLI::App& command, const std::shared_ptr<AskOptions>& options) {
  std::vector<std::pair<std::string, int>> wheels;
  for (int w = 0; w < kWheels; ++w) wheels.emplace_back(kWheelNames[static_cast<std::size_t>(w)], w);
  command.add_option("wheel", options->request.channel, "front_left, front_right, rear_left or rear_right")
      ->required()
      ->transform(one_of(std::move(wheels)));
}

void add_zero_marks(CLI::App& configure, int& code) {
  CLI::App* reading = configure.add_subcommand(
      "reading",
      "Of a zero mark, while a recording is under way: begin with a wheel, turn it forward by hand until "
      "its mark fires, let it stand, tell where its reference point (the valve) is; and again");
  const auto of_reading = add_asking(*reading, Operation::kReading, code);
  add_wheel(*reading, of_reading);
  reading->add_option_function<std::string>(
      "where",
      [of_reading](const std::string& text) {
        const bool is_left = of_reading->request.channel % 2 == 0;
        const auto angle_rad = parse_wheel_angle(text, is_left);
        if (!angle_rad)
          throw ConfigError(
              "\"" + text +
              "\" is no place on a wheel; allowed: 10:30, 45°; not 10, which may be an hour or degrees");
        of_reading->request.value = {*angle_rad, 1.0};
      },
      "the clock as seen from outside, or degrees from the top in the direction of forward rotation; not "
      "given: "
      "begin with this wheel");
  CLI::App* datum = configure.add_subcommand("datum", "Where a wheel's zero mark fires, between recordings");
  const auto of_datum = add_asking(*datum, Operation::kDatum, code);
  add_wheel(*datum, of_datum);
  const auto add_angle = [datum, of_datum](const std::string& name, std::size_t k, double least, double most,
                                           const std::string& what) {
    datum
        ->add_option_function<double>(
            name, [of_datum, k](double deg) { of_datum->request.value[k] = deg / kDegrees; }, what)
        ->required()
        ->check(number_within(least, most));
  };
  add_angle("deg", 0, -360.0, 360.0,
            "of the wheel, its reference point on top = 0, in the direction of rotation");
  add_angle("sigma_deg", 1, 0.01, 180.0, "how well that is known, one standard deviation");
}

}  // namespace

void add_start(CLI::App& app, int& code) {
  CLI::App* start = app.add_subcommand("start", "Begins a recording");
  const auto options = add_asking(*start, Operation::kStart, code);
  add_text(*start, "name", options, kMostNameBytes, "of the recording; default: date and time");
  start
      ->add_option(
          "--nodes", options->request.nodes,
          "record only these, for example front,2; default: every one of the vehicle file, and without "
          "one of them the recording is partial (exit code 3)")
      ->check(at_most(kMostNodesText))
      ->check(fault_of_text);
}

void add_stop(CLI::App& app, int& code) {
  add_asking(*app.add_subcommand("stop", "Ends the recording and says what is on the disk"), Operation::kStop,
             code);
}

void add_mark(CLI::App& app, int& code) {
  CLI::App* mark = app.add_subcommand("mark", "Puts a mark into the recording");
  add_text(*mark, "text", add_asking(*mark, Operation::kMark, code), kMostRequestText,
           "what there was to be seen");
}

void add_configure(CLI::App& app, int& code) {
  CLI::App* configure =
      app.add_subcommand("configure", "Changes ranges, scales, filter and zero marks between recordings");
  configure->require_subcommand(1);
  CLI::App* range = configure->add_subcommand("range", "Full scale of a channel");
  const auto of_range = add_asking(*range, Operation::kRange, code);
  range
      ->add_option_function<std::string>(
          "channel", [of_range](const std::string& text) { take_channel(text, of_range->request); },
          "NODE.CHANNEL, for example 2.5")
      ->required();
  range->add_option("range", of_range->request.value[0], "m/s²")->required()->check(number_within(0.1, 1e5));
  CLI::App* scale = configure->add_subcommand(
      "scale", "Of a channel by gravity: read it with its arrow up, turn it over, read it again");
  const auto of_scale = add_asking(*scale, Operation::kScale, code);
  scale
      ->add_option_function<std::string>(
          "channel", [of_scale](const std::string& text) { take_channel(text, of_scale->request); },
          "NODE.CHANNEL, for example 2.5")
      ->required();
  scale->add_option("arrow", of_scale->request.value[0], "where its positive direction points now: up, down")
      ->required()
      ->transform(one_of({{"up", 1}, {"down", -1}}));
  CLI::App* filter = configure->add_subcommand("filter", "Anti-aliasing filter of all nodes");
  const auto of_filter = add_asking(*filter, Operation::kFilter, code);
  filter->add_option("corner", of_filter->request.value[0], "Hz")->required()->check(number_within(1.0, 1e5));
  filter->add_option("--order", of_filter->request.value[1], "of the Butterworth filter; default: as it is")
      ->check(CLI::Range(1, 12));
  add_zero_marks(*configure, code);
}

void add_zero(CLI::App& app, int& code) {
  CLI::App* zero = app.add_subcommand("zero", "Takes what channels read at rest as their zero");
  const auto options = add_asking(*zero, Operation::kZero, code);
  zero->add_option("--node", options->request.node, "of this node alone; default: of every node")
      ->check(CLI::Range(1, static_cast<int>(kLastNode)));
}

void add_vehicle(CLI::App& app, int& code) {
  CLI::App* vehicle = app.add_subcommand("vehicle", "Chooses the vehicle file among the recorder's");
  const auto options = add_asking(*vehicle, Operation::kVehicle, code);
  vehicle->add_option("name", options->request.text, "of the file in the folder of rb-recorder --vehicle")
      ->required()
      ->check(fault_of_text);
}

}  // namespace roadbalance
