#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace roadbalance {

/// Quantile of `values` in any order; an infinity counts as the largest.  NaN: there are none.
/// Between two values linearly, so that quantile(v, 0.5) of an even number is the mean of the middle two.
/// @param part  0 .. 1
double quantile(std::vector<double> values, double part);

/// About their own mean.  NaN: fewer than two values, or one that is not finite.
double standard_deviation(const std::vector<double>& values);

/// @returns median and 95th percentile of the absolute values, and the standard deviation
struct ErrorSizes {
  double median, p95, deviation;
};
/// Errors that are not numbers count as larger than all others.
ErrorSizes sizes_of(const std::vector<double>& errors);

/// How many of the values are known, that is, finite.
std::size_t answers_among(const std::vector<double>& values);

/// Percentages between which the share lies of answers of which each is right with a probability: beyond
/// either limit with no more than that of four standard deviations of a normal distribution, 3.2e-5, by the
/// binomial one.  0 .. 100 for no answers.
/// @param probability  0 < p < 1
struct ShareLimits {
  double least, most;
};
ShareLimits share_limits(double probability, std::size_t answers);

/// A line of acceptance: {"line", "value", "required": [least, most], "answers", "met"}.  No number is never
/// met, nor is one that rests on no answers.
/// @param answers  how many the value rests on, by answers_among(); none: it is not made of answers
nlohmann::ordered_json acceptance_line(const std::string& text, double value, double least, double most,
                                       std::optional<std::size_t> answers = {});

/// The same of a percentage of answers of which each is right with a probability: its limits are
/// share_limits().  "met" is null where these are 0 .. 100, so few answers that the line cannot fail.
nlohmann::ordered_json share_line(const std::string& text, double percent, double probability,
                                  std::size_t answers);

/// Whether every line that is judged is met, and there is one.
bool all_met(const nlohmann::ordered_json& acceptance);

}  // namespace roadbalance
