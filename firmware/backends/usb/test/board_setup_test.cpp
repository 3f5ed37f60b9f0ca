#include "firmware/backends/usb/board_setup.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "common/config/section.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance {
namespace {

board::Identity identity() {
  board::Identity identity;
  identity.capabilities = board::kHasReferences | board::kHasQuadrature | board::kHasSync;
  identity.tick_hz = 10'000'000;
  identity.rate_min_hz = 100;
  identity.rate_max_hz = 20'000;
  identity.filter_min_hz = 10;
  identity.filter_max_hz = 5000;
  identity.filter_orders = 1u << 4 | 1u << 6;
  identity.full_scale_uv = {10'000'000, 5'000'000, 2'500'000, 1'250'000};
  return identity;
}

VehicleConfig vehicle() {
  VehicleConfig vehicle = test::one_node_vehicle(10'000.0, 1000);
  vehicle.node[0].channel.resize(12, vehicle.node[0].channel[0]);
  return vehicle;
}

LineConfig at_gpio(int line) {
  LineConfig config;
  config.line = line;
  config.tooth_gpio = 4;
  return config;
}

TEST(BoardSetup, AsksForWhatTheVehicleSays) {
  VehicleConfig car = vehicle();
  car.node[0].wiring.loop_back = true;
  car.node[0].channel[3].input_range_v = 2.5;
  car.wheel[1].encoder.quadrature = true;
  car.wheel[1].encoder.zero_mark = false;
  car.wheel[0].encoder.datum_rad = std::numbers::pi / 2.0;
  const auto [configuration, references] = board_setup(car, car.node[0], identity(), 0, 1);
  EXPECT_EQ(configuration.ticks_per_scan, 1000u);
  EXPECT_EQ(configuration.filter_order, 6);
  EXPECT_EQ(configuration.filter_corner_hz, 200u);
  EXPECT_EQ(configuration.range[3], 2);
  EXPECT_EQ(configuration.range[4], 0) << "the widest";
  EXPECT_EQ(configuration.encoder[0].pulses_per_turn, 1000);
  EXPECT_EQ(configuration.encoder[0].flags, board::kZeroWired);
  EXPECT_EQ(configuration.encoder[1].flags, board::kQuadrature);
  EXPECT_EQ(configuration.references_on, 1);
  EXPECT_EQ(references.wheel[0].on, 1);
  EXPECT_EQ(references.wheel[1].line, 1);
  EXPECT_EQ(references.wheel[0].datum, 1 << 30) << "a quarter turn";
}

TEST(BoardSetup, GivesTheSecondOfTwoBoardsTheOtherHalfOfTheChannelsAndNoEncoders) {
  VehicleConfig car = vehicle();
  car.node[0].channel[2].input_range_v = 5.0;
  car.node[0].channel[8].input_range_v = 1.25;
  const auto first = board_setup(car, car.node[0], identity(), 0, 2).configuration;
  const auto second = board_setup(car, car.node[0], identity(), 1, 2).configuration;
  EXPECT_EQ(first.range[2], 1);
  EXPECT_EQ(second.range[2], 3);
  EXPECT_EQ(first.encoder[1].pulses_per_turn, 1000);
  EXPECT_EQ(second.encoder[1].pulses_per_turn, 0);
  EXPECT_EQ(second.references_on, 0);
  EXPECT_EQ(second.ticks_per_scan, first.ticks_per_scan);
}

TEST(BoardSetup, LeavesAnEncoderAloneThatIsWiredToGpio) {
  VehicleConfig car = vehicle();
  car.node[0].wiring.line.push_back(at_gpio(1));
  const auto configuration = board_setup(car, car.node[0], identity(), 0, 1).configuration;
  EXPECT_NE(configuration.encoder[0].pulses_per_turn, 0);
  EXPECT_EQ(configuration.encoder[1].pulses_per_turn, 0);
}

TEST(BoardSetup, NamesTheKeyWhoseValueTheBoardDoesNotHave) {
  using Change = std::function<void(VehicleConfig&, board::Identity&)>;
  for (const auto
           & [named, change] : std::vector<std::pair<
               std::string,
               Change>>{{"rate_hz: 10000 cannot be had of the board; allowed: 100 to 8000",
                         [](VehicleConfig&, board::Identity&board) { board.rate_max_hz = 8000; }},
                        {"rate_hz: 6000 is no whole number",
                         [](VehicleConfig&car, board::Identity&) { car.node[0].rate_hz = 6000; }},
                        {"filter: order: 5 cannot be had of the board; allowed: 4, 6",
                         [](VehicleConfig&car, board::Identity&) { car.filter.order = 5; }},
                        {"filter: cutoff_hz: 200.5",
                         [](VehicleConfig&car, board::Identity&) { car.filter.cutoff_hz = 200.5; }},
                        {"filter: cutoff_hz: 8 ",
                         [](VehicleConfig&car, board::Identity&) { car.filter.cutoff_hz = 8; }},
                        {"channel up: input_range_v: 3 cannot be had of the board; allowed: 10, 5, 2.5, 1.25",
                         [](VehicleConfig&car, board::Identity&) {
                           car.node[0].channel[0].input_range_v = 3;
                         }},
                        {"wheel front_right: encoder: pulses_per_turn: 2 ",
                         [](VehicleConfig&car, board::Identity&) {
                           car.wheel[1].encoder.pulses_per_turn = 2;
                         }},
                        {"wheel front_left: encoder: quadrature",
                         [](VehicleConfig&car, board::Identity&board) {
                           car.wheel[0].encoder.quadrature = true;
                           board.capabilities &= ~std::uint32_t{board::kHasQuadrature};
                         }},
                        {"node axle: loop_back: the board gives no references",
                         [](VehicleConfig&car, board::Identity&board) {
                           car.node[0].wiring.loop_back = true;
                           board.capabilities = 0;
                         }},
                        {"node axle: loop_back: the encoder of line 0",
                         [](VehicleConfig&car, board::Identity&) {
                           car.node[0].wiring.loop_back = true;
                           car.node[0].wiring.line.push_back(at_gpio(0));
                         }}}) {
    VehicleConfig car = vehicle();
    board::Identity board = identity();
    change(car, board);
    try {
      board_setup(car, car.node[0], board, 0, 1);
      ADD_FAILURE() << named;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  }
}

TEST(BoardSetup, TwoBoardsNeedSync) {
  const VehicleConfig car = vehicle();
  board::Identity board = identity();
  board.capabilities = 0;
  EXPECT_THROW(board_setup(car, car.node[0], board, 0, 2), ConfigError);
  EXPECT_NO_THROW(board_setup(car, car.node[0], board, 0, 1));
}

TEST(Protocol, AnotherMajorIsRefusedNamingBothANewerMinorNoted) {
  board::Identity board;
  EXPECT_EQ(protocol_refusal(board), "");
  EXPECT_EQ(protocol_note(board), "");
  board.minor = 3;
  EXPECT_EQ(protocol_refusal(board), "");
  EXPECT_NE(protocol_note(board).find("1.3"), std::string::npos);
  board.major = 2;
  EXPECT_NE(protocol_refusal(board).find("2.3"), std::string::npos);
  EXPECT_NE(protocol_refusal(board).find("1.0"), std::string::npos);
  board.major = 0;
  EXPECT_NE(protocol_refusal(board).find("newer firmware"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
