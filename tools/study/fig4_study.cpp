#include <cmath>
#include <complex>
#include <numbers>

#include "common/dsp/linear_filter.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/exact_covariance.hpp"
#include "tools/study/exact_studies.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFig4Wheel = 0, kFig4Coordinate = kBodyCoordinates + kFig4Wheel;
constexpr int kOrder = 5;
constexpr double kRoadClassA = 16e-6;

/// Sizes of the covariances of the filtered acceleration of the wheel at one speed: of all filter states with
/// the accelerations (Frobenius), of the low-pass output with the wheel's angle and with the road.
struct Sizes {
  double yz, yd, yu;
};

ExactDrive drive_at(double speed_m_s, double corner_hz, double unbalance_kg_m) {
  const VehicleConfig vehicle = demo_vehicle();
  std::array<std::complex<double>, kWheels> unbalance{};
  unbalance[kFig4Wheel] = unbalance_kg_m;
  return {geometry_of(vehicle.model),
          nominal_parameters(vehicle),
          unbalance,
          speed_m_s,
          0.30,
          kRoadClassA,
          butterworth(kOrder, corner_hz),
          corner_hz};
}

/// E[y_k z''] of the wheel's own filter, k = 0 .. 4; instrument j is made of the states j, j + 1, j + 2.
Eigen::Matrix<double, kOrder, kCoordinates> states_with_accelerations(const ExactDrive& drive,
                                                                      double corner_hz) {
  const double wc = 2.0 * std::numbers::pi * corner_hz;
  Eigen::Matrix<double, kOrder, kCoordinates> C;
  const auto first = drive.moments(kFig4Coordinate, 0, 0.0);
  C.row(0) = first.w0 * wc * wc;
  C.row(1) = first.w1 * wc;
  for (int k = 2; k < kOrder; ++k) C.row(k) = drive.moments(kFig4Coordinate, k - 2, 0.0).w2;
  return C;
}

/// C_yz and C_yd of the turning wheel, C_yu of the road.
Sizes sizes_at(double speed_m_s, double corner_hz) {
  const ExactDrive balanced = drive_at(speed_m_s, corner_hz, 0.0);
  const ExactDrive turning = drive_at(speed_m_s, corner_hz, 0.030 * 0.19);
  const double om = turning.omega(kFig4Wheel);
  constexpr int kLowPass = -2;  // instrument whose w'' is state 0
  return {
      (states_with_accelerations(turning, corner_hz) - states_with_accelerations(balanced, corner_hz)).norm(),
      std::abs(turning.with_reference(kFig4Coordinate, kLowPass, 0.0, kFig4Wheel)) / (om * om),
      balanced.with_road(kFig4Coordinate, kLowPass, 0.0).norm()};
}

/// Mean exponent of growth from the lowest speed: ln(C / C_0) / ln(V / V_0).
double exponent(double Sizes::*size, double part, double first_m_s, double corner_hz) {
  return std::log(sizes_at(part * first_m_s, corner_hz).*size / (sizes_at(first_m_s, corner_hz).*size)) /
         std::log(part);
}

struct Setting {
  double corner_hz, first_km_h;
};

StudyResult summarise_fig4(const Json& settings, const std::vector<Json>&) {
  Json curves = Json::array(), exponents = Json::array();
  std::vector<Figure> figures;
  for (const auto& [corner_hz, first_km_h] : {Setting{30.0, 90.0}, {100.0, 60.0}}) {
    const Sizes first = sizes_at(first_km_h / 3.6, corner_hz);
    Figure figure{
        "fig4-" + std::to_string(static_cast<int>(corner_hz)) + "hz",
        "Exact covariances against speed, filter " + std::to_string(static_cast<int>(corner_hz)) + " Hz",
        {"speed / " + std::to_string(static_cast<int>(first_km_h)) + " km/h"},
        {"covariance / its value at the lowest speed", true},
        {{"C_yz", {}, {}}, {"C_yd", {}, {}}, {"C_yu", {}, {}}}};
    for (double part = 1.0; part < 1.701; part += 0.1) {
      const Sizes sizes = sizes_at(part * first_km_h / 3.6, corner_hz);
      curves.push_back({{"filter Hz", corner_hz},
                        {"speed km/h", part * first_km_h},
                        {"C_yz", sizes.yz / first.yz},
                        {"C_yd", sizes.yd / first.yd},
                        {"C_yu", sizes.yu / first.yu}});
      for (const auto& [i, value] :
           {std::pair{0U, sizes.yz / first.yz}, {1U, sizes.yd / first.yd}, {2U, sizes.yu / first.yu}}) {
        figure.series[i].x.push_back(part);
        figure.series[i].y.push_back(value);
      }
    }
    for (const double part : {1.1, 1.7}) {
      const auto of = [&](double Sizes::*size) { return exponent(size, part, first_km_h / 3.6, corner_hz); };
      exponents.push_back({{"filter Hz", corner_hz},
                           {"from km/h", first_km_h},
                           {"to km/h", part * first_km_h},
                           {"C_yz", of(&Sizes::yz)},
                           {"C_yd", of(&Sizes::yd)},
                           {"C_yu", of(&Sizes::yu)}});
    }
    figures.push_back(figure);
  }
  return {{{"settings", settings},
           {"tables",
            {{{"title", "Exact covariances (Lyapunov) of the front left wheel, over their first value"},
              {"rows", curves}},
             {{"title", "Mean exponents of their growth from the lowest speed"}, {"rows", exponents}}}}},
          figures};
}

}  // namespace

Study fig4_study() {
  return {.name = "fig4",
          .line = "the paper's Fig. 4: exact covariances against speed, and their exponents (table 9)",
          .options = {"--svg", "--markdown"},
          .settings = Json::object(),
          .summarise = summarise_fig4};
}

}  // namespace roadbalance
