#include <algorithm>
#include <string>

#include "common/config/section.hpp"
#include "common/multibody/description.hpp"
#include "hil_tests/fuzz/property.hpp"

// A description of a vehicle: refused with an error that names the file, or what it names is there.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  static fuzz::Reached descriptions("a description");
  try {
    const Description d = Description::parse(text, "fuzz.toml");
    const auto known = [&](const std::string& name) {
      const auto is_in = [&](const auto& all) {
        return std::ranges::find(all, name, &NamedValue::name) != all.end();
      };
      return is_in(d.coordinate) || is_in(d.parameter) || is_in(d.geometry);
    };
    const auto sound = [&](const Formula& formula) {
      static_cast<void>(formula.value<double>([&](const std::string& name) {
        require(known(name), "a formula names what there is");
        return 1.0;
      }));
    };
    const auto is_place = [](int place, const auto& among) {
      require(place >= 0 && place < static_cast<int>(among.size()), "a name leads to a thing");
    };
    require(!d.coordinate.empty() && !d.body.empty(), "something moves");
    for (std::size_t b = 0; b < d.body.size(); ++b) {
      require(d.body[b].on >= BodyDescription::kGround && d.body[b].on < static_cast<int>(b),
              "a body is on one before it");
      require(d.body[b].angle.size() == d.body[b].axes.size(), "each axis has its angle");
      std::ranges::for_each(d.body[b].position, sound);
      std::ranges::for_each(d.body[b].angle, sound);
      sound(d.body[b].mass);
    }
    for (const auto& point : d.point) {
      if (point.body != BodyDescription::kGround) is_place(point.body, d.body);
      std::ranges::for_each(point.position, sound);
    }
    for (const auto& spring : d.spring) {
      sound(spring.stiffness);
      sound(spring.stretch.formula);
      if (spring.stretch.point[0] >= 0) is_place(spring.stretch.point[1], d.point);
    }
    for (const auto& one : d.stabiliser)
      std::ranges::for_each(one.spring, [&](int spring) { is_place(spring, d.spring); });
    for (const auto& tyre : d.tyre) is_place(tyre.point, d.point);
    for (const auto& plane : d.unbalance) is_place(plane.point, d.point);
    for (const auto& sensor : d.sensor) is_place(sensor.point, d.point);
    descriptions.count();
  } catch (const ConfigError& error) {
    require(std::string(error.what()).starts_with("fuzz.toml"), "an error names the file");
  }
  return 0;
}
