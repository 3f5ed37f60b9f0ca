#pragma once

#include <memory>
#include <optional>
#include <span>

#include "host/analysis/identify/posterior_car.hpp"
#include "host/analysis/identify/posterior_sums.hpp"

namespace roadbalance {

/// The most probable car of a drive that goes on.
///
/// Its lines are heard with every section, and with the one that is being driven as far as it goes.  The
/// search for the car takes a hundred times as long: it is done first when the section that follows makes
/// them kLeastSections, and anew when a quarter more are there, for whoever asks next.  The result is a
/// function of the sections so far.
class DrivePosterior {
 public:
  DrivePosterior(const CarPrior& prior, double class_width_m_s);

  void add(const DrivenSection& section);
  /// The lines of all sections so far, weighed by better knowledge.
  void replace_lines(std::span<const DrivenSection> sections);

  const PosteriorSums& sums() const { return sums_; }
  /// Nothing: too short yet, or the search came to no end.
  std::optional<PosteriorCar> solve(const std::optional<DrivenSection>& running = std::nullopt);

 private:
  CarPrior prior_;
  double class_width_m_s_;
  PosteriorSums sums_;
  int sections_ = 0, next_search_;
  std::optional<PosteriorSums> to_search_;  ///< sums as they were when the search was due
  std::unique_ptr<SolvedCar> car_;
};

}  // namespace roadbalance
