#include "host/analysis/identify/joint_drives.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

/// Shapes of the road that many drives have together.
constexpr std::size_t kMostRoads = 12;

/// Mean square of what the wheels' instruments show; 0: none is there.
double road_power(const DriveMoments& drive) {
  double sum = 0.0;
  for (std::size_t w = 0; w < kWheels; ++w)
    sum += drive.chassis_power[kChassisInstrumentsPerSignal * (kBodyCoordinates + w)];
  return sum / drive.seconds;
}

/// The value that chi^2(k) / k exceeds by chance once in a thousand.
///
/// Source: E. B. Wilson, M. M. Hilferty, The distribution of chi-square, Proc. Nat. Acad. Sci. 17 (1931)
/// 684-688.
double thousandth(double k) {
  constexpr double kNormal = 3.09;
  return std::pow(1.0 - 2.0 / (9.0 * k) + kNormal * std::sqrt(2.0 / (9.0 * k)), 3);
}

}  // namespace

void JointDrives::add(DriveSums drive) {
  time_ns_ = std::max(time_ns_, drive.time_ns);
  for (std::size_t w = 0; w < kWheels; ++w)
    common_sigma_rad_[w] = std::max(common_sigma_rad_[w], drive.common_sigma_rad[w]);
  drift_.add(drive.drift);
  if (drive.classes.empty()) return;
  if (const double power = road_power(drive.classes.total()); joining_.by_road && power > 0.0)
    drive.classes.weigh_road(1.0 / power);
  classes_.add(drive.classes);
  const std::size_t place = added_++ % kMostRoads;
  if (place == roads_.size()) roads_.emplace_back();
  roads_[place] += drive.posterior;
  if (joining_.widened) drives_.add(drive.classes);
}

const DriveEstimate& JointDrives::estimate() {
  std::optional<PosteriorCar> car;
  if (report_.prior() && std::ranges::any_of(roads_, &PosteriorSums::has_spectra)) {
    std::vector<LineMoments> lines;
    for (const PosteriorSums& road : roads_)
      for (LineMoments& each : lines_of(road)) lines.push_back(std::move(each));
    car = SolvedCar(*report_.prior(), roads_).with(lines);
  }
  report_.draw(classes_, car, drift_, time_ns_, drives_);
  return report_.estimate();
}

std::vector<std::string> JointDrives::diagnostics() const {
  std::vector<std::string> sentences = report_.remarks();
  if (drives_.size() < 2) return sentences;
  const double most = thousandth(2.0 * static_cast<double>(drives_.size() - 1));
  for (std::size_t w = 0; w < kWheels; ++w)
    if (const double ratio = report_.drives_ratio()[w]; ratio > most)
      sentences.push_back(format(
          "%s: its unbalance differs between the drives by %.1f times what they scatter in themselves: a "
          "weight that vehicle.toml does not have, or a tyre turned on its rim, between them? the ± holds it",
          kWheelNames[w], std::sqrt(ratio)));
  return sentences;
}

}  // namespace roadbalance
