#include <cmath>
#include <complex>
#include <numbers>

#include "tools/study/endless_drive.hpp"
#include "tools/study/exact_studies.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

constexpr int kWheel = 0;
const std::array<Complex, kWheels> kUnbalance{std::polar(0.030 * 0.19, 0.7), std::polar(0.020 * 0.19, -1.7),
                                              std::polar(0.025 * 0.19, 2.8), std::polar(0.015 * 0.19, 1.3)};

/// What vehicle.toml may be wrong by: parameters times a factor.
struct Mistake {
  const char* name;
  std::vector<int> parameters;
  double factor;
};

std::vector<int> range(int first, int n) {
  std::vector<int> result;
  for (int i = 0; i < n; ++i) result.push_back(first + i);
  return result;
}

std::vector<Mistake> mistakes() {
  return {{"none", {}, 1.0},
          {"body mass, inertias +5 %", range(kBodyMass, 3), 1.05},
          {"wheel masses +5 %", range(kWheelMass, 4), 1.05},
          {"springs +10 %", range(kSpring, 4), 1.10},
          {"dampers +20 %", range(kDamper, 4), 1.20},
          {"stabilisers +20 %", range(kStabiliser, 2), 1.20},
          {"stabilisers omitted", range(kStabiliser, 2), 0.0},
          {"tyres +5 %", range(kTyre, 4), 1.05}};
}

/// Share of the front left wheel's unbalance that is told for it; NaN: none.
Complex told(const std::optional<UnknownVector>& x) {
  if (!x) return {std::nan(""), 0.0};
  return Complex((*x)(kEstimatedUnbalance), (*x)(kEstimatedUnbalance + 1)) / kUnbalance[kWheel];
}

/// Keeps a NaN: no maximum may lose it.
void raise(double& worst, double value) {
  if (!(std::abs(value) <= worst)) worst = std::abs(value);
}

StudyResult summarise(const Json& settings, const std::vector<Json>&) {
  std::array<Complex, kWheels> alone{};
  alone[kWheel] = kUnbalance[kWheel];
  const EndlessDrive one(alone), four(kUnbalance);
  const ParameterVector truth = nominal_parameters(one.vehicle());
  const auto percent = [](Complex share) { return 100.0 * (std::abs(share) - 1.0); };
  const auto degrees = [](Complex share) { return std::arg(share) * 180.0 / std::numbers::pi; };
  const auto tyre_percent = [&](const std::optional<UnknownVector>& x) {
    return x ? 100.0 * ((*x)(kEstimatedTyre) / truth(kTyre) - 1.0) : std::nan("");
  };
  Json rows = Json::array();
  double worst_percent = 0.0, worst_deg = 0.0;
  Complex mass_fixed, mass_instrument, mass_likelihood;
  for (const Mistake& mistake : mistakes()) {
    ParameterVector known = truth;
    for (const int p : mistake.parameters) known(p) *= mistake.factor;
    const Complex fixed = one.fixed(known, kWheel, kWheel) / kUnbalance[kWheel];
    const double spurious = std::abs(four.fixed(known, kWheel, 1)) / std::abs(kUnbalance[1]);
    const auto x = four.identified(known), y = four.identified_by_likelihood(known);
    const Complex instrument = told(x), likelihood = told(y);
    rows.push_back({{"error of vehicle.toml", mistake.name},
                    {"fixed: mass %", percent(fixed)},
                    {"fixed: angle deg", degrees(fixed)},
                    {"fixed: of front right's, %", 100.0 * spurious},
                    {"in the run: mass %", number_or_null(percent(instrument))},
                    {"in the run: angle deg", number_or_null(degrees(instrument))},
                    {"in the run: ct %", number_or_null(tyre_percent(x))},
                    {"by likelihood: mass %", number_or_null(percent(likelihood))},
                    {"by likelihood: angle deg", number_or_null(degrees(likelihood))},
                    {"by likelihood: ct %", number_or_null(tyre_percent(y))}});
    const std::string name = mistake.name;
    if (name.starts_with("wheel masses")) {
      mass_fixed = fixed, mass_instrument = instrument, mass_likelihood = likelihood;
    } else if (!name.starts_with("body mass")) {
      for (const Complex share : {instrument, likelihood}) {
        raise(worst_percent, percent(share));
        raise(worst_deg, degrees(share));
      }
    }
  }
  const Json lines{
      acceptance_line("springs, dampers, stabilisers, tyres off, identified in the run: mass, %",
                      worst_percent, 0.0, 0.5),
      acceptance_line("the same: angle, deg", worst_deg, 0.0, 0.3),
      acceptance_line("wheel masses 5 % off: bias as in table 7, mass, %", percent(mass_fixed), 6.2, 6.4),
      acceptance_line("wheel masses 5 % off: bias as in table 7, angle, deg", degrees(mass_fixed), 3.0, 3.2),
      acceptance_line("the same identified in the run, instrument against likelihood, %",
                      100.0 * std::abs(mass_instrument - mass_likelihood), 0.0, 0.5)};
  return {
      {{"settings", settings},
       {"tables", {{{"title", "Bias of the front left unbalance, exact, 110 .. 130 km/h"}, {"rows", rows}}}},
       {"acceptance", lines},
       {"accepted", all_met(lines)}},
      {}};
}

}  // namespace

Study parameters_study() {
  return {.name = "parameters",
          .line =
              "what wrong parameters in vehicle.toml do to the unbalance, without and with identification "
              "(table 7)",
          .options = {"--markdown"},
          .settings = Json::object(),
          .summarise = summarise};
}

}  // namespace roadbalance
