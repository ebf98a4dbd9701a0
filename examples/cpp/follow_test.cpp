#include "follow.hpp"

#include <gtest/gtest.h>

#include <map>

#include "test_server.hpp"

namespace {

Signals step_with(const std::map<std::string_view, double>& readings) {
  return step([&](auto sensor, double unread) { return readings.contains(sensor) ? readings.at(sensor) : unread; });
}

TEST(Step, TurnsOnTheSpotUntilReadingsArrive) {
  const auto [left, right] = step_with({});
  EXPECT_EQ(left, -0.2);
  EXPECT_EQ(right, 0.2);
}

TEST(Step, TurnsLeftOnTheSpotInACorner) {
  const auto [left, right] = step_with({{"ir_front", 0.1}, {"ir_front_left", 0.5}, {"ir_right", 0.3}});
  EXPECT_EQ(left, -0.2);
  EXPECT_EQ(right, 0.2);
}

TEST(Step, DrivesStraightAtTheWantedNearness) {
  const auto [left, right] = step_with({{"ir_front", 0.0}, {"ir_front_left", 0.0}, {"ir_right", wanted}});
  EXPECT_EQ(left, speed);
  EXPECT_EQ(right, speed);
}

TEST(Step, TurnsAwayFromAWallThatIsTooNear) {
  const auto [left, right] = step_with({{"ir_front", 0.0}, {"ir_front_left", 0.0}, {"ir_front_right", 0.8}});
  EXPECT_DOUBLE_EQ(left, 0.2);
  EXPECT_DOUBLE_EQ(right, 0.6);
}

/// Counts the commands that drive forwards.
struct Watched : Follow {
  using Follow::Follow;
  static inline int forwards = 0;

  baudbot::v1::RobotStep answer(const baudbot::v1::RobotTurn& turn) {
    const auto answer = Follow::answer(turn);
    const auto& command = answer.command();
    forwards += command.left_signal() + command.right_signal() > 0.0;
    return answer;
  }
};

TEST(Follow, DrivesUntilTheRunIsOver) {
  const TestServer server;
  setenv("BAUDBOT_CONNECT", server.address().c_str(), 1);
  setenv("BAUDBOT_RECONNECT_S", "0", 1);
  EXPECT_EQ(baudbot::drive<Watched>("follow_test.cpp"), 1000u);
  EXPECT_GT(Watched::forwards, 100);
}

}  // namespace
