// The plane's parameters and their derivatives.
#include <gtest/gtest.h>

#include "stages/ground/ground_plane.h"
#include "stages/ground/scale_votes.h"

namespace pavo {
namespace {

TEST(GroundPlane, AttitudeAndDownAreInverse) {
  for (const double pitch : {-0.4, -0.03, 0.0, 0.2})
    for (const double roll : {-0.3, 0.0, 0.05}) {
      const Eigen::Vector3d n = down_of({pitch, roll});
      EXPECT_NEAR(n.norm(), 1, 1e-12);
      const GroundAttitude a = attitude_of(3.7 * n);
      EXPECT_NEAR(a.pitch_rad, pitch, 1e-12);
      EXPECT_NEAR(a.roll_rad, roll, 1e-12);
    }
}

TEST(GroundPlane, ACameraThatLooksDownSeesTheGroundNearerAhead) {
  const Eigen::Vector3d ahead(0, 0, 1);
  EXPECT_GT(down_of({-0.1, 0}).dot(ahead), 0);
  EXPECT_LT(down_of({0.1, 0}).dot(ahead), 0);
}

TEST(GroundPlane, DerivativeIsTheNumericOne) {
  const GroundAttitude a{-0.07, 0.04};
  constexpr double h = 1e-6;
  Eigen::Matrix<double, 3, 2> numeric;
  numeric.col(0) = (down_of({a.pitch_rad + h, a.roll_rad}) - down_of({a.pitch_rad - h, a.roll_rad})) / (2 * h);
  numeric.col(1) = (down_of({a.pitch_rad, a.roll_rad + h}) - down_of({a.pitch_rad, a.roll_rad - h})) / (2 * h);
  EXPECT_LT((numeric - down_derivative(a)).norm(), 1e-8);
}

// People who go along with the camera look right wherever they are taken to be; ground does not.
TEST(ScaleVotes, APlateauIsWide) {
  ScaleVotes ground, people;
  const int middle = ScaleVotes::bin_of(1.7);
  for (int i = -10; i <= 10; ++i) {
    ground.add(middle + i, std::exp(-0.5 * i * i / 9.0));
    people.add(middle + i, 1 - 0.03 * std::abs(i));
  }
  EXPECT_NEAR(ground.peak().width, 7, 1);
  EXPECT_EQ(people.peak().width, 21);
  EXPECT_EQ(people.peak().bin, middle);
}

TEST(ScaleVotes, TheSteadyPeakOutlivesThePassingOnes) {
  ScaleVotes votes;
  for (int look = 0; look < 12; ++look) {
    votes.fade(0.9);
    votes.add(ScaleVotes::bin_of(1.7), 0.1);
    votes.add((look * 37) % ScaleVotes::kBins, 0.2);
  }
  const ScaleVotes::Peak peak = votes.peak();
  EXPECT_NEAR(std::log(ScaleVotes::scale_of(peak.bin)), std::log(1.7), ScaleVotes::kStep);
  EXPECT_GT(peak.votes, 2 * peak.second);
}

}  // namespace
}  // namespace pavo
