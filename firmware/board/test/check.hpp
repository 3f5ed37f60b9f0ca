#pragma once

#include <cstdint>
#include <type_traits>

/// Tests that run with and without an operating system: on the host and, the same sources, on the board's
/// processor.
///
///     BOARD_TEST(sine_of_zero_is_zero) { CHECK_EQUAL(sine_cosine(0).sine, 0); }
///
/// A failed check is printed and counted, and the test goes on; a failed REQUIRE ends it.
namespace roadbalance::board::test {

/// Writes a text to where the results go; every build has its own.
void print(const char* text);
void print_number(std::int64_t number);
/// With six decimals.
void print_decimal(double number);

class Case {
 public:
  Case(const char* name, void (*run)());

 private:
  friend int run_all();
  const char* name_;
  void (*run_)();
  Case* next_ = nullptr;
};

/// Runs all tests and prints each and the sum; returns how many failed, or 1 if there is none.
int run_all();

/// Runs `body` and returns how many of its checks failed; they count for nothing and are not printed.
int failures_of(void (*body)());

void fail(const char* file, int line, const char* expression);
void fail_equal(const char* file, int line, const char* expression, std::int64_t found,
                std::int64_t expected);
void fail_near(const char* file, int line, const char* expression, double found, double expected);

template <class Value>
constexpr std::int64_t as_number(Value value) {
  return static_cast<std::int64_t>(value);
}

inline void check(bool holds, const char* file, int line, const char* expression) {
  if (!holds) fail(file, line, expression);
}

template <class Found, class Expected>
void check_equal(Found found, Expected expected, const char* file, int line, const char* expression) {
  static_assert(!std::is_floating_point_v<Found>, "floats are near, not equal");
  if (as_number(found) != as_number(expected))
    fail_equal(file, line, expression, as_number(found), as_number(expected));
}

inline void check_near(double found, double expected, double tolerance, const char* file, int line,
                       const char* expression) {
  if (!(found >= expected - tolerance && found <= expected + tolerance))
    fail_near(file, line, expression, found, expected);
}

}  // namespace roadbalance::board::test

#define BOARD_TEST(name)                                               \
  static void name();                                                  \
  static ::roadbalance::board::test::Case case_of_##name(#name, name); \
  static void name()
#define CHECK(expression) ::roadbalance::board::test::check((expression), __FILE__, __LINE__, #expression)
#define CHECK_EQUAL(found, expected) \
  ::roadbalance::board::test::check_equal((found), (expected), __FILE__, __LINE__, #found)
#define CHECK_NEAR(found, expected, tolerance) \
  ::roadbalance::board::test::check_near((found), (expected), (tolerance), __FILE__, __LINE__, #found)
#define REQUIRE(expression)                                              \
  do {                                                                   \
    if (!(expression)) {                                                 \
      ::roadbalance::board::test::fail(__FILE__, __LINE__, #expression); \
      return;                                                            \
    }                                                                    \
  } while (false)
