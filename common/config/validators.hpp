#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class Validator;
}

namespace roadbalance {

/// Checks of what several commands are given, each saying what is allowed in one line.

/// A number from `low` to `high`, so that NaN is none: it passes every comparison of CLI::Range.
CLI::Validator number_within(double low, double high);
/// Seconds from 0 on.
CLI::Validator seconds_or_zero();
/// Seconds of driving, 1 .. 1000000.
CLI::Validator drive_length();
/// A whole number from 0 on.
CLI::Validator seed_number();
/// A word that stands for a number, which takes its place.
CLI::Validator one_of(std::vector<std::pair<std::string, int>> words);
/// Times real time, 0.001 .. 1000000, or "max".
CLI::Validator rate_of_time();

}  // namespace roadbalance
