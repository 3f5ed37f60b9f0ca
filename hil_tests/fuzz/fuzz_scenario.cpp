#include <cmath>
#include <string>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "sim/scenario.hpp"

// scenario.toml against the demo's car: refused with an error that names the file, or fit to be driven.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  using fuzz::require;
  static const auto vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  static fuzz::Reached scenarios("a scenario");
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    sim::Scenario scenario = sim::Scenario::parse(text, "fuzz.toml", vehicle);
    require(scenario.seconds() > 0 && std::isfinite(scenario.seconds()), "a drive has a length");
    for (const auto& wheel : scenario.wheel)
      require(std::isfinite(std::abs(wheel.unbalance_kg_m)), "an unbalance is a number");
    scenario.scale_to(60);
    require(std::abs(scenario.seconds() - 60) < 1e-6, "a drive can be given another length");
    scenarios.count();
  } catch (const ConfigError& error) {
    require(std::string(error.what()).starts_with("fuzz.toml"), "an error names the file");
  }
  return 0;
}
