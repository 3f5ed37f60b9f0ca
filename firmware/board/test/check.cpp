#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {
namespace {

// Constant initialisation: cases of other files are made before anything here would run.
constinit Case* first = nullptr;
constinit Case* last = nullptr;
constinit int failed_checks = 0;
constinit bool silent = false;

void print_place(const char* file, int line, const char* expression) {
  print(file);
  print(":");
  print_number(line);
  print(": ");
  print(expression);
}

}  // namespace

Case::Case(const char* name, void (*run)()) : name_(name), run_(run) {
  (last == nullptr ? first : last->next_) = this;
  last = this;
}

void print_number(std::int64_t number) {
  char digits[24];
  char* at = &digits[23];
  *at = 0;
  const bool negative = number < 0;
  auto rest = negative ? 0 - static_cast<std::uint64_t>(number) : static_cast<std::uint64_t>(number);
  do {
    *--at = static_cast<char>('0' + rest % 10);
    rest /= 10;
  } while (rest != 0);
  if (negative) *--at = '-';
  print(at);
}

void print_decimal(double number) {
  if (number < 0) print("-");
  const double size = number < 0 ? -number : number;
  const auto whole = static_cast<std::int64_t>(size);
  const auto millionths = static_cast<std::int64_t>((size - static_cast<double>(whole)) * 1e6);
  print_number(whole);
  print(".");
  for (std::int64_t digit = 100'000; digit > 0; digit /= 10) print_number(millionths / digit % 10);
}

void fail(const char* file, int line, const char* expression) {
  ++failed_checks;
  if (silent) return;
  print_place(file, line, expression);
  print(" does not hold\n");
}

void fail_equal(const char* file, int line, const char* expression, std::int64_t found,
                std::int64_t expected) {
  ++failed_checks;
  if (silent) return;
  print_place(file, line, expression);
  print(" is ");
  print_number(found);
  print(", not ");
  print_number(expected);
  print("\n");
}

void fail_near(const char* file, int line, const char* expression, double found, double expected) {
  ++failed_checks;
  if (silent) return;
  print_place(file, line, expression);
  print(" is ");
  print_decimal(found);
  print(", not near ");
  print_decimal(expected);
  print("\n");
}

int failures_of(void (*body)()) {
  const int before = failed_checks;
  silent = true;
  body();
  silent = false;
  const int counted = failed_checks - before;
  failed_checks = before;
  return counted;
}

int run_all() {
  int passed = 0;
  int failed = 0;
  for (const Case* test = first; test != nullptr; test = test->next_) {
    const int before = failed_checks;
    test->run_();
    const bool good = failed_checks == before;
    ++(good ? passed : failed);
    print(good ? "passed " : "FAILED ");
    print(test->name_);
    print("\n");
  }
  print_number(passed);
  print(" passed, ");
  print_number(failed);
  print(" failed\n");
  return passed + failed == 0 ? 1 : failed;
}

}  // namespace roadbalance::board::test
