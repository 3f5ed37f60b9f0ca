#include "tools/rb/study_clock_skew.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/quiet_port.hpp"
#include "common/process/temporary_folder.hpp"
#include "tools/study/clock_skew.hpp"

namespace roadbalance {

int study_clock_skew(const ClockSkewStudyOptions& options) {
  const TemporaryFolder record("rb-clock-skew");
  const nlohmann::ordered_json result = clock_skew({.bus_url = bus_url_on_port(quiet_port(0)),
                                                    .folder = record.path(),
                                                    .seconds = options.seconds,
                                                    .nodes = options.nodes});
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    const auto number = [&](const char* key) { return result[key].get<double>(); };
    std::printf("skew between %d nodes over %.0f s: p50 %.1f us, p99 %.1f us, largest %.1f us\n",
                options.nodes, options.seconds, number("skew_p50_us"), number("skew_p99_us"),
                number("skew_max_us"));
    std::printf("stated uncertainty (median %.1f us) covers %.2f %% of %d windows; %.1f %% kernel stamps\n",
                number("uncertainty_p50_us"), number("covered_percent"), result["windows"].get<int>(),
                number("kernel_stamps_percent"));
    std::printf("%s  skew p99 at most 50 us and 99.9 %% of the windows covered\n",
                result["met"].get<bool>() ? "met    " : "NOT MET");
  }
  return result["met"].get<bool>() ? kDone : kAnswerIsNo;
}

}  // namespace roadbalance
