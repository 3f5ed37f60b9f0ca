#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/cramer_rao.hpp"
#include "tools/study/estimator_trial.hpp"

namespace roadbalance {

/// A drive behind perfect sensors, and what estimators are asked of it.
struct TrialCase {
  std::string name;
  VehicleConfig vehicle;  ///< the true car
  IdealDrive drive;
  Question question;
  std::vector<EstimatorKind> estimators;
  std::vector<int> wheels;  ///< that are judged
  /// Adds the sensors' errors to the drive; none: exact sensors.
  std::function<void(Stretch& stretch, std::uint64_t seed)> spoil{};
};

/// The demo's car with 30, 20, 25 and 15 g on its wheels, four speeds from 110 to 130 km/h, all unbalances
/// asked for and all else known.
TrialCase four_wheels(const std::string& name, Eigen::Index samples, double rear_coherence2);

/// Asks for the tyres of the case's wheels, too; a search for them begins 10 % off.
void ask_for_tyres(TrialCase& one);

/// Those of `names` that are registered: a study goes on without an estimator that there is not.
std::vector<EstimatorKind> registered(const std::vector<std::string>& names);

/// All cases with one seed: {"seed", CASE: {ESTIMATOR: [errors_of() each wheel]}}.
nlohmann::ordered_json run_cases(const std::vector<TrialCase>& cases, std::uint64_t seed);

/// Errors of one kind, all runs and judged wheels; NaN where nothing is known.
std::vector<double> errors_in(const std::vector<nlohmann::ordered_json>& runs, const TrialCase& one,
                              const std::string& estimator, const char* key);

/// A row for each case and estimator: sizes of the errors over all runs and judged wheels, the bound's
/// standard deviations (root mean square over the wheels) and the efficiencies, bound variance over measured
/// variance: {"case", "estimator", "answers": of runs and wheels, "ct median %", "ct p95 %", "ct sd %", "mass
/// ...", "angle ...", "mass bound %", "efficiency U", "ct bound %", "efficiency ct", and the latter two of
/// the band that the likelihood looks at: above it tyres' belts move}.
nlohmann::ordered_json case_rows(const std::vector<TrialCase>& cases,
                                 const std::vector<nlohmann::ordered_json>& runs);

/// The likelihood's band as columns name it, e.g. "3-40 Hz".
std::string whittle_band();

/// How many answers a row rests on.
std::size_t answers_in(const nlohmann::ordered_json& rows, const std::string& name,
                       const std::string& estimator);

/// A column's value for a case and estimator; NaN: none.
double value_in(const nlohmann::ordered_json& rows, const std::string& name, const std::string& estimator,
                const std::string& column);

/// Standard deviation of U / U_true - 1 per axis, %, over all runs and judged wheels, about the mean of each
/// wheel.
double unbalance_deviation(const std::vector<nlohmann::ordered_json>& runs, const TrialCase& one,
                           const std::string& estimator);

/// A summary of one table.
/// @param acceptance  null: nothing is required; an empty array: what is required was not looked at
nlohmann::ordered_json summary_of(const nlohmann::ordered_json& settings, std::size_t runs,
                                  const std::string& title, const nlohmann::ordered_json& rows,
                                  const nlohmann::ordered_json& acceptance);

}  // namespace roadbalance
