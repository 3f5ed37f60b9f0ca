#include "common/multibody/expression_matrix.hpp"

#include <algorithm>

namespace roadbalance {

void ExpressionMatrix::add_product(const Expression& factor, const ExpressionRow& a, const ExpressionRow& b) {
  if (factor.is_zero()) return;
  for (std::size_t i = 0; i < rows_; ++i)
    for (std::size_t j = 0; j < columns_; ++j)
      if (!a[i].is_zero() && !b[j].is_zero()) (*this)(i, j) += factor * a[i] * b[j];
}

void ExpressionMatrix::add(const Expression& factor, const ExpressionMatrix& other) {
  for (std::size_t k = 0; k < entry_.size(); ++k)
    if (!other.entry_[k].is_zero()) entry_[k] += factor * other.entry_[k];
}

bool ExpressionMatrix::is_zero() const {
  return std::ranges::all_of(entry_, [](const Expression& x) { return x.is_zero(); });
}

}  // namespace roadbalance
