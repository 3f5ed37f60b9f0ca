#include "host/analysis/balance/verdict.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include "host/analysis/identify/confidence.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

/// Mean square of |U Om^2 + R| over the band, by Simpson's rule of a polynomial of fourth order in Om.
double mean_square(Complex unbalance_kg_m, Complex force_n, double least_rad_s, double greatest_rad_s) {
  constexpr int kPieces = 8;
  double sum = 0.0;
  for (int k = 0; k <= kPieces; ++k) {
    const double omega = least_rad_s + (greatest_rad_s - least_rad_s) * k / kPieces;
    const double weight = k == 0 || k == kPieces ? 1.0 : k % 2 == 1 ? 4.0 : 2.0;
    sum += weight * std::norm(unbalance_kg_m * (omega * omega) + force_n);
  }
  return sum / (3.0 * kPieces);
}

std::string incurable(const Balance& balance, const BalanceVerdict& verdict, const BalanceLimits& limits) {
  char text[kMostReasonBytes + 1] = "";
  const bool perhaps_none = within_own_uncertainty(balance);
  if (balance.force_state == ForceState::kSeparated &&
      balance.force_n - 2.0 * balance.sigma_force_n > limits.force_n)
    std::snprintf(
        text, sizeof text,
        "a force of %.0f ± %.0f N that does not grow with speed² turns with the wheel: match-mount or "
        "replace the tyre, look for a bent rim",
        balance.force_n, balance.sigma_force_n);
  else if (!perhaps_none && balance.force_state == ForceState::kSeparated && verdict.force_left_share > 0.5 &&
           balance.force_n > 3.0 * balance.sigma_force_n)
    std::snprintf(
        text, sizeof text,
        "force that does not grow with speed² (%.0f ± %.0f N) dominates: weights leave %.0f %% of what "
        "turns with the wheel; match-mount or replace the tyre",
        balance.force_n, balance.sigma_force_n, 100.0 * verdict.force_left_share);
  else if (!perhaps_none && balance.unbalance_g - 2.0 * balance.sigma_g > limits.heaviest_g)
    std::snprintf(text, sizeof text,
                  "%.0f ± %.0f g is more than the %.0f g that a sound wheel needs: clean it, look for a lost "
                  "weight or a "
                  "bent rim, turn the tyre on the rim",
                  balance.unbalance_g, balance.sigma_g, limits.heaviest_g);
  return text;
}

}  // namespace

bool within_own_uncertainty(const Balance& balance) {
  const Eigen::Vector2d unbalance_g =
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad));
  return unbalance_g.dot(balance.covariance_g2.ldlt().solve(unbalance_g)) <= kChiSquared95;
}

double permissible_unbalance_g_mm(double grade_mm_s, double mass_kg, double turns_per_min) {
  return 60'000.0 / (2.0 * std::numbers::pi) * grade_mm_s * mass_kg / turns_per_min;
}

BalanceVerdict judge_balance(const Balance& balance, const WeightPlan& plan, double rotor_mass_kg,
                             double rolling_radius_m, const BalanceLimits& limits) {
  BalanceVerdict verdict;
  const double radius_m = balance.weight_radius_m;
  const Complex residual_g =
      plan.residual_g_m(std::polar(balance.unbalance_g * radius_m, balance.angle_rad)) / radius_m;
  verdict.residual_g = std::sqrt(std::norm(residual_g) + balance.covariance_g2.trace());
  verdict.shop_g = limits.shop_g;
  verdict.permissible_grade_mm_s = limits.grade_mm_s;
  const double turns_per_min =
      60.0 * balance.greatest_speed_m_s / (2.0 * std::numbers::pi * rolling_radius_m);
  if (turns_per_min > 0.0) {
    const double per_grade_g =
        permissible_unbalance_g_mm(1.0, rotor_mass_kg, turns_per_min) / (1e3 * radius_m);
    verdict.permissible_g = limits.grade_mm_s * per_grade_g;
    verdict.grade_mm_s = verdict.residual_g / per_grade_g;
  }
  if (balance.force_state == ForceState::kSeparated && turns_per_min > 0.0) {
    const Complex alone = std::polar(1e-3 * balance.alone_g * radius_m, balance.alone_angle_rad);
    const Complex force = std::polar(balance.force_n, balance.force_angle_rad);
    const double least = balance.least_speed_m_s / rolling_radius_m;
    const double greatest = balance.greatest_speed_m_s / rolling_radius_m;
    verdict.force_left_share =
        std::sqrt(mean_square(alone + 1e-3 * plan.applied_g_m, force, least, greatest) /
                  mean_square(alone, force, least, greatest));
  }
  verdict.incurable = incurable(balance, verdict, limits);
  return verdict;
}

}  // namespace roadbalance
