#include "common/frontend/unopened_wiring.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using Uris = std::vector<std::string>;
using Sentences = std::vector<std::string>;

const std::string kLine =
    "node front: [[node.line]] wires the encoder of line 1 to GPIO, but no gpio: is among its front ends: "
    "its angle stays unknown";
const std::string kCan =
    "node front: [[node.can]] describes can1, but no can:can1 is among its front ends: what comes there is "
    "not recorded";

/// An encoder on GPIO and two CAN interfaces.
NodeConfig wired() {
  NodeConfig node;
  node.name = "front";
  node.wiring.line = {{.line = 1, .tooth_gpio = 4, .direction_gpio = {}, .zero_mark_gpio = {}}};
  node.wiring.can.resize(2);
  node.wiring.can[0].interface = "can0";
  node.wiring.can[1].interface = "can1";
  return node;
}

TEST(UnopenedWiring, IsSilentAboutWhatIsOpened) {
  EXPECT_EQ(unopened_wiring(wired(), Uris({"usb:1209:0001", "gpio:gpiochip0", "can:can0", "can:can1"})),
            Sentences());
  EXPECT_EQ(unopened_wiring(NodeConfig(), Uris({"usb:1209:0001"})), Sentences());
}

TEST(UnopenedWiring, NamesTheLineAndTheInterfaceThatNobodyReads) {
  EXPECT_EQ(unopened_wiring(wired(), Uris({"usb:1209:0001", "can:can0", "can:can1"})), Sentences({kLine}));
  EXPECT_EQ(unopened_wiring(wired(), Uris({"usb:1209:0001", "gpio:gpiochip0", "can:can0"})),
            Sentences({kCan}));
  // can10 is another interface than can1.
  EXPECT_EQ(unopened_wiring(wired(), Uris({"usb:1209:0001", "can:can10", "can:can0"})),
            Sentences({kLine, kCan}));
}

TEST(UnopenedWiring, IsSilentWhereASimulationOrARecordingStandsInForTheHardware) {
  EXPECT_EQ(unopened_wiring(wired(), Uris({"sim:?seed=1"})), Sentences());
  EXPECT_EQ(unopened_wiring(wired(), Uris({"replay:drive"})), Sentences());
}

}  // namespace
}  // namespace roadbalance
