#include "common/multibody/modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>

namespace roadbalance {

double Mode::frequency_hz() const {
  return std::abs(pole) / (2.0 * std::numbers::pi);
}

double Mode::damping() const {
  return -pole.real() / std::abs(pole);
}

std::vector<Mode> modes(const ModelMatrices& model) {
  const Eigen::Index f = model.M.rows();
  const Eigen::LLT<Eigen::MatrixXd> mass(model.M);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2 * f, 2 * f);
  state.topRightCorner(f, f).setIdentity();
  state.bottomLeftCorner(f, f) = -mass.solve(model.Q);
  state.bottomRightCorner(f, f) = -mass.solve(model.P);
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(state);
  std::vector<Mode> all;
  for (Eigen::Index k = 0; k < 2 * f; ++k) {
    Mode mode{solver.eigenvalues()(k), solver.eigenvectors().col(k).head(f)};
    if (mode.pole.imag() < 0.0) continue;
    Eigen::Index largest = 0;
    mode.shape.cwiseAbs().maxCoeff(&largest);
    mode.shape /= std::complex<double>(mode.shape(largest));
    all.push_back(std::move(mode));
  }
  std::ranges::stable_sort(all, {}, [](const Mode& mode) { return std::abs(mode.pole); });
  return all;
}

}  // namespace roadbalance
