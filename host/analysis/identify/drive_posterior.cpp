#include "host/analysis/identify/drive_posterior.hpp"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "host/analysis/identify/estimate_report.hpp"

namespace roadbalance {
namespace {

constexpr double kMoreSections = 1.25;

}  // namespace

DrivePosterior::DrivePosterior(const CarPrior& prior, double class_width_m_s)
    : prior_(prior), class_width_m_s_(class_width_m_s), next_search_(kLeastSections - 1) {}

void DrivePosterior::add(const DrivenSection& section) {
  sums_.add(section, class_width_m_s_);
  if (++sections_ < next_search_ || !sums_.has_spectra()) return;
  next_search_ = static_cast<int>(std::ceil(kMoreSections * sections_));
  to_search_ = sums_;
}

void DrivePosterior::replace_lines(std::span<const DrivenSection> sections) {
  for (auto& [key, speed] : sums_.speed) speed.lines = {};
  for (const DrivenSection& section : sections) sums_.at(section, class_width_m_s_).lines += section.lines;
}

std::optional<PosteriorCar> DrivePosterior::solve(const std::optional<DrivenSection>& running) {
  if (to_search_) {
    std::vector<PosteriorSums> drives;
    drives.push_back(*std::exchange(to_search_, std::nullopt));
    car_ = std::make_unique<SolvedCar>(prior_, std::move(drives));
  }
  if (!car_) return std::nullopt;
  PosteriorSums all;
  for (const auto& [key, speed] : sums_.speed) all.speed[key].lines = speed.lines;
  if (running) all.at(*running, class_width_m_s_).lines += running->lines;
  return car_->with(lines_of(all));
}

}  // namespace roadbalance
