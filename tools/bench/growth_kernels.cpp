#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra.hpp"
#include "tools/bench/contest.hpp"

// The cost of cross spectra as channels grow: lines of JSON, which tools/bench/growth draws.

namespace roadbalance::bench {
namespace {

struct Point {
  const char* kernel;
  const char* of;  ///< what grows
  Eigen::Index size;
  double work;  ///< products a sample
  Eigen::Index channels;
  Eigen::Index samples;  ///< of each channel, a call
  Contender run;
};

/// All pairs, segments of 4096, Hann, half overlapping.
Point spectra(Eigen::Index channels) {
  constexpr int kSegment = 4096;
  const auto meter = std::make_shared<CrossSpectra>(
      CrossSpectra::Settings{.welch = {.rate_hz = 10'000.0, .segment = kSegment},
                             .channels = static_cast<int>(channels),
                             .memory = 20});
  const auto work = [meter, x = Eigen::MatrixXd(Eigen::MatrixXd::Random(channels, 8 * kSegment))] {
    meter->add(x);
  };
  return {"cross spectra", "channels",   channels, static_cast<double>(channels * (channels + 1) / 2),
          channels,        8 * kSegment, {work}};
}

void run() {
  std::vector<Point> points;
  for (const Eigen::Index channels : {2, 4, 8, 16, 32}) points.push_back(spectra(channels));
  std::vector<Contender> contenders;
  for (Point& point : points) contenders.push_back(std::move(point.run));
  compete(contenders);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point& point = points[k];
    const double ns = 1e9 * median(contenders[k].cpu_s) / static_cast<double>(point.samples);
    std::puts(nlohmann::json{{"kernel", point.kernel},
                             {"of", point.of},
                             {"size", point.size},
                             {"ns_per_channel_sample", ns / static_cast<double>(point.channels)},
                             {"ns_per_product", ns / point.work}}
                  .dump()
                  .c_str());
  }
}

}  // namespace
}  // namespace roadbalance::bench

int main() {
  roadbalance::bench::run();
}
