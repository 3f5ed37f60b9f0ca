#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/dsp/linear_filter.hpp"
#include "host/identify/estimate.hpp"
#include "host/identify/exact_covariance.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/exact_studies.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

constexpr int kWheel = 0;
constexpr double kClassA = 16e-6, kRadius_m = 0.30;
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

/// The car at four speeds, exactly: phasors of its accelerations and all moments of an endless drive.
class EndlessDrive {
 public:
  explicit EndlessDrive(const std::array<Complex, kWheels>& unbalance) : vehicle_(demo_vehicle()) {
    for (const double speed_m_s : speeds_between(110.0, 130.0, 4)) {
      chassis_.push_back(at(speed_m_s, 15.0, unbalance));
      tyre_.push_back(at(speed_m_s, 80.0, unbalance));
    }
  }

  const VehicleConfig& vehicle() const { return vehicle_; }

  /// The front left wheel's unbalance with every parameter taken as known: U = row(Om) Z'' / Om^2 by (1),
  /// speeds weighted by Om^4 as an unbalance's force asks.
  /// @param of  wheel whose order is looked at
  Complex fixed(const ParameterVector& known, int of) const {
    const LinearModel model = linear_model(geometry_of(vehicle_.model), known);
    const int row = kBodyCoordinates + kWheel;
    Complex sum = 0.0;
    double weight = 0.0;
    for (const ExactDrive& drive : tyre_) {
      const double om = drive.omega(of);
      const Eigen::VectorXcd Z = drive.acceleration_phasor(of);
      const Eigen::RowVectorXcd dynamic = model.M.row(row).cast<Complex>() +
                                          model.P.row(row) * Complex(0.0, -1.0 / om) -
                                          (model.Q.row(row) / (om * om)).cast<Complex>();
      sum += om * om * (dynamic * Z).value();
      weight += om * om * om * om;
    }
    return sum / weight;
  }

  /// By solve(): suspension and tyres identified from the same drive.  Its chassis instruments have a lag of
  /// 20 ms; so do those of the tyres here, since the contact patch's memory would else bias them by 1 %.
  std::optional<UnknownVector> identified(const ParameterVector& known) const {
    DriveMoments sum;
    for (std::size_t s = 0; s < tyre_.size(); ++s) add(sum, chassis_[s], tyre_[s]);
    return solve(sum, geometry_of(vehicle_.model), known);
  }

 private:
  ExactDrive at(double speed_m_s, double corner_hz,
                      const std::array<Complex, kWheels>& unbalance) const {
    return {geometry_of(vehicle_.model),
            nominal_parameters(vehicle_),
            unbalance,
            speed_m_s,
            kRadius_m,
            kClassA,
            butterworth(5, corner_hz),
            corner_hz};
  }

  static void add(DriveMoments& sum, const ExactDrive& chassis, const ExactDrive& tyre) {
    constexpr double kLag_s = 0.020;
    sum.sections += 10;
    for (int j = 0; j < kChassisInstrumentsPerSignal; ++j)
      for (int c = 0; c < kCoordinates; ++c) {
        const auto i = static_cast<std::size_t>(j * kCoordinates + c);
        sum.chassis[i] += chassis.moments(c, j, kLag_s);
        sum.chassis_power[i] += chassis.power(c, j);
      }
    for (int w = 0; w < kWheels; ++w) {
      auto& wheel = sum.wheel[static_cast<std::size_t>(w)];
      wheel.tyre += tyre.moments(kBodyCoordinates + w, 1, kLag_s);
      wheel.tyre_unbalance += tyre.with_reference(kBodyCoordinates + w, 1, kLag_s, w);
      const double om = tyre.omega(w);
      const Eigen::RowVectorXcd Z = tyre.acceleration_phasor(w).transpose();
      sum.harmonic.right[static_cast<std::size_t>(w)][static_cast<std::size_t>(w)] +=
          {om * om * Z, om * Z * Complex(0.0, 1.0), -Z};
      sum.harmonic.normal(w, w) += om * om * om * om;
    }
  }

  VehicleConfig vehicle_;
  std::vector<ExactDrive> chassis_, tyre_;
};

StudyResult summarise(const Json& settings, const std::vector<Json>&) {
  std::array<Complex, kWheels> alone{};
  alone[kWheel] = kUnbalance[kWheel];
  const EndlessDrive one(alone), four(kUnbalance);
  const ParameterVector truth = nominal_parameters(one.vehicle());
  const double degrees = 180.0 / std::numbers::pi;
  Json rows = Json::array();
  double worst_percent = 0.0, worst_deg = 0.0, mass_percent = 0.0, mass_deg = 0.0;
  for (const Mistake& mistake : mistakes()) {
    ParameterVector known = truth;
    for (const int p : mistake.parameters) known(p) *= mistake.factor;
    const Complex fixed = one.fixed(known, kWheel) / kUnbalance[kWheel];
    const double spurious = std::abs(four.fixed(known, 1)) / std::abs(kUnbalance[1]);
    const auto x = four.identified(known);
    const Complex in_run =
        x ? Complex((*x)(kEstimatedUnbalance), (*x)(kEstimatedUnbalance + 1)) / kUnbalance[kWheel]
          : Complex(std::nan(""), 0.0);
    const double percent = 100.0 * (std::abs(in_run) - 1.0), deg = std::arg(in_run) * degrees;
    rows.push_back(
        {{"error of vehicle.toml", mistake.name},
         {"fixed: mass %", 100.0 * (std::abs(fixed) - 1.0)},
         {"fixed: angle deg", std::arg(fixed) * degrees},
         {"fixed: of front right's, %", 100.0 * spurious},
         {"identified in the run: mass %", number_or_null(percent)},
         {"identified: angle deg", number_or_null(deg)},
         {"identified: ct %",
          number_or_null(x ? 100.0 * ((*x)(kEstimatedTyre) / truth(kTyre) - 1.0) : std::nan(""))}});
    const std::string name = mistake.name;
    if (name.starts_with("wheel masses")) {
      mass_percent = 100.0 * (std::abs(fixed) - 1.0), mass_deg = std::arg(fixed) * degrees;
    } else if (!name.starts_with("body mass") && name != "stabilisers omitted") {
      // NaN stays: no maximum may lose it.
      worst_percent = std::abs(percent) <= worst_percent ? worst_percent : std::abs(percent);
      worst_deg = std::abs(deg) <= worst_deg ? worst_deg : std::abs(deg);
    }
  }
  const Json lines{
      acceptance_line("identification does not start from springs, dampers, stabilisers, tyres: mass, %",
                      worst_percent, 0.0, 0.5),
      acceptance_line("the same: angle, deg", worst_deg, 0.0, 0.3),
      acceptance_line("wheel masses 5 % off: bias as in table 7, mass, %", mass_percent, 6.2, 6.4),
      acceptance_line("wheel masses 5 % off: bias as in table 7, angle, deg", mass_deg, 3.0, 3.2)};
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
