#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/lagged_covariance.hpp"
#include "tools/bench/contest.hpp"

// What the sums of covariances and of cross spectra take as channels and lags grow: lines of JSON, which
// tools/bench/growth draws.

namespace roadbalance::bench {
namespace {

constexpr Eigen::Index kSamples = 256;
constexpr int kOrder = 5;

struct Point {
  const char* kernel;
  const char* of;  ///< what grows
  Eigen::Index size;
  double work;  ///< products a sample
  Eigen::Index channels;
  Eigen::Index samples;  ///< of each channel, a call
  Contender run;
};

/// States of so many channels with these channels at so many lags.
Point covariance(const char* of, Eigen::Index size, Eigen::Index channels, Eigen::Index lags) {
  const Eigen::Index states = channels * kOrder;
  const auto work = [y = Eigen::MatrixXd(Eigen::MatrixXd::Random(states, kSamples)),
                     z = Eigen::MatrixXd(Eigen::MatrixXd::Random(channels, kSamples + lags - 1)),
                     sum = Eigen::MatrixXd(Eigen::MatrixXd::Zero(states, channels * lags))]() mutable {
    add_lagged_products(y, z, sum);
  };
  return {"covariance", of, size, static_cast<double>(states * channels * lags), channels, kSamples, {work}};
}

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
  for (const Eigen::Index lags : {1, 2, 4, 8, 16, 32, 64})
    points.push_back(covariance("lags", lags, 16, lags));
  for (const Eigen::Index channels : {2, 4, 8, 16, 32})
    points.push_back(covariance("channels", channels, channels, 16));
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
