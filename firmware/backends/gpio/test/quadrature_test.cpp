#include "firmware/backends/gpio/quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace roadbalance {
namespace {

/// Two tracks of a transducer as they are made: levels as functions of the angle in pitches.
class Transducer {
 public:
  explicit Transducer(double at) : at_(at) { quadrature.start(first(at), second(at)); }

  /// Turns by small steps; what the teeth on the way were.
  std::vector<EdgeKind> turn_to(double to) {
    std::vector<EdgeKind> kinds;
    const double step = to > at_ ? 1.0 / 64 : -1.0 / 64;
    for (auto steps = std::llround((to - at_) / step); steps > 0; --steps) {
      const double before = at_;
      at_ += step;
      if (first(at_) != first(before)) take(Quadrature::kA, first(at_), kinds);
      if (second(at_) != second(before)) take(Quadrature::kB, second(at_), kinds);
    }
    return kinds;
  }

  Quadrature quadrature;
  int lost = 0;

 private:
  void take(Quadrature::Track track, bool rising, std::vector<EdgeKind>& kinds) {
    const auto taken = quadrature.take(track, rising);
    lost += taken.lost ? 1 : 0;
    if (taken.tooth) kinds.push_back(*taken.tooth);
  }
  static double phase(double at) { return at - std::floor(at); }
  static bool first(double at) { return phase(at) < 0.5; }
  static bool second(double at) { return phase(at - 0.25) < 0.5; }

  double at_;
};

using Kinds = std::vector<EdgeKind>;
constexpr EdgeKind kForward = EdgeKind::kTooth, kBackward = EdgeKind::kToothBackward;
constexpr double kBetweenSteps = 1.0 / 256;

TEST(Quadrature, KnowsForwardFromBackward) {
  Transducer transducer(0.1 + kBetweenSteps);
  EXPECT_EQ(transducer.turn_to(5.6), Kinds(5, kForward));
  EXPECT_EQ(transducer.turn_to(-4.9), Kinds(10, kBackward));
  EXPECT_EQ(transducer.turn_to(3.6), Kinds(8, kForward));
  EXPECT_EQ(transducer.lost, 0);
}

// A standing wheel that trembles gets nowhere, wherever in the pitch it stands and however far it trembles.
TEST(Quadrature, ATremblingWheelGoesNowhere) {
  for (const double reach : {0.1, 0.2, 0.3, 0.6, 1.1})
    for (int place = 0; place < 32; ++place) {
      const double middle = place / 32.0 + kBetweenSteps;
      Transducer transducer(middle);
      int turned = 0;
      for (int k = 0; k < 20; ++k)
        for (const double to : {middle + reach, middle - reach})
          for (const EdgeKind kind : transducer.turn_to(to)) turned += kind == kForward ? 1 : -1;
      EXPECT_LE(std::abs(turned), static_cast<int>(std::ceil(reach))) << place << " " << reach;
      EXPECT_EQ(transducer.lost, 0) << place << " " << reach;
    }
}

TEST(Quadrature, SaysOnceThatAnEdgeOfATrackIsMissing) {
  for (const auto track : {Quadrature::kA, Quadrature::kB}) {
    Quadrature quadrature;
    quadrature.start(false, false);
    EXPECT_FALSE(quadrature.take(track, true).lost);
    EXPECT_TRUE(quadrature.take(track, true).lost) << "the falling edge between is missing";
    EXPECT_FALSE(quadrature.take(track, false).lost);
  }
}

TEST(Quadrature, ClaimsNoDirectionBeforeItKnowsTheSecondTrack) {
  Quadrature quadrature;
  quadrature.forget();
  EXPECT_FALSE(quadrature.take(Quadrature::kA, true).tooth);
  quadrature.take(Quadrature::kB, true);
  EXPECT_FALSE(quadrature.take(Quadrature::kA, false).tooth);
  quadrature.take(Quadrature::kB, false);
  EXPECT_EQ(quadrature.take(Quadrature::kA, true).tooth, kForward);
}

// Between taking a line and reading its level an edge may come.
TEST(Quadrature, TrustsTheFirstEdgeMoreThanTheLevelRead) {
  Quadrature quadrature;
  quadrature.start(true, true);
  EXPECT_FALSE(quadrature.take(Quadrature::kA, true).lost);
  EXPECT_FALSE(quadrature.take(Quadrature::kB, true).lost);
}

}  // namespace
}  // namespace roadbalance
