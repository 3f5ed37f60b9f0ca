#pragma once

#include <vector>

#include "common/multibody/algebra.hpp"

namespace roadbalance {

using ExpressionRow = std::vector<Expression>;

/// A matrix of expressions; all 0 at first.
class ExpressionMatrix {
 public:
  ExpressionMatrix() = default;
  ExpressionMatrix(std::size_t rows, std::size_t columns)
      : rows_(rows), columns_(columns), entry_(rows * columns) {}

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  Expression& operator()(std::size_t row, std::size_t column) { return entry_[row * columns_ + column]; }
  const Expression& operator()(std::size_t row, std::size_t column) const {
    return entry_[row * columns_ + column];
  }

  /// + factor a' b
  void add_product(const Expression& factor, const ExpressionRow& a, const ExpressionRow& b);
  /// + factor other
  void add(const Expression& factor, const ExpressionMatrix& other);
  bool is_zero() const;

 private:
  std::size_t rows_ = 0, columns_ = 0;
  std::vector<Expression> entry_;
};

}  // namespace roadbalance
