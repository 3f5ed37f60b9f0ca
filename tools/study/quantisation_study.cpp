#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/random.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/study/trial_cases.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kRange_m_s2 = 50.0 * 9.80665;
const char* const kExact = "exact";
const char* const k12Bit = "12 bit, +-50 g";

/// Passes the drive through eight sensors and their converters: on the body above each wheel, and on each
/// wheel carrier.
void pass_sensors(Stretch& stretch, const Geometry& geometry, std::uint64_t seed, double noise_m_s2,
                  int bits) {
  Eigen::Matrix<double, 2 * kWheels, kCoordinates> sensors = decltype(sensors)::Zero();
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    sensors.row(i).head<3>() << 1.0, geometry.y_m[w], -geometry.x_m[w];
    sensors(kWheels + i, kBodyCoordinates + i) = 1.0;
  }
  const Eigen::MatrixXd back = sensors.completeOrthogonalDecomposition().pseudoInverse();
  Eigen::MatrixXd seen = sensors * stretch.signals.topRows<kCoordinates>();
  const auto speed = static_cast<std::uint64_t>(std::llround(1e3 * stretch.speed_m_s));
  const double step = bits > 0 ? 2.0 * kRange_m_s2 / std::pow(2.0, bits) : 0.0;
  for (Eigen::Index s = 0; s < seen.rows(); ++s) {
    const sim::RandomSequence random(seed, sim::Use::kSensorNoise,
                                     100 * speed + static_cast<std::uint64_t>(s));
    for (Eigen::Index k = 0; k < seen.cols(); ++k) {
      seen(s, k) += noise_m_s2 * random.normal(k);
      if (bits > 0) seen(s, k) = step * std::round(seen(s, k) / step);
    }
  }
  stretch.signals.topRows<kCoordinates>() = back * seen;
}

const int kBits[] = {8, 10, 12, 14, 16, 24};
const double kNoiseCases_m_s2[] = {0.02, 0.1, 0.5};

std::string of_bits(int bits) {
  return std::to_string(bits) + " bit, +-50 g";
}
std::string of_noise(double noise_m_s2) {
  return Json(noise_m_s2).dump() + " m/s2 white noise";
}

std::vector<TrialCase> quantisation_cases(const Json& settings) {
  std::vector<TrialCase> cases;
  const auto add = [&](const std::string& name, double noise_m_s2, int bits) {
    TrialCase one = four_wheels(name, settings["samples"].get<Eigen::Index>(), 0.95);
    ask_for_tyres(one);
    one.estimators = registered({"own-past", "whittle", "cancellation"});
    if (name != kExact)
      one.spoil = [geometry = one.question.geometry, noise_m_s2, bits](Stretch& stretch, std::uint64_t seed) {
        pass_sensors(stretch, geometry, seed, noise_m_s2, bits);
      };
    cases.push_back(one);
  };
  add(kExact, 0.0, 0);
  for (const int bits : kBits) add(of_bits(bits), 0.0, bits);
  for (const double noise : kNoiseCases_m_s2) add(of_noise(noise), noise, 0);
  return cases;
}

Json run_quantisation(const StudyRun& run) {
  return run_cases(quantisation_cases(run.settings), run.seed);
}

/// Root mean square of what a case adds to the exact one's errors.
double added(const std::vector<Json>& runs, const TrialCase& one, const TrialCase& exact,
             const std::string& estimator, std::initializer_list<const char*> keys) {
  double sum = 0.0, count = 0.0;
  for (const char* key : keys) {
    const auto with = errors_in(runs, one, estimator, key), without = errors_in(runs, exact, estimator, key);
    for (std::size_t i = 0; i < with.size(); ++i) sum += std::pow(with[i] - without[i], 2), count += 1.0;
  }
  return std::sqrt(sum / count);
}

/// Growth of the errors of each estimator's unbalances and tyres over an axis of cases.
Figure figure_of(const Json& rows, const std::string& name, const std::string& title, const Axis& axis,
                 const auto& values, const auto& case_of) {
  Figure figure{name, title, axis, {"added, rms %", true}, {}};
  for (const char* estimator : {"own-past", "whittle", "cancellation"})
    for (const char* what : {"U", "ct"}) {
      Series series{std::string(estimator) + ", " + what, {}, {}, what == std::string("ct")};
      for (const auto value : values) {
        series.x.push_back(value);
        series.y.push_back(
            value_in(rows, case_of(value), estimator, std::string("added to ") + what + ", rms %"));
      }
      figure.series.push_back(series);
    }
  return figure;
}

StudyResult summarise_quantisation(const Json& settings, const std::vector<Json>& runs) {
  const std::vector<TrialCase> cases = quantisation_cases(settings);
  Json rows = Json::array();
  for (std::size_t i = 1; i < cases.size(); ++i)
    for (const EstimatorKind& kind : cases[i].estimators)
      rows.push_back({{"case", cases[i].name},
                      {"estimator", kind.name},
                      {"added to U, rms %", number_or_null(added(runs, cases[i], cases[0], kind.name,
                                                                 {"re_percent", "im_percent"}))},
                      {"added to ct, rms %",
                       number_or_null(added(runs, cases[i], cases[0], kind.name, {"tyre_percent"}))}});
  const TrialCase& bits12 =
      *std::find_if(cases.begin(), cases.end(), [](const TrialCase& c) { return c.name == k12Bit; });
  const Json lines =
      Json::array({acceptance_line("whittle: 12 bit at +-50 g add to the unbalance, rms %",
                                   value_in(rows, k12Bit, "whittle", "added to U, rms %"), 0.0, 0.1,
                                   answers_among(errors_in(runs, bits12, "whittle", "mass_percent")))});
  return {summary_of(settings, runs.size(), "What converters and noise add, against the same drives without",
                     rows, lines),
          {figure_of(rows, "quantisation", "What converters add to the errors", {"bits at +-50 g"}, kBits,
                     of_bits),
           figure_of(rows, "noise", "What white noise adds to the errors", {"noise, m/s2", true},
                     kNoiseCases_m_s2, of_noise)}};
}

}  // namespace

Study quantisation_study() {
  return {.name = "quantisation",
          .line = "what converters of 8 to 24 bits and white noise add to the errors",
          .options = kIdealOptions,
          .settings = {{"samples", 20000}},
          .runs = 10,
          .run = run_quantisation,
          .summarise = summarise_quantisation};
}

}  // namespace roadbalance
