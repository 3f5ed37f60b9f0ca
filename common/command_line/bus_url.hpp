#pragma once

#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace roadbalance {

/// Adds --url, the bus's LCM address, to a program or command; `url`, which must live as long as that, holds
/// default_bus_url() until it is given.
CLI::Option* add_bus_url(CLI::App& app, std::string& url,
                         const std::string& description = "LCM address of the bus");

}  // namespace roadbalance
