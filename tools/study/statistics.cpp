#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roadbalance {

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double place = part * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double between = place - static_cast<double>(below);
  if (between == 0.0) return values[below];  // not 0 times infinity
  return values[below] + between * (values[above] - values[below]);
}

double standard_deviation(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (n < 2.0) return std::numeric_limits<double>::quiet_NaN();
  double mean = 0.0, squares = 0.0;
  for (const double value : values) mean += value / n;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / (n - 1.0));
}

ErrorSizes sizes_of(const std::vector<double>& errors) {
  std::vector<double> sizes;
  for (const double error : errors)
    sizes.push_back(std::isfinite(error) ? std::abs(error) : std::numeric_limits<double>::infinity());
  return {quantile(sizes, 0.5), quantile(sizes, 0.95), standard_deviation(errors)};
}

std::size_t answers_among(const std::vector<double>& values) {
  return static_cast<std::size_t>(
      std::count_if(values.begin(), values.end(), [](double value) { return std::isfinite(value); }));
}

ShareLimits share_limits(double probability, std::size_t answers) {
  if (answers == 0) return {0.0, 100.0};
  const double beyond = 0.5 * std::erfc(4.0 / std::numbers::sqrt2);
  const double n = static_cast<double>(answers);
  // How many are still few by chance, if each is right with p.
  const auto fewest = [&](double p) {
    double k = 0.0, sum = 0.0;
    for (;; ++k) {
      sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) +
                      k * std::log(p) + (n - k) * std::log1p(-p));
      if (sum > beyond || k == n) return k;
    }
  };
  return {100.0 * fewest(probability) / n, 100.0 * (n - fewest(1.0 - probability)) / n};
}

nlohmann::ordered_json acceptance_line(const std::string& text, double value, double least, double most,
                                       std::optional<std::size_t> answers) {
  nlohmann::ordered_json line{{"line", text}, {"value", number_or_null(value)}, {"required", {least, most}}};
  if (answers) line["answers"] = *answers;
  line["met"] = value >= least && value <= most && answers != std::size_t{0};
  return line;
}

nlohmann::ordered_json share_line(const std::string& text, double percent, double probability,
                                  std::size_t answers) {
  const ShareLimits limits = share_limits(probability, answers);
  nlohmann::ordered_json line = acceptance_line(text, percent, limits.least, limits.most, answers);
  if (answers > 0 && limits.least <= 0.0 && limits.most >= 100.0) line["met"] = nullptr;
  return line;
}

bool all_met(const nlohmann::ordered_json& acceptance) {
  const auto says = [](bool met) {
    return [met](const nlohmann::ordered_json& line) { return line["met"] == met; };
  };
  return std::any_of(acceptance.begin(), acceptance.end(), says(true)) &&
         std::none_of(acceptance.begin(), acceptance.end(), says(false));
}

}  // namespace roadbalance
