#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "tools/rb/bus_distance.hpp"
#include "tools/rb/command.hpp"

namespace roadbalance {
namespace {

struct DistanceOptions {
  std::string log, dbc, counter, interface;
  std::optional<double> metres_per_count;
  bool json = false;
};

/// Frames of the log from one interface; lines that are none (remote and error frames, and what is no log)
/// are counted.
std::vector<LoggedFrame> read_log(const DistanceOptions& options, std::int64_t& passed_over) {
  std::ifstream file(options.log);
  if (!file) throw std::system_error(errno, std::generic_category(), "open " + options.log);
  std::vector<LoggedFrame> log;
  std::string line;
  while (std::getline(file, line)) {
    auto frame = parse_candump(line);
    if (!frame) {
      ++passed_over;
      continue;
    }
    if (!options.interface.empty() && frame->interface != options.interface) continue;
    // Two buses may use one identifier for different messages.
    if (!log.empty() && frame->interface != log.front().interface)
      throw ConfigError(options.log + ": holds frames of " + log.front().interface + " and " +
                        frame->interface + ": --interface must say whose");
    log.push_back(std::move(*frame));
  }
  if (file.bad()) throw std::system_error(errno, std::generic_category(), "read " + options.log);
  if (log.empty())
    throw ConfigError(options.log + ": no line is a frame " +
                      (options.interface.empty() ? "" : "of " + options.interface + " ") +
                      "as candump -L writes them");
  return log;
}

int distance(const DistanceOptions& options) {
  const Dbc dbc = Dbc::read_file(options.dbc);
  std::int64_t passed_over = 0;
  const BusDistance found =
      bus_distance(read_log(options, passed_over), dbc, options.counter, options.metres_per_count);
  if (passed_over > 0)
    std::fprintf(stderr, "rb distance: %s: %lld lines are no frames\n", options.log.c_str(),
                 static_cast<long long>(passed_over));
  if (options.json)
    std::printf("%s\n", distance_json(found).dump().c_str());
  else
    for (const std::string& line : distance_lines(found)) std::printf("%s\n", line.c_str());
  return found.counter.runs == 1 ? kDone : kIncomplete;
}

}  // namespace

void add_distance(CLI::App& app, int& code) {
  auto options = std::make_shared<DistanceOptions>();
  CLI::App* command = app.add_subcommand(
      "distance", "How far a pulse counter and the speeds of a car's bus say that it went, from a log");
  command->add_option("log", options->log, "of candump -L")->required();
  command->add_option("--dbc", options->dbc, "file that describes the frames")->required();
  command->add_option("--counter", options->counter, "MESSAGE.SIGNAL that counts")->required();
  command
      ->add_option("--metres-per-count", options->metres_per_count,
                   "what a count is worth if its unit is not m")
      ->check(number_within(1e-9, 1e9));
  command->add_option("--interface", options->interface, "whose frames, if the log holds those of several");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = distance(*options); });
}

}  // namespace roadbalance
