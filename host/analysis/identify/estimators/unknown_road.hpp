#pragma once

#include <map>
#include <optional>
#include <vector>

#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/estimators/relation_equations.hpp"
#include "host/analysis/identify/estimators/relation_prediction.hpp"

namespace roadbalance {

/// Relation (2) with the road not measured, the paper's (25): for each wheel's row, instrument a and lag
/// H C_yu S' is an unknown of its own, the same at every speed V_k but for the factor 1 / lambda_ak,
///
///     A_ak x + c_a / lambda_ak = b_ak.
///
/// lambda is what the current estimate, the instruments' filter and the roads' spectrum, as rough and
/// coherent as the measured C_yz'' tell, make it: 1 / lambda_ak is RelationPrediction::road() at V_k over
/// that at the first speed.  V_k^(w - 1) alone would be right if contact patch and wheelbase did not grow
/// with it.  The road does not depend on the angles: for them it is 0 at every speed, and no unknown.
///
/// The c_a are eliminated and the rest is solved with the instruments that are best for the car found so far,
///
///     sum_k Z_k' (A_k x - b_k) = 0,   Z_k = V_k^-1 (a_k - G_k r),   sum_k Z_k' G_k = 0,
///
/// V the scatter that the road leaves in the means, a the harmonic part of A, G = diag(1 / lambda); linear in
/// x, and repeated with what came out until it stays, 30 times at most.  Z has nothing random in it, so the
/// road's noise in A does not pull x off, however many instruments there are (Source: L. P. Hansen, Large
/// sample properties of generalized method of moments estimators, Econometrica 50 (1982) 1029; W. K. Newey,
/// Efficient instrumental variables estimation of nonlinear models, Econometrica 58 (1990) 809).
///
/// What this costs: at lag 0 and above the random parts of C_yz'' grow from speed to speed as C_yu does, but
/// for the contact patch's corner.  Eliminating the one removes what the others tell of the stiffness, so a
/// leaves them out, and the bound is that of the harmonic part alone: an unbalance tells the tyre under it, a
/// balanced wheel's tyre stays unknown.
///
/// Springs, dampers and stabilisers asked for come first, from the body's rows, on which no road acts.
class UnknownRoad {
 public:
  /// Nothing: the angles and speeds do not determine what is asked.
  /// @throws std::invalid_argument as RelationPrediction
  static std::optional<UnknownRoad> fit(const BySpeed<RelationCovariances>& sums, const Question& question,
                                        const RelationOptions& options);

  /// x with these weights from the sums fitted, or from a part of them.  NaN: stiffness and unbalance of a
  /// wheel without reference, or whose unbalance is not asked for.
  std::optional<UnknownVector> solve(const BySpeed<RelationCovariances>& sums) const;

 private:
  struct Wheel {
    int wheel;
    std::vector<int> unknown;  ///< places in UnknownVector
    std::vector<RelationInstrument> instruments;
    std::map<int, Eigen::MatrixXd> weights;  ///< Z [instrument x unknown] by class of speed
  };

  UnknownRoad(const Question& question, const RelationOptions& options);
  /// The question about the wheels, the suspension asked for being known.
  std::optional<Question> wheels_question(const BySpeed<RelationCovariances>& sums) const;
  void choose(const BySpeed<RelationCovariances>& sums, const Question& wheels, const UnknownVector& start);
  /// @returns whether there are weights for such a car
  bool weigh(const BySpeed<RelationCovariances>& sums, const Question& wheels, const UnknownVector& x);

  Question question_;
  RelationOptions options_;
  std::vector<Wheel> wheels_;
};

}  // namespace roadbalance
