#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "tools/study/endless_drive.hpp"
#include "tools/study/exact_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

constexpr int kStudiedWheel = 0;
const std::array<Complex, kWheels> kUnbalanceOfWheel{
    std::polar(0.030 * 0.19, 0.7), std::polar(0.020 * 0.19, -1.7), std::polar(0.025 * 0.19, 2.8),
    std::polar(0.015 * 0.19, 1.3)};

/// The car as vehicle.toml describes it.
struct Described {
  Geometry geometry;
  ParameterVector value;

  void scale(int first, int n, double factor) { value.segment(first, n) *= factor; }
};

/// Errors that vehicle.toml may have.
struct Mistake {
  const char* name;
  std::function<void(Described&)> make;
  bool told = false;  ///< the drive determines its true value: springs, dampers, stabilisers, tyres
};

constexpr const char* kHeavyWheels = "wheel masses +5 %";

Mistake scaled(const char* name, int first, int n, double factor, bool told = false) {
  return {name, [=](Described& car) { car.scale(first, n, factor); }, told};
}

std::vector<Mistake> mistakes() {
  return {{"none", [](Described&) {}, true},
          scaled("body mass, inertias +5 %", kBodyMass, 3, 1.05),
          scaled(kHeavyWheels, kWheelMass, 4, 1.05),
          scaled("springs +10 %", kSpring, 4, 1.10, true),
          scaled("dampers +20 %", kDamper, 4, 1.20, true),
          scaled("stabilisers +20 %", kStabiliser, 2, 1.20, true),
          scaled("stabilisers omitted", kStabiliser, 2, 0.0, true),
          scaled("tyres +5 %", kTyre, 4, 1.05, true),
          scaled("body mass +1 %", kBodyMass, 1, 1.01),
          scaled("roll inertia +1 %", kRollInertia, 1, 1.01),
          scaled("pitch inertia +1 %", kPitchInertia, 1, 1.01),
          scaled("wheel masses +1 %", kWheelMass, 4, 1.01),
          {"tyre dampers +50 N s/m",
           [](Described& car) { car.value.segment(kTyreDamper, kWheels).array() += 50.0; }},
          {"half track +1 %",
           [](Described& car) {
             for (double& y_m : car.geometry.y_m) y_m *= 1.01;
           }},
          {"centre of mass 27 mm further back", [](Described& car) {
             for (double& x_m : car.geometry.x_m) x_m += 0.027;
           }}};
}

/// Estimated share of the front left wheel's unbalance; NaN: none.
Complex told(const std::optional<UnknownVector>& x) {
  if (!x) return {std::nan(""), 0.0};
  return Complex((*x)(kEstimatedUnbalance), (*x)(kEstimatedUnbalance + 1)) / kUnbalanceOfWheel[kStudiedWheel];
}

/// Keeps a NaN: no maximum may lose it.
void raise(double& worst, double value) {
  if (!(std::abs(value) <= worst)) worst = std::abs(value);
}

/// Bias of the mass against the error of the value in vehicle.toml, taken as known and identified in the run.
Figure figure_of(const EndlessDrive& one, const EndlessDrive& four) {
  Figure figure{"parameters",
                "Bias of the front left mass, 110 .. 130 km/h",
                {"error of vehicle.toml, %"},
                {"bias of the mass, %"},
                {}};
  struct Kind {
    const char* name;
    int first, n;
  };
  for (const auto& [name, first, n] : {Kind{"wheel masses", kWheelMass, kWheels},
                                       {"dampers", kDamper, kWheels},
                                       {"springs", kSpring, kWheels},
                                       {"tyres", kTyre, kWheels}}) {
    Series fixed{std::string(name) + ", fixed", {}, {}},
        in_the_run{std::string(name) + ", in the run", {}, {}, true, false};
    for (const double percent : {-20.0, -10.0, 0.0, 10.0, 20.0}) {
      Described known{geometry_of(one.vehicle().model), nominal_parameters(one.vehicle())};
      known.scale(first, n, 1.0 + 0.01 * percent);
      const auto bias = [](Complex share) { return 100.0 * (std::abs(share) - 1.0); };
      fixed.x.push_back(percent), in_the_run.x.push_back(percent);
      fixed.y.push_back(bias(one.fixed(known.geometry, known.value, kStudiedWheel, kStudiedWheel) /
                             kUnbalanceOfWheel[kStudiedWheel]));
      in_the_run.y.push_back(bias(told(four.identified(known.geometry, known.value))));
    }
    figure.series.push_back(fixed), figure.series.push_back(in_the_run);
  }
  return figure;
}

StudyResult summarise_parameters(const Json& settings, const std::vector<Json>&) {
  std::array<Complex, kWheels> alone{};
  alone[kStudiedWheel] = kUnbalanceOfWheel[kStudiedWheel];
  const EndlessDrive one(alone), four(kUnbalanceOfWheel);
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
    Described known{geometry_of(one.vehicle().model), truth};
    mistake.make(known);
    const auto& [geometry, value] = known;
    const Complex fixed =
        one.fixed(geometry, value, kStudiedWheel, kStudiedWheel) / kUnbalanceOfWheel[kStudiedWheel];
    const double spurious =
        std::abs(four.fixed(geometry, value, kStudiedWheel, 1)) / std::abs(kUnbalanceOfWheel[1]);
    const auto x = four.identified(geometry, value), y = four.identified_by_likelihood(geometry, value);
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
    if (mistake.name == std::string(kHeavyWheels)) {
      mass_fixed = fixed, mass_instrument = instrument, mass_likelihood = likelihood;
    } else if (mistake.told) {
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
      {figure_of(one, four)}};
}

}  // namespace

Study parameters_study() {
  return {.name = "parameters",
          .line =
              "what wrong parameters in vehicle.toml do to the unbalance, without and with identification "
              "(table 7)",
          .options = {"--svg", "--markdown"},
          .settings = Json::object(),
          .summarise = summarise_parameters};
}

}  // namespace roadbalance
