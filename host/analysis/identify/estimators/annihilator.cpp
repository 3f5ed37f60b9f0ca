#include "host/analysis/identify/estimators/annihilator.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <stdexcept>

namespace roadbalance {
namespace {

Eigen::Index instruments_of(const ContinuousFilter& filter) {
  if (filter.G.size() < 3) throw std::invalid_argument("a filter of order 3 at least makes instruments");
  return filter.G.size() - 2;
}

}  // namespace

Annihilator annihilator(const ContinuousFilter& filter) {
  const Eigen::Index rows = instruments_of(filter);
  const Eigen::PartialPivLU<Eigen::MatrixXd> F(filter.F);
  Eigen::MatrixXd annihilated(filter.G.size(), 2);
  annihilated.col(0) = F.solve(filter.G);
  annihilated.col(1) = F.solve(annihilated.col(0));
  annihilated.colwise().normalize();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(annihilated, Eigen::ComputeFullU);
  const Eigen::PartialPivLU<Eigen::MatrixXd> F_transposed(filter.F.transpose());
  Annihilator result;
  result.w2 = svd.matrixU().rightCols(rows).transpose();
  result.w1 = F_transposed.solve(result.w2.transpose()).transpose();
  result.w0 = F_transposed.solve(result.w1.transpose()).transpose();
  return result;
}

Annihilator companion_annihilator(const ContinuousFilter& filter) {
  const Eigen::Index rows = instruments_of(filter), order = filter.G.size();
  const double corner = filter.G(order - 1);
  Annihilator result;
  result.w2 = Eigen::MatrixXd::Identity(order, order).bottomRows(rows);
  result.w1 = Eigen::MatrixXd::Identity(order, order).middleRows(1, rows) / corner;
  result.w0 = Eigen::MatrixXd::Identity(order, order).topRows(rows) / (corner * corner);
  return result;
}

}  // namespace roadbalance
